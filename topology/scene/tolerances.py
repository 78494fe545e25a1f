"""Thresholds of scenes, each with its unit and reason."""

# -- background

NEAR = 0.3
"""Distance [m] from the objects within which their table is looked for: a tall jug seen from above."""

PLANES = 6
"""Planes looked at, the largest first: table, floor, walls, and the sides of what stands about."""

PLANE_FEWEST = 200
"""Points of a plane that may be a table: less is the side of something small."""

STANDS = 0.03
"""Distance [m] from a plane to which what stands on it is seen to reach: noise and a mask's margin."""

OVER = 0.8
"""Share of the objects that must lie over a table or its plane; one or two may stand past its edge."""

TABLE_CELL = 0.05
"""Edge [m] of the cells in which the table's extent hangs together: what is thin hides less of it."""


# -- unnamed

BESIDE = 0.3
"""Distance [m] beyond the objects to which things without a name are looked for: what reaches further is a
wall or a screen."""

RISES = 0.012
"""Height [m] above what carries the objects from which points are of a thing: noise and ripple of a table."""

SAME = 0.008
"""Distance [m] to an object within which points are its own: pixels of a mask that another view has."""

IN_COMMON = 0.15
"""Share of its surface that a piece without a mask has in common with an object, from which it is of that one
and has a mask in another picture: of 93 such pieces 95 % have 0.24 and more, of 90 things none above 0.09."""

REACH = 1.0
"""Distance [m] beyond the objects within which an arm at work on them may meet what stands there."""


# -- robot

ROBOT_NEAR = 0.03
"""Distance [m] from a robot's bodies within which points are its own: covers, cables, calibration."""


# -- matter

MATTER_SPACING = 0.01
"""Edge [m] of cubes whose points are averaged: a dozen pixels of a wall at 1.5 m, one of what flies."""

MATTER_FEWEST = 4
"""Cubes with points in one of `LEAST_PLATE`: a wall fills 16 of them, a line of sight that flies none."""

LEAST_PLATE = 0.04
"""Size [m] to which what is not flat is cut: hollows narrower than that no hand gets into."""


# -- sight

RAYS = 10_000
"""Points of a cloud that end lines of sight, as far as no image shows them already: a table's every 5 mm."""


# -- friction

FRICTION = 0.5
"""Coefficient of dry friction between two things nobody tried: wood, card, glazed ware and tin lie between
0.3 and 0.7."""
