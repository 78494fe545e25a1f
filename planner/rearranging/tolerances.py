"""Thresholds of rearranging, each with its unit and reason, by the module that asks them."""

import numpy as np

# -- moves

NODES = 20_000
"""Of the search trees, after which the best moves so far are taken, with the bound proven by then: half a
minute of what is hard, and a hundred times what 30 things need."""

HARD = 1e-4
"""Weight of what has to happen before what, where passing an object's two events in one moment weighs 1."""


# -- registration

SPACING = 0.004
"""[m] of the points that are matched: twice the noise of a depth camera."""

POINTS = 700
"""At most so many of each cloud: more change a fit by less than noise does."""

HEADINGS = 24
"""Headings tried, 15 degrees apart: a fit settles from half of that."""

KEPT = 6
"""Of the motions tried so many are followed: the four headings of a box, and two that look as good."""

ROUNDS = 30
"""Of matching and moving: a fit settles in half as many."""

FAR = 0.015
"""[m] from where on two points of a fit are not of one place: one of the clouds did not see it."""

MOST = 0.7
"""Share of the points that are matched however far they are, as a fit begins."""

COARSELY = tuple(np.radians(np.arange(-24.0, 25.0, 3.0)))
"""[rad] headings beside a fit that are looked at, and then finely: a handle is as wide."""

FINELY = tuple(np.radians(np.arange(-2.0, 2.5, 0.5)))
"""[rad] likewise."""

BEST = 1e-5
"""[m] by which a settled fit still moves."""

ALIKE = 5e-4
"""[m] by which the residuals of motions that fit alike differ, and points of one cloud moved: a quarter of
the noise."""

AS_WELL = 1e-4
"""[m] by which the residuals of two level motions differ that fit as well: a mug's handle on the wrong side
costs three times as much, noise of so many points half of it."""

LEVEL = 0.25
"""[rad] of tilt that two clouds of a thing that stands on the same face differ by, each seen in part."""

SYMMETRIC = 0.0035
"""[m] by which a thing turned onto itself may be beside itself: a block turned by 15 degrees is by 5 mm."""

ROUND = 0.004
"""[m] by which a round thing may be, at most of its headings: a can of which one side was guessed is by 4."""

BARELY = (-0.035, -0.023, 0.023, 0.035)
"""[rad] turns that no shape shows, by which its points are told how far apart they are."""

ALL_BUT_STRAYS = 0.98
"""Share of the points of a thing that have to be on it again as it is turned onto itself."""


# -- chooser

MOST_LEARNED = 8
"""Moves that fail in one situation until no more is learned of them: each takes seconds of search."""

RISK_STEP = 0.1
"""Chances that something moves, nearer to each other than this, do not say which of two to take first: of
things that touch they are 0.06 and 0.24, by which is the higher."""

RAISED = 0.02
"""[m] above its place where a thing would come to lie: more than two clouds of it differ by."""

TURNS = 8
"""Headings of a round thing that are offered to a hand: 45 degrees apart, and the hand turned half."""


# -- words

CHOICE = 24
"""Places that are tried for a thing until it stays at one."""

BESIDE = 0.04
"""[m] between a thing and what shall lie beside it: a finger gets down between them."""


# -- precedences

NAMED = 3
"""Things that a sentence names; of more it counts the rest, since twelve fill a page."""


# -- possible

DEEP = 0.01
"""[m] by which bodies of which all is given may be in each other: what does not count as a move."""

DEEP_SHARE = 0.03
"""Share of the points of one that are that deep: of two cubes that overlap by half, part of one face."""

OTHER = 0.02
"""[m] between two clouds of one name, once registered, from where on they are of other things: looks of one
thing in a heap and on a table leave 4 mm, and things of one size and another shape 1 cm."""


# -- matching

SIZES = 0.03
"""[m] by which the extents of two clouds of one thing may differ: each may have been seen in part."""

UNLIKE = 0.01
"""[m] between two clouds, once registered, from where on they are of other things: twice what two looks of
one thing leave."""

NEARER = 4e-3
"""Metres of residual that a metre of way counts: a quarter of a metre as much as two looks of a thing differ
by, so that it decides between things of one shape."""
