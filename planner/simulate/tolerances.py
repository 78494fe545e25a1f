"""Thresholds of simulate, each with its unit and reason, by the module that asks them."""

# -- lift

SPEED = 0.08
"""Speed of the straight lift [m/s]."""

LIFT = 0.25
"""Height of the straight lift [m]."""

HIGHER = 0.005
"""Height [m] over everything else at which the rest of the way meets nothing."""

DOWNWARD = 0.7
"""Contact normals steeper than 45 degrees come from something above."""


# -- lifts

SETTLE = 1.0
"""Time [s] that what was disturbed gets to come to rest before it is looked at."""

STILL = 5e-4
"""Speed [m/s] (ten times as many [rad/s] for turns) below which nothing will move a centimetre any more."""

WATCHED = 2.0
"""Seconds that a rebuilt world is watched while nothing is done."""

FRICTIONS = ((0.5, 0.6), (0.4, 0.4), (0.75, 0.75))
"""Friction between objects and with the table, in each of which the question is asked."""

SLOW = 48
"""Steps at the start in which every speed is taken away: overlaps dissolve, nothing is thrown."""


# -- sandbox

SECONDS = 1.5
"""Of simulation: a fall of 4 cm takes 0.1, rolling down a bowl and back half a second."""


# -- rebuild

SLAB = 0.03
"""Thickness [m] of a flat fixed surface that is not the floor."""

EDGE = 0.01
"""Points of a fixed body this close [m] to the board under a top are the board's own edge and underside."""

FEWEST = 12
"""Points of a fixed body beside its tops that make a wall: fewer are noise."""

FILLED = 0.006
"""A hull that has points of other things this deep [m] inside it is not filled by its own."""

INTRUDERS = 6
"""Such points it takes: a few are what masks get wrong at edges."""


# -- seating

CELL = 0.006
"""Edge [m] of the plan cells in which an underside is held against what lies below it: a spoon has five."""

CLEAR = 0.0003
"""Overlap [m] that the simulation itself takes away without anything moving."""

SLACK = 0.003
"""Cells of an underside this much [m] further from what lies below than the closest rest on it: noise."""

NEAR = 0.006
"""A gap [m] up to which a seen underside is set down on what lies below: the noise of two surfaces, twice."""

SEEN_WEIGHT = 3.0
"""Cutting a millimetre of what was seen is worse by this than cutting one of what was invented."""

LEVEL_BONUS = 0.002
"""Things lie on each other: a level cut is preferred to one that saves less than this [m]."""

FAR = 0.25
"""No gap larger than this [m] is closed: things are not taller than that out of sight."""

INSIDE = 0.004
"""The weight must lie this far [m] inside the outline of what carries it, as pushes and noise shift it."""

SURELY = 0.01
"""Further inside [m] it need not be: a centre of mass half guessed is known to a centimetre."""


# -- votes

TRUSTED = 0.6
"""A body that sagged by more than this share of a move (1 cm or 10 degrees) while its rebuilt world came
to rest was rebuilt wrongly: what simulation says about it is believed less."""

NOISE = (0.0003, 0.001)
"""Where bodies may really be (standard deviation [m]), by whole clouds and by what cameras saw."""

# -- seating

STEPS = (0.006, 0.012, 0.025, 0.05)
"""Further gaps [m] that are closed under a hidden underside until the weight lies over what carries it."""

# -- play

PLAYED = 2.0
"""[s] of simulated time: what tips from rest, by a millimetre, is down after one."""

STAYS, STAYS_TURNED = 0.001, 1.0
"""[m] and [deg] that what does not stand moves in simulation at the least: 2 mm afloat fall so."""

FLOOR_BELOW = 1.0
"""[m] below everything where what falls is stopped."""

CONVEX = 0.95
"""Share of its hull that a part of a mesh fills for it to be convex."""
