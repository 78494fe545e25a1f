"""Thresholds of verify, each with its unit and reason, by the module that asks them."""

# -- by_fcl

BY_FCL_SLACK = 2e-5
"""[m] what writing joint values and vertices with six digits moves an arm's hand."""


# -- clouds

NOISE = 0.006
"""[m] three times the noise of a depth camera at a metre: seen points may be this deep in a solid."""

STRAYS = 5
"""Points deeper than that are flying pixels."""

FILLED = 0.012
"""[m] points of an object may stand out from its convex parts: their hollows are cut to 8 mm."""

SHARE = 0.98
"""Of the points that have to."""

LOOKED = 0.02
"""[rad] between the states that are looked at: a hand among neighbours moves a millimetre or two from one to
the next."""


# -- hand

OFF = 0.001
"""[m] and [rad] / 10 that a tool may be off a grasp or a place: inverse kinematics and rounding."""

TILT = 0.15
"""[rad] of what is carried upright: a glass filled to nine tenths does not spill."""

REACHED = 0.008
"""[m] from the pads or the lip to the nearest seen body: noise of its surface."""

NEAR = 0.008
"""[m] bodies that are meant to touch when one is lifted or put down are this close."""


# -- drive

WRITTEN = 1e-6
"""[rad] joint values are written with six digits."""

JUMP = 1e-5
"""[rad] between one segment's end and the next one's start: numbers are written with six digits."""

DRIFT = 2e-3
"""[rad] that positions may differ from the integral of velocities since a motion's start."""

OVER = 0.02
"""Share beyond a velocity or acceleration limit: finite differences of rounded samples."""

AT_REST = 1e-3
"""[rad/s] at a segment's ends."""

STRAYED = 0.001
"""[m] that a spline through the samples may leave the straight way: no more than tracking does."""

QUARTERS = (0.25, 0.5, 0.75)
"""Where between two samples splines are looked at: a cubic is furthest off near one of them."""


# -- rest

ROUNDED = 1e-4
"""[m] what six digits and joggled hulls are off."""


# -- grip and replay

OPENED = 0.001
"""[m] a hand whose pads or cup change by less is the same: two readings of an encoder."""

LIP = 0.001
"""[m] what a plan says of the same width or extension at two places may differ by: rounding."""

CLOSED = 0.003
"""[m] pads further apart than the body between them is wide, as it was seen or completed, touch nothing:
spacing of its points. Bodies stand out beyond what was seen, so that pads mostly close to less."""

FEWEST_BETWEEN = 5
"""Points of a body between the pads: fewer are its edge."""


# -- premises

ROUNDED_SCORE = 1e-4
"""Scores and terms are written with six digits."""

ROUNDED_TIME = 0.002
"""[s] the time of all motions is written with three digits, theirs with six."""

UPWARD = 0.001
"""[rad] directions of up this close are the same: six digits."""

SAME = 0.002
"""[m] bodies made of the same clouds are the same but for what writing them with six digits moves."""


# -- hand, at the end

SHORT = 0.002
"""[m] of the distance that a lift ends at may lack: six digits, and the arm's own rounding."""


FALL = 0.03
"""[m] a fall into a box may be off: things are let go from a little higher where no hand gets down."""


# -- grip

SPACING = 0.002
"""[m] between the points of a body that are looked for between the pads."""


# -- verify

STEP = 0.002
"""[rad] between the states that python-fcl looks at."""

COARSE = 5
"""States of which joint torques look at one: every 0.01 rad."""


# -- outcome

SURFACE = 0.003
"""[m] spacing of points on a body that is held against its place: finer than what counts as a move."""
