"""Thresholds of scenarios, each with its unit and reason, by the module that asks them."""

# -- several scenes

HAND_BETWEEN = 0.12
"""Distance [m] of things between which a hand goes down."""

RIM = 0.022
"""Height [m] of a plate's rim."""


# -- hold

LEANING = 9
"""Of every ten seeds the one that is a can in a leaning bowl: those up to 8 were counted without."""

LEANS = 0.3
"""[rad] by which a bowl leans, and comes back: twice what counts as moved."""

CLEARLY = 0.008
"""[m] by which the weight of that bowl is on the side it comes back to: beyond what statics concedes."""

COMES_BACK = 1.5
"""[s] in which a bowl from which the can is gone comes back, if it does."""

SECOND_ARM = -2.0944
"""Angle [rad] about the middle of the table from the first arm to the second: 60 degrees from two cameras."""


# -- scenario

REACHED = (0.25, 0.38)
"""How far [m] from the origin things lie, along x and y: farther ones are out of the arm's comfortable
reach."""

WATCHED = 8.0
"""Time [s] for which a settled scene is watched: what stands on an edge takes some to begin to fall."""

CREEP = 0.001
"""How far [m] nothing may move in that time: a tenth of what counts as moved."""

TURN = 0.02
"""How far [rad] nothing may turn in that time: a ninth of what counts as turned."""

OVERLAP = 5e-4
"""How far [m] what is laid out by hand may be in each other: facets of round things."""

SLID = 0.02
"""How far [m] a thing may slide as it settles."""

ATTEMPTS = 60
"""Layouts tried for one seed: one in three works out where most does go wrong."""
