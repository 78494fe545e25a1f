"""Thresholds of geometry, each with its unit and reason, by the module that asks them."""

# -- outline

ROUND = 0.06
"""Distance from the circle, as a share of its radius, that an arc may have (rms): a plate's rim, seen from
above and from beside, is that wide; a corner of a box is three times as far from its best circle."""

OPENED = 0.75
"""Greatest radius in lengths of the arc's chord: a quarter of the circle was seen at least."""

FEWEST = 12
"""Points from which a circle is fitted."""


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


# -- thin

BEFORE = 2e-5
"""How far before the first point cells begin [m]: files round to tenths of millimetres, and what is
rounded shall not lie on the edge of a cell, where the last bit of a number decides."""
