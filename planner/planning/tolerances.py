"""Thresholds of planning, each with its unit and reason, by the module that asks them."""

# -- access

TOGETHER = 2
"""At most so many are looked for that only together leave room; more are all said to be in the way."""


# -- moves

BESIDE = 0.05
"""[m] what is closer to an object than this bars a hand: half an open hand's width."""


# -- holding

GRIPS = 12
"""Grips of two arms to try: where a hand has no room beside some of them, it has beside others."""

APART = 0.08
"""[m] between two arms that is room enough: twice what stands between the points they are compared by."""


# -- next_step

CHOICE = 48
"""Placements on or into a thing to choose from: a dozen spots, four headings each."""

MORE_CHOICE = 192
"""Where no more room can be made: also the spots from higher up, each a drop in simulation."""


MORE_PLACES = 96
"""Free places to choose from where nothing that may go can be taken to one of the usual 24."""


# -- next_view

MEETING_GAP = 0.01
"""[m] within which two completed surfaces may meet: what is guessed of them is off by as much."""

UNSEEN = 0.006
"""[m] from every seen point at which a place was not seen: two cells of the upright clouds."""

STANDOFF = 0.55
"""[m] at least from the eye to the middle of things: a depth camera on a wrist sees from 0.3 m on."""

FIELD_OF_VIEW = 0.7
"""[rad] the narrower field of view of common depth cameras, a little less than 45 degrees."""

ELEVATIONS = (0.35, 0.7, 1.1)
"""[rad] above the horizon from where is looked: lower down clutter hides itself, then comes the top view."""

AZIMUTHS = 12
"""Directions around: 30 degrees apart, as the view of a contact changes little in half of that."""

CELL_ANGLE = 0.012
"""[rad] of a cell in which the nearest surface counts: two cells of the upright clouds at the standoff."""

DEPTH_MARGIN = 0.012
"""[m] a place may lie behind the nearest surface of its cell and still be shown: a cell seen aslant."""

LEAST_WORTH = 0.02
"""Share of the doubt below which a view is not worth a motion: a fiftieth."""


# -- order

TOP = 0.005
"""How far [m] below its highest point an object's top begins: noise and unevenness of a flat one are less."""

REMOVAL_RISK = 0.05
"""Chance that a grasp, a lift or a placement of an arm in simulation disturbs something by itself."""


# -- plan

MOST_STEPS = 3
"""For each object: a plan that handles one more often goes in circles."""

TRIES = 4
"""Plans that are held against their check: where one refutes three ways to take a step, more will be."""
