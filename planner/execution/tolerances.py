"""Thresholds of execution, each with its unit and reason, by the module that asks them."""

from topple.planner.tolerances import DISTURBED
from topple.topology.kernels.tolerances import FAR as FAR_BORDER
from topple.topology.statics.tolerances import FARTHEST

# -- attained

BEARS = 0.5
"""Share of a thing's weight that what it is on bears: what leans puts less than half on what it leans on."""

BURDENS = 0.05
"""Share of a thing's weight with which it is held by another one: the solver's contacts tremble by less."""

PRESSED = -0.3
"""Upward part of a push below which the thing pushed lies under what pushes it, and is not held by it."""


# -- execute

TOUCHDOWN = 1.0
"""[N] an object that presses this much on what is below stands on it: the arm goes no further."""

STILL = 0.1
"""[s] before the force at the wrist is taken for the weight of the hand and of what it holds."""

SHALLOW = 0.005
"""[m] before the end of the way in that a grasp still holds: a third of a pad."""

OFF_COURSE = 0.03
"""[rad] an arm this far from its goal is held up by something."""

JOINING = 0.5
"""[s] that an arm which was pushed off its path takes to come back to it: some centimetres, slowly."""

RESUMED = 2
"""Times that a motion is taken up again: who pushes once may push twice, what is in the way stays there."""

FAR = (20.0, 0.0, 0.0)
"""[m] where things stand that somebody took out of the hand: no camera sees them there."""

SHUT = 0.01
"""[m] that pads may stay short of where they are told to open to: more is a hand that does not open."""

LETTING_GO = 3
"""Times that a hand is told to let go before it is taken for stuck."""

AT_HOME = 0.01
"""[rad]."""

SPEED = 0.5
"""Share of the joints' velocity limits on the way home."""

PATH_SAMPLES = 40
"""Samples of the tool's path per segment, for pictures."""


# -- goal_poses

POINTS = 20000
"""Points spread over a body: on a plate 2 mm apart."""


# -- look

FINE = 0.002
"""[m] between the points kept of an object: what three cameras at a metre see apart."""

COARSE = 0.008
"""[m] between those of a table: finer than the foot of what stands on it."""

MOVED = 0.01
"""[m] from where on a thing lies elsewhere than expected: three times the depth noise."""

SEEN_THROUGH = 0.02
"""[m] beyond a remembered point a camera sees: ten times the depth noise."""

GONE = 0.5
"""Share of its points that must be seen through until a remembered thing is believed to be gone."""

THERE = 0.3
"""Share of its points at which a camera sees something where an object should be: one sees half its sides."""


# -- loop

STUCK = 0.005
"""[m] an arm this deep in something when it starts stands in it: depth noise is a third of that."""


# -- rehearsal

SAGGED = 0.01
"""[m] a body that moves this far until it rests was not understood."""

EDGE = 0.02
"""[m] a table reaches beyond what was seen of it."""

RELAX = 40
"""Rounds of relaxing: what overlaps by millimetres is apart after a quarter of a second."""

RELAX_STEPS = 2
"""Simulation steps a round, after which everything is brought to a halt: nothing flies."""


# -- second_look

DOUBTFUL = 0.1
"""Risk of a step from which a second look pays: it takes the arm a tenth of what a failed run takes."""

VIEWS_TRIED = 8
"""Of the best views as many are tried: what the ninth shows is half of what the first would."""

TURNS = 8
"""Turns of the camera about its line of sight that are tried."""


# -- associate

STAYED = 0.03
"""[m] between clouds of one object: it was nudged, or is seen from another side."""

ELSEWHERE = 0.3
"""[m] that an object falls or rolls at most while the arm acts, unlike it may look included."""

LIKENESS = 4.0
"""[m] of way that a metre of difference in spread counts: a box spreads by a quarter of its edge."""

# -- associate

SPACING = 0.005
"""[m] between points that are compared: finer than STAYED."""


# -- masks

SWAPPED = 0.5
"""Share of the way to the object of its own name that a mask is from the one it is taken for."""

SEAM = 0.005
"""[m] from a remembered surface within which a piece of it is seen again: three times the depth noise."""

ALIKE = 0.8
"""Share of a piece that lies there; the rest is noise at its edges."""

AGAIN = 0.5
"""Share of a piece at least that lies where its object was seen before: a lid on a plate ends at its hull."""

PIECE = 0.1
"""Share of a remembered surface that a piece of it covers: less may be a thing at its edge."""


# -- standing

ARM_SPACING = 0.01
"""[m] between points of the arm's surface, and of what is seen of it."""

ARM_NEAR = 0.08
"""[m] from its surface within which what is seen is taken for the arm: as far as it may be aside."""

BESIDE = 0.03
"""[m] from the clouds of things within which nothing is taken for the arm."""

ARM_FEWEST = 150
"""Points of the arm, a centimetre apart, that have to be seen to tell where it stands."""

ARM_FITS = 0.006
"""[m] that half of the points may be off the fitted arm: depth noise and the roundness of its covers."""

ARM_SHIFTED = 0.015
"""[m] aside from where it should be that an arm is seen and not believed: twice what the fit is off by."""

ROUNDS = 15
"""Rounds of matching points with the nearest surface and shifting: it settles in half as many."""

STEADY = 0.02
"""Share of the points by which a direction that none of them shows is held back."""


# -- examine

SOLVED = 0.995
"""Share of the poses that are reached in some state for which inverse kinematics has to find one."""

STATES = 2000
"""States drawn within the joint limits: the share free of self-collision is known to a percent."""

POSES = 1000
"""Poses reached in such states, asked of inverse kinematics: 0.5 % are five of them."""


# -- trial

TRIAL_BLOCK = 0.05
"""[m] side of the block: a toy block."""

TRIAL_MASS = 0.1
"""[kg] of the block, as of wood."""

TRIAL_SHARES = (0.5, 0.6, 0.4, 0.7)
"""Of the reach, how far before the first joint the block stands, the most comfortable first."""

TRIAL_BEARINGS = (0.0, -1.5708, 1.5708, 3.1416)
"""[rad] about the base's z: before it is along x first, though files are drawn otherwise, too."""

TRIAL_LOW = (0.25, 0.4, 0.1)
"""Shares of the tool's heights under which a table stands, of an arm whose tool always points down."""

TRIAL_STATES = 1000
"""States that tell such an arm, and where its tool gets to."""

TRIAL_STRAIGHT = 1e-3
"""[rad] from straight down: what files round."""

TRIAL_HEIGHTS = (0.0, 0.1, -0.1, 0.2)
"""Of the reach, how high it stands above what the arm usually works on."""

TRIAL_TABLE = 0.5
"""[m] side of the table it stands on."""

TRIAL_BESIDE = 0.1
"""[m] to either side that the hand gets to as well: the block has to go somewhere."""

TRIAL_OVER = 0.12
"""[m] above the block that the hand gets to as well: it comes from there, and lifts the block there."""

TRIAL_TURNS = 8
"""Turns of the hand about the vertical that are tried."""

TRIAL_SEEDS = 16
"""Random starts of inverse kinematics for each of them."""

TRIAL_SPACING = 0.004
"""Spacing [m] of the points of the clouds: about a depth camera's at a metre."""


# -- places

ITSELF = 1.5
"""A body turned onto itself has its points that far from others, in units of how far those are apart."""

ROUGH = 0.004
"""[m] more where the body was rebuilt from a cloud: a can of which one side was guessed is as uneven."""


# -- lift monitor

SLOW = DISTURBED / JOINING
"""[m/s] of a lift's first way, while what stays is watched: a picture every 1.3 mm."""

SLOW_WAY = FARTHEST
"""[m] of a lift that is watched: what leans on a thing or hooks it has moved by then."""

HINT = DISTURBED / 2.0
"""[m] by which a thing that is watched may be off: a hint of a move, in time to end it."""

TILE = FAR_BORDER
"""Pixels a side of what is compared: 27 mm at 0.8 m, of which 81 pixels know 0.2 mm."""
