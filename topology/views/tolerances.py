"""Thresholds of views, each with its unit and reason, by the module that asks them."""

import numpy as np

# -- free_space

WIDTH = float(np.radians(1.0))
"""A line of sight speaks for directions this close [rad]: the spacing of a thinned surface from 50 cm."""

MARGIN = 0.012
"""A place is seen to be empty where the surface behind it is this much [m] further off."""

WITNESSES = 3
"""Lines of sight that must agree: at an outline one neighbour alone may belong to the background."""

# -- borders

THIN = 5
"""Pixels along the side of the square in which pixels of a thin part have others of it beside them."""

IN_A_PART = 7
"""Pixels of such a square, at least: a line of flying pixels has five."""

OFF_BORDERS = 0.2
"""Pixels that are another's by depth, for each beside a border, from which masks are said to be off: exact
ones of 67 recorded frames come to 0.04, of rendered piles to 0.12, masks ragged by a pixel to 0.25."""

OFF_REGISTERED = 0.03
"""Of these, from where it is asked whether all masks lie to one side: exact masks come to 0.04 at most."""

STEP = 0.02
"""[m] at a metre and nearer, beyond with its square, from which two pixels beside each other are a step."""

CLEARLY = 1.8
"""Times as many borders must lie on steps: of 67 recorded frames with masks a pixel aside 2.0 to 4.9, with
ragged ones of 1.5 pixels 1.0 to 1.6."""

ENOUGH = 3000
"""Places along borders, of either direction, that tell by how much all masks are off."""

# -- wrong_masks

COLUMNS = 480
"""Columns of a picture that is asked pixel by pixel; of larger ones every so manieth tells as much."""

FLUSH = 0.0025
"""[m] at a metre and nearer, beyond with its square, by which two surfaces may differ and be one: twice a
depth camera's noise, and less than what one could grasp by."""

EVEN = 0.001
"""[m] by which two surfaces may differ along all of their border and be one: noise averages out there."""

SEAM = 8
"""Places, every second pixel, that the border of two masks has at least, to be asked about."""

INWARDS = 1
"""Pixels from a border to the middles of the patches on either side of it, of which most lies within."""

MOSTLY = 0.8
"""Share of a border over which a surface goes on: where it ends, and along an edge, patches tell less."""

CHORD = 2
"""Pixels to either side to the ends of the chord that tells a crease: fewer of a mask's rim go unasked."""

CREASE = 0.004
"""[m] at a metre and nearer, beyond with its square, that a pixel lies behind such a chord where a mask is
cut: more than noise and a bowl's inside come to, and less than a step or a right angle."""

FEWEST = 60
"""Pixels of a piece that is asked about."""

PIECE = 0.1
"""Share of its mask's pieces that one has at least: a handle, a rim or a spout is less."""

MEETS = 0.3
"""Length along which two pieces meet, in square roots of the smaller one's pixels."""

HELD = 0.2
"""Share of a piece's seam within the outline of the one in front, from which that one is hollow."""

# -- agreement

PROBES = 300
"""Points of a picture, of what moves, that are looked up in others, and half as many of the rest."""

SAME_SURFACE = 0.015
"""[m] along a line of sight within which two cameras saw the same surface; the step of the search as well."""

SEARCH_STEPS = 4
"""Steps either way in which it is looked where a view fits: 6 cm, twice what it may be off by."""

ITERATIONS = 6
"""Rounds of Gauss and Newton after that."""

POSE_STEP = 0.004
"""[m] and [rad] by which a pose is moved to see what that changes: pixels lie some 4 mm apart."""

LEAST_SINGULAR = 0.01
"""Motions that change less than this share of what the most telling one does are not made."""

MOST_SHIFT = 0.028
"""[m] from where a camera is said to be to where its picture fits, beyond what its turn explains, at most:
two cameras that are off by a centimetre and a degree each come to 24 mm."""

MOST_TURN = float(np.radians(4.0))
"""[rad] by which it is turned then, at most: two such cameras come to half."""

AGREEING = 0.85
"""Share of what two cameras measured that is the same where they are said to be, from which a view
is not moved: 4 cm aside it is two thirds at most."""

MOST_CONFLICT = 0.4
"""Share of what two cameras measured that one looked through, at most: edges and a degree come to half."""

FEWEST_COMMON = 60
"""Points that two cameras measured from which they can be compared."""

FAR_APART = 0.1
"""[m] between what two pictures show of an object from which these are two places."""
