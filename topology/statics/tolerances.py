"""Thresholds of statics, each with its unit and reason, by the module that asks them."""

import numpy as np

# -- contact

SOLE = 0.03
"""Height [m] above the table up to which an underside is looked at."""

BELOW = 0.01
"""Noise [m] by which the middle of something thin may lie below the top it stands on."""


# -- equilibrium

CONE_EDGES = 6
"""Edges of the pyramid inside the friction cone: six lose at most 13 % of the friction."""


# -- falling

FARTHEST = 0.02
"""Displacement [m] at which a body is followed no further: twice what counts as a move."""

TURNED = 0.35
"""Turn [rad] at which a body is followed no further: twice what counts as a move, and nearly linear."""

SEATED = 0.0005
"""Gap [m] up to which two whole surfaces touch: half of what a thinned cloud is off."""

SUNK = 0.011
"""Displacement [m] that counts as a fall: a move is a centimetre, and linear answers are a tenth off."""

TILTED = float(np.radians(12.0))
"""Turn [rad] that counts as a fall: a move is 10 degrees."""

REACH = 0.02
"""Gap [m] up to which surfaces are looked at: what catches a body that sinks by a centimetre as it tilts."""

FREE = 1e-3
"""Share of its weight that holds a body for nothing: motions that gain no energy, such as a ball's spin,
are none."""

ROLL = float(np.radians(9.0))
"""Angle by which round things may roll on each other towards a contact without having moved."""


# -- gravity

HANGING = 0.4
"""Share of the weight that nothing carries from which `up` is doubted: hidden undersides leave less open."""

BETTER = 0.3
"""By how much that share must fall with another direction for it to be the likely one."""

FAR_OFF = 2.0
"""[m] from each object to all others from which it is asked whether lengths are in metres: further than
anything that is held by what no camera saw in a scene within an arm's reach."""

APART = float(np.cos(np.radians(30.0)))
"""Cosine of the angle from which a direction is another one: a table tilted by less is still a table."""

ALONG = float(np.cos(np.radians(3.0)))
"""Cosine of the angle within which a direction found on noisy points is told as an axis of the frame."""


# -- grounds

FLAT = 0.003
"""A fixed cloud this thin [m] (standard deviation) is a table top, and is treated as a plane."""

MARGIN = 0.05
"""A table goes on this far [m] beyond what was seen of it: one camera sees it cut off by objects."""

EDGE = 0.02
"""The same for a top whose edges were seen: the spacing of its points."""


# -- hidden

PLAN_CELL = 0.012
"""Edge [m] of the plan cells in which an underside is held against what lies below it."""

DEEPEST = 0.12
"""Largest gap [m] that is closed: the height of a cup, whose foot may be hidden all the way."""

LEVEL = 0.006
"""Cells this much [m] further apart than the loaded ones belong to the same hidden contact."""

CARRIED = 0.01
"""Share of its weight from which a hidden point counts as carrying."""


# -- holding

STEPS = 200
"""Steps in which forces on a large island are found, or not at all: mostly fifteen, up to all where a few of
them carry all."""


# -- matter

DENSITY = 700.0
"""Density [kg/m³] of what nobody weighed: a full packet, wood, a half-empty bottle."""

DENSEST = 25_000.0
"""Density [kg/m³] beyond that of any matter on a table: osmium has 22,600."""


# -- mesh_contact

ON_FACE = 1e-6
"""Share of a triangle's sides by which a point may be beyond them and over it: rounding."""

LIKE_NEAREST = 6e-4
"""Gap [m] beyond the least one around at which a round body still touches: facets are as far from round. A
ball of 3 cm then stands on nothing steeper than 12 degrees."""

NEAREST_WITHIN = 0.2
"""Of the smaller body's size is how far around a point others are asked for the least gap."""

FACING = float(np.radians(2.0))
"""Angle [rad] between surfaces up to which they are parallel, and carry wherever their gap is none."""

PATCH_CORNERS = 16
"""Corners that are kept of a flat patch: of a round foot they leave out 2 % of its radius."""


# -- rest

GUESSED = 0.3
"""The same where bodies were completed: a centre of mass half guessed is known to a centimetre."""

WALL = 0.005
"""Thickness [m] taken for the walls of hollow things when their weight is guessed."""

SHELL_CELL = 0.004
"""Edge [m] of the cells that a surface's area is counted by: wider than most clouds are spaced."""

LEVER = 0.03
"""Lever [m] by which torques are compared with weights: `UNSTEADY` then is 3 mm beyond the last support."""

UNSTEADY = 0.1
"""Missing share of a weight beyond which something moves: contact points are known to millimetres."""

TILT = float(np.tan(ROLL))
"""Slope by which an object may sink towards a second support without having moved: a move is 10°."""


# -- support

LEAN = float(np.cos(np.radians(45.0)))
"""A contact whose normal is further than 45 degrees from up is leant on, not stood on."""

BESIDE = float(np.sin(np.radians(12.0)))
"""One whose normal is nearer than 12 degrees to level carries nothing: where only edges were seen, as of two
blocks side by side, normals are known to some 7 degrees."""

CANCELLED = 0.05
"""Mean of unit normals below which they cancel each other, and what is left of them is noise."""


# -- sweep

KEPT_PAIRS = 1000
"""Pairs of bodies of which what was worked out is kept, a kilobyte each."""

LIFT = 0.25
"""Height of the lift [m]: what is higher than this above an object is not met."""

PLACES = 16
"""Places that are kept of where one body hangs over another, spread over all of them."""

SHOWN = 0.01
"""A picture shows a place if what it saw there is this near in depth [m]."""

SWEEP_CELL = 0.004
"""Edge [m] of the cells of a plan view: one thinned sample per cell of a horizontal surface."""

CLEAR = 0.004
"""A surface this much [m] higher than another is above it and not beside it: noise and spacing."""


# -- way out

OVERHEAD = 0.45
"""[m] over an object within which something fixed bars the way up: a hand with its wrist and a short lift."""

WALL_CELL = 0.02
"""Edge [m] of the cells in which something fixed is looked for: wider than clouds are spaced."""

COVERED = 0.5
"""Share of an object from which a board is over it: strays of ragged masks are over two fifths at most."""

WALLED = 0.25
"""Share of the way before an object from which what stands there is a wall: strays are fewer."""

WALL_MARGIN = 0.02
"""[m] below a board and above what bears an object within which no wall is looked for: edges of boards."""


# -- faces

SAME_FACE = float(np.cos(np.radians(20.0)))
"""Cosine of the angle within which normals of a patch are of one face."""

LEVEL_FACE = float(np.cos(np.radians(10.0)))
"""Cosine of the angle to up within which a face is level: on slopes the gaps of clouds say less."""

LOWEST_SHARE = 0.01
"""Share of the points of a cloud that may be lower than it reaches: strays."""

ROUND_FACE = 3e-4
"""Distance [m] between the quartiles of a face's points, besides the noise, from which it is round."""

FLAT_SHARE = 0.5
"""Share of the points of a patch that have to be of one face for it to be flat."""

FACE_BAND = 0.012
"""[m] along the normal within which points may be of a face: how far faces in each other are looked for."""

FACE_CELL = 0.008
"""Edge [m] of the cells in which two faces are held against each other: a few points of each."""

FACE_CELLS = 3
"""Cells that say how far they are apart: fewer are an edge."""

FACE_EVEN = 0.002
"""Spread [m] of these gaps up to which faces lie on each other."""

ON_FACE_PLANE = 0.0015
"""[m] from a face, besides twice the noise, within which points are of it."""
