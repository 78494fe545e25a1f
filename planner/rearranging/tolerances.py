"""Thresholds of rearranging, each with its unit and reason, by the module that asks them."""

# -- moves

SECONDS = 30.0
"""[s] after which the best moves so far are taken, with the bound proven by then."""


# -- discs

GRID = 90
"""Places looked at along each edge of a workspace: a tenth of the radius of the discs that fill it."""


# -- cubes

HELD = 1e-6
"""Missing share of a weight that still counts as carried: what a solver leaves."""
