"""Thresholds of motion, each with its unit and reason, by the module that asks them."""

# -- cartesian

TURN = 0.05
"""[rad] between waypoints where the tool also turns."""


# -- collision

EDGE_STEP = 0.05
"""[rad] largest joint change between two checked states of an edge, the usual resolution."""


# -- planner

CLEARANCE = 0.005
"""[m] kept to obstacles on the way: depth noise and tracking error, each some 2 mm."""

RELAXED = (1.0, 0.2, 0.0)
"""Shares of the clearance that are tried in turn: none is better than no motion."""

PATIENCE = (0.35, 0.55, 1.0)
"""Share of the budget that is used up to each."""


# -- trajectory

CORNER_SHARE = 0.25
"""Of the acceleration limits, for the jump of direction at a waypoint."""


# -- upright

STEP = 0.01
"""[rad] between states of an edge whose tilt is looked at."""

WITHIN = 0.6
"""Share of the tilt that states are turned back to: the rest is for the edges between them."""
