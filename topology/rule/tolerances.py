"""Thresholds of rule, each with its unit and reason, by the module that asks them."""

# -- facing

PLACES = 256
"""Places looked at on a hull: one in 1.5 cm of a box with edges of 10 cm."""

DEPTH = 0.015
"""Places this much further from the other hull than the closest one face it, too [m]: round things do."""

COVERED = 2.0
"""Spacings of a cloud within which a place of its hull has a seen surface."""

NOISE = 0.006
"""How far [m] noise of a depth camera puts points of one surface apart."""

SETTLED = 0.95
"""Share of the facing places that must be settled: a stem or a foot takes a twentieth of an underside."""


# -- inferred

CLOSE = 0.02
"""Gap [m] from which objects carry each other no more: twice what a search for contacts allows."""


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

FINE = 3000
"""Points per object that the closest region may have; contact patches beyond that are thinned."""

FAR = 2.0
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
