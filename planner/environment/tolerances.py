"""Thresholds of the environment, each with its unit and reason, by the module that asks them."""

# -- hands

FALLEN = -0.1
"""Height [m] over the table's top below which a thing is off its edge, and nobody's any more."""

NEAR = 0.05
"""How far [m] about the middle of a container what lies there is below what is put into it."""

CLEARANCE = 0.005
"""Height [m] above it from where a thing is let go: a hand opens as low as it can."""

SETTLE = 3.0
"""Time [s] at most until all is at rest."""


# -- picking

EFFORT = 0.05
"""What taking a thing costs: twenty needless takes are as bad as one thing that is disturbed."""


# -- view

FARTHEST = 5.0
"""Distance [m] from the middle of the table at which nothing is."""
