"""Thresholds of geometry, each with its unit and reason, by the module that asks them."""

# -- outline

INSIDE = 1e-6
"""Depth [m] inside an outline that no rounding explains."""

ROUND = 0.06
"""Distance from the circle, as a share of its radius, that an arc may have (rms): a plate's rim, seen from
above and from beside, is that wide; a corner of a box is three times as far from its best circle."""

OPENED = 0.75
"""Greatest radius in lengths of the arc's chord: a quarter of the circle was seen at least."""

FEWEST = 12
"""Points from which a circle is fitted."""


# -- plane

DRAWS = 200
"""Planes drawn: one holding 40 % of the points is missed by all draws with probability 1e-6."""

LEVEL_DRAWS = 4000
"""Draws of which the level ones vote: one in thirty is on one of a shelf's boards."""

LEVEL = 0.97
"""Cosine of the largest angle of a level plane with the horizontal one: up is known to 14 degrees."""

ENOUGH = 4000
"""Points that tell a plane or how a cloud lies; more change the answer by less than the noise."""

MANY = 40_000
"""Points among which neighbours are looked for."""

ON_PLANE = 0.02
"""How far [m] a seen table strays from its plane: depth noise and a board that bends."""

FLAT_SHARE = 0.4
"""Share of its points on one plane that makes a thing flat: a table seen past its clutter is above 0.9, a
bowl or a shelf of boards below 0.4."""


# -- round

STRAY = 0.02
"""Share of the points that may lie off a body: flying pixels at its outline."""

LARGEST_RADIUS = 0.1
"""Radius [m] beyond which a surface is a wall with a curve in it and no body a hand could take."""

LARGEST_RESIDUAL = 0.1
"""Share of the radius that points are off a ball or a cylinder (root mean square): fruit is no ball."""

LEAST_CAP = 0.35
"""Depth of a seen cap in radii from which it says how large its ball is: 50 degrees to each side."""

LEAST_ARC = 2.0
"""Seen part of a cylinder's round [rad] that says how large it is."""

STRETCHES = (1.25, 1.5)
"""Lengths of spheroids in their thickness: lemons, pears and eggs."""

SPHEROID_PENALTY = 1.3
"""A spheroid has three numbers more than a sphere: its error counts so many times."""

BELOW_FLOOR = 0.25
"""Share of its radius by which a round body may reach below the floor: a dome reaches deeper, and is none."""

BETTER_THAN_BOX = 0.8
"""A round body has to explain the points with less than this share of the error that the best box leaves."""

COARSE = 0.01
"""Spacing [m] at which a fit's lowest point is looked for."""


# -- thin

BEFORE = 2e-5
"""How far before the first point cells begin [m]: files round to tenths of millimetres, and what is
rounded shall not lie on the edge of a cell, where the last bit of a number decides."""


# -- pieces

LINKED = 0.015
"""Points this close belong together [m]."""

PIECE_FEWEST = 12
"""Points of a piece that counts: fewer are noise."""

SPARSE = 0.04
"""[m] between neighbours above which points are strays: a hundred in the room over a table are 10 cm apart,
500 points of a wall of a third of a square metre 3 cm."""
