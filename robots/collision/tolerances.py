"""Thresholds of collision, each with its unit and reason, by the module that asks them."""

# -- convex

REDUCTION = 0.004
"""[m] vertices this close to the hull of the others go; the error is kept as a margin."""


# -- pieces

MOST = 8
"""Pieces of one surface: each costs every collision check."""

GAIN = 0.2
"""Share of the whole volume that a cut has to save: of a fork most goes, of a tube little."""

FINE = 0.02
"""The same where a few millimetres are what a hand holds in."""

IN_PLANE = 1e-6
"""[m] a face this near to a plane is a side of what is behind it, whose other faces meet it."""

PLACES = 5
"""Places where an axis is cut, at the vertices nearest to them: steps have vertices."""

SAMPLE = 300
"""Triangles that a cut is judged by, which takes a millisecond; all of them are cut."""


# -- separation

ROUNDING = 1e-5
"""What single precision may lose [m] on coordinates of a few metres."""
