"""Thresholds of rule, each with its unit and reason, by the module that asks them."""

# -- cavity

AZIMUTHS = 24
"""Directions in which a wall is looked for: one of them is 2 cm of a 16 cm bowl."""


# -- facing

PLACES = 256
"""Places looked at on a hull: one in 1.5 cm of a box with edges of 10 cm."""

DEPTH = 0.015
"""Places this much further from the other hull than the closest one face it, too [m]: round things do."""

COVERED = 2.0
"""Spacings of a cloud within which a place of its hull has a seen surface."""

SETTLED = 0.95
"""Share of the facing places that must be settled: a stem or a foot takes a twentieth of an underside."""


# -- inferred

CLOSE = 0.02
"""Gap [m] from which objects carry each other no more: twice what a search for contacts allows."""


FEW_IN_PLAN = 1000
"""Points of each holder that are looked at first: the middle of what stands is mostly well amid them."""


# -- relate

MOST_OBJECTS = 500
"""More things than any shelf or bin holds: of so many there are 125,000 pairs to be told, a second's work."""

NEAR_EACH = 20
"""Others near each object on average: each such pair is looked at closely for some milliseconds. In a heap
there are fifteen."""


# -- robust

WALL = 600
"""Points that stand for a container's wall: 24 directions, some 25 each."""

CONTENT = 400
"""Points of the content that are looked at: one in a hundred still shows."""


# -- surface

COARSE = 1500
"""Points a cloud is thinned to, about: an object's surface every 3 mm to 5 mm."""

LARGEST_CELL = 0.01
"""Edge of a cell [m] of a table or shelf: what stands before it leaves slivers of it two or three cm wide."""

FINE = 1500
"""Points per object that the closest region may have; contact patches beyond that are thinned."""

FAR = 4.0
"""Widths of the cells around both surfaces, from which the mean points tell their distance: to 2 %."""

FILLED = 0.2
"""Share of the usual number of points around a place of a surface: one seen at 78 degrees from its normal."""

AROUND = 2.2
"""Radius, in cells, within which a surface has some fifteen other cells, a line four with fewer points."""

BESIDE = 1.8
"""How far, in cells, the edge of a surface may reach beyond its last filled cell."""

FEW = 5
"""Mean points below which a separate piece is stray whatever its shape."""

BREAK = 4.0
"""A gap of this many typical spacings separates two pieces."""

PROBES = 32
"""Points that bound the distance of two surfaces before all are looked at."""

CANDIDATES = 128
"""Points whose distance to the other surface is measured with planes, the nearest to its samples."""

PATCH = 8
"""Neighbours that make a local plane."""

LINKS = 6
"""Neighbours through which pieces of a cloud hang together."""
