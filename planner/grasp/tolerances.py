"""Lengths and limits of grasping, each with the reason for its value."""

from dataclasses import dataclass


@dataclass(frozen=True)
class GraspTolerances:
    """Lengths in metres, angles in radians.

    Attributes:
        spacing: Clouds are thinned to this; a quarter of a finger pad's width keeps every edge a pad feels.
        hidden_spacing: Grid on inferred sides: finer than a finger is thick.
        hidden_gap: An inferred side counts where nothing was seen within it: depth noise and thinning.
        normal_radius: Surface normals are fitted within it: wide enough to average 1-2 mm of depth noise,
            narrower than the curvature of fruit.
        side_clearance: Free room wanted beside each pad on the way in: depth noise (2 mm), the arm's
            tracking error (1-2 mm) and the pixel at a mask's edge (2 mm).
        least_side_clearance: Below this the fingers would be driven into the object they are to pass.
        under_clearance: Distance kept between the finger tips and what lies beneath.
        stray_points: So many points in the way count as noise (flying pixels), not as a thing.
        depths: Tried depths of the finger tips below the object's top between the pads, least first.
        tilts: Tried angles between the approach and the way out reversed, about the closing axis.
        steep_tilts: Tried where those find fewer than `enough` grasps.
        enough: So many grasps leave the arm a choice.
        reach: Only points this close to a grasp can touch the hand.
        way: Straight way in before a grasp, which is to have been seen empty: from over what is beside it.
        into_solid: A finger this deep in the object's own hull would be driven into it: twice the depth
            noise, and more than hulls stand out from a surface between its points.
        friction: Coefficient assumed between pad and object (rubber on glazed ceramics or steel: 0.5-0.8).
        lever: Distance between the pads' line and the centre of mass at which half the score is gone: a
            0.1 kg object then turns in the pads of a 20 N gripper.
        seal_tolerance: Unevenness under a suction cup's lip that its bellows takes up.
        least_seal: Suction scored below this would leak or peel off.
        sure: Score from which a suction grasp is sure to hold: a good seal near the centre of mass.
        enough_sealed: With so many sure suction grasps no pinch is looked for.
        seal_tilt: Angle between a cup, which is set square on a surface, and straight down: beyond it most of
            the weight pulls along the lip.
    """

    spacing: float = 0.004
    hidden_spacing: float = 0.005
    hidden_gap: float = 0.007
    normal_radius: float = 0.010
    side_clearance: float = 0.008
    least_side_clearance: float = 0.004
    under_clearance: float = 0.0015
    stray_points: int = 2
    depths: tuple[float, ...] = (0.004, 0.006, 0.008, 0.012, 0.018, 0.025, 0.035, 0.045)
    tilts: tuple[float, ...] = (0.0, 0.26, -0.26)
    steep_tilts: tuple[float, ...] = (0.52, -0.52)
    enough: int = 20
    reach: float = 0.16
    way: float = 0.08
    into_solid: float = 0.005
    friction: float = 0.5
    lever: float = 0.05
    seal_tolerance: float = 0.0015
    least_seal: float = 0.2
    sure: float = 0.6
    enough_sealed: int = 4
    seal_tilt: float = 0.7


GRASP_TOLERANCES = GraspTolerances()

# -- fingers

SHARES_ASKED = 8
"""Of the points in fingers, asked one after the other whether they stand in a body: the first tell most."""

WAY_LAYERS = 17
"""Along the way in, where it is asked what was seen: 5 mm apart, as deep as a finger in what is not there."""

# -- frames

CENTRAL = 0.03
"""Around the centre of mass, where a grasp hardly turns in the hand [m]."""

LEANING = (0.1, 0.65)
"""Sine of how far a side leans: less is upright to a hand, more is no side."""

ALIKE = 0.2
"""Normals closer than this are of one side: three times their noise [rad]."""

FRAMES_FLAT = 0.2
"""Share of the steep surface that a flat side makes up: of a can's it is an eighth."""

ENOUGH = 2000
"""Normals that tell the sides of a body: a share of a fifth is then off by two percent at most."""


# -- judge

FEW = 50
"""Of so many points between the pads the outermost one may be stray, as in a search for grasps."""

WIDEST = 0.3
"""To either side of a hand, as far as it is told how wide a thing is: beyond any jaw [m]."""


# -- given

MOST_GIVEN = 60
"""Grasps of an object that a step may try, of those given: as many as a search of our own finds."""


# -- hand

RELEASE_GAP = 0.01
"""Pads this much wider than what they held let go of it [m]."""

UPRIGHT = 0.8
"""Upward share of the closing direction beyond which one finger is below what the hand holds."""

OPENING_STEP = 0.005
"""Openings are rounded up to it [m], so that grasps share their checks."""

HAND_REACH = 0.16
"""What is further from the tool's origin does not meet what is grasped [m]."""


# -- load

WEIGHT_SPREAD = 0.42
"""Standard deviation of a guessed weight's logarithm: a factor of two in 90 of 100."""

HOLD_SPREAD = 0.2
"""The same of what holds a weight that is known: pads grip glaze, card and steel differently."""

STRONGEST = 0.8
"""Friction of rubber pads on an untried surface, at most."""


# -- pads

NORMAL_BIAS = 0.15
"""Normals next to a silhouette average in what lies before it, 3 mm of a can: 9 degrees [rad]."""

SLOPED = 0.2
"""A level top has normals square to the closing direction, give or take 10 degrees of noise."""

SLOPE_LENGTH = 0.01
"""Below the tips, where the object's widening tells a slope from noise [m]."""

EDGE = 0.003
"""From the outermost point, what a pad touches first [m]."""

ROD = 0.004
"""[m] along the pads: what is shorter there is a rod along the approach, and has no outline."""

SLICES = 4
"""Slices of an outline along the pads."""


# -- pinch

OWN_MARGIN = 0.0005
"""Fingers may come this close to the object they take [m]."""

PINCH_BRUSH = (0.006, 0.01)
"""Beside and below the hand: less room than this halves the clearance term [m]."""

PINCH_TIGHT = 0.4
"""The clearance term where something is that close."""


# -- rims

LEANS = (0.0, 0.2, 0.4)
"""Of the approach against the sheet [rad]: just within the friction cone."""

PATCH = 0.02
"""Of the sheet, from its edge inwards, that its slope is taken from [m]."""

RIMS_FLAT = 0.15
"""Variance across a sheet, relative to that along its edge: what a plate's flange stays below."""

STEEPEST = 0.6
"""Upward share of a sheet's normal: fingers reach both sides of a steeper one from above."""

FEWEST = 8
"""Points a slope is taken from."""

DIRECTIONS = 16
"""Directions around the object: with 8 a plate among four neighbours may have none between two of them."""


# -- room

ASIDE = 0.12
"""[m] beside the approach: hands are no wider, and what is further out is the arm's to avoid."""

FINE = 0.006
"""[m] cells of what pads may hold: a third of a pad's width, so that few are cut by its bounds."""

PAST_PADS = 0.005
"""[m] beyond the pads' ends, where what they hold may begin: depth noise and a finger's play."""

AT_LIP = 0.01
"""[m] before and behind a cup's lip, where what it takes may lie: depth noise and its bellows."""


# -- suction

SUCTION_BRUSH = 0.006
"""Beside and below the hand: less room than this makes the clearance term `TIGHT` [m]."""

SUCTION_TIGHT = 0.4
"""The clearance term where something brushes the lip that close."""

LEAST_INSIDE = 12
"""Points of an eighth of what is within the lip: the median of as many is good to 0.5 mm of noisy depth."""

RING = (0.8, 1.4)
"""Of the lip's radius: where it lies, and the 2 mm around it that rubber spreads over."""


# -- widen

SHARES = (1.0, 0.5)
"""Of the way from the opening that was found to the largest, widest first."""

# -- cells

CELLS_EDGE = 0.012
"""[m] of a cell: half as large, a frame takes twice as long, since there are more of them."""

GROUP = 0.1
"""[m] grasps within cubes of this share what is near them."""


# -- foreign

HAND_TO_PADS = 0.1034
"""Panda hand's origin to the middle between its pads, the frame of two of the formats [m]."""

PAD_HALF = 0.01
"""Half a pad's length: GraspNet's depth reaches to the finger tips [m]."""


# -- pinch

ROUGH = 1e-5
"""More than single precision is off by at the size of a hand [m]."""
