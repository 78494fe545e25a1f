"""Thresholds of placement, each with its unit and reason, by the module that asks them."""

# -- base

DISTANCES = (0.45, 0.55, 0.65)
"""From the middle of what is handled: an arm works best at two thirds of its reach [m]."""

FOOT = 0.15
"""Nothing may stand this close to the middle of the base [m]."""

HOVER = 0.10
"""A hand this far above an object's top must be reachable, to take it and to carry it away [m]."""

STEP = 0.02
"""What rises less above the level the arm stands on is no hindrance to its foot [m]."""

DIRECTIONS = 16
"""Directions from which an arm's base is tried."""

SEEDS = 6
"""Random starts of inverse kinematics for each."""


# -- drops

CLEAR = 0.01
"""[m] beside what lies in a container: more than two bodies and a drop are off by."""

OTHER_FACE = 0.25
"""[rad] a face found on noisy points is that far from the one it stands on."""

QUIET = 0.8
"""Of that may be pushed where room could be made instead: taking things out stirs a heap more."""


# -- free_space

SKIN = 0.01
"""What reaches no further above a top is the top itself, or below it: depth noise [m]."""


# -- lowered, and what slides in and out of shelves

OFF_BOARD = 0.02
"""What slides is lifted by so much [m]: it does not drag, and boards are no more uneven."""


# -- placement

SPARE_SHARE = 8
"""Of the places one in so many is for each attitude that comes off worse: a hand may not get down in the
better ones."""

KEPT = 80
"""Best places of each attitude and heading that are compared."""


# -- proof

SHIFT = 0.015
"""[m] a thing may move until it rests: its body is a guess from noisy points."""

TURN = 0.35
"""[rad] and turn: it lies down on the face next to the one that was meant."""

PROOF_SPARE = 2.0 / 3.0
"""Of these limits a plan may use: the same drop of numbers rounded to a millionth ends apart."""


# -- resting

FLATNESS = 0.2
"""Thickness over length below which a thing lies flat by itself, as cutlery does."""

MOST_TILT = 0.35
"""What turned over by so much comes to lie on another face [rad]."""

MOST_RESTS = 3
"""Attitudes of a thing that are tried: each takes its share of the places."""

ALIKE = 0.2
"""[rad] attitudes closer than this are one to a hand."""

FLAT_SHARE = 0.5
"""Of its thickness: what of a bent thing counts as its underside."""


# -- stacking

CELL = 0.005
"""Grid of heights: half a finger's thickness [m]."""

GAPS = 3
"""Cells over which gaps between points are closed."""

CONTACT = 0.005
"""Cells this close to touching carry: depth noise of both surfaces [m]."""

INSET = 0.2
"""On: the centre of mass keeps this share of the smaller half width from the carrying face's edge."""

SPOT = 0.012
"""Placements this close are at one spot: less than the least difference of two drops [m]."""

HEADINGS = 4
"""Kept of one spot."""

GENTLE = 0.04
"""Falls up to here do no harm: what falls deeper bounces [m]."""

YAWS = 8
"""Headings that are tried."""


# -- away

BIN_SIZE = (0.40, 0.30, 0.20)
"""[m] of an open box that is stood beside the arm: a crate as warehouses have it."""

BIN_WALL = 0.01
"""[m] thickness of its walls and floor."""

BIN_BESIDE = (0.50, 0.60, 0.45)
"""[m] from the arm's foot to the middle of such a box, where it works freely."""

BIN_SPOTS = ((0.0, 0.0), (0.15, 0.0), (-0.15, 0.0))
"""Shares of its size from its middle at which things are let go."""

HEIGHTS_IN_BIN = (0.04, 0.09, 0.14)
"""[m] above its floor: what lies there may be higher, and a hand does not get down everywhere."""

LIFT_CLEAR = 0.15
"""[m] from everything when a lift ends: room for whatever takes over."""

RAISED, HIGHEST = 0.10, 0.80
"""[m] a lift rises at least, and at most."""

AHEAD = 0.40
"""[m] before the arm's foot: there it can hold most things up."""

TOWARDS = (0.0, 0.35, 0.7, 1.0)
"""Shares of the way there at which a lift may end."""

LEVEL_WITH = 0.03
"""[m] that a table may be seen off the level of an area that is vouched for on it."""

SLAB = 0.01
"""[m] thickness of a level area that is vouched for."""
