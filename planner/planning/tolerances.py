"""Thresholds of planning, each with its unit and reason, by the module that asks them."""

# -- access

TOGETHER = 2
"""At most so many are looked for that only together leave room; more are all said to be in the way."""


# -- moves

BESIDE = 0.05
"""[m] what is closer to an object than this bars a hand: half an open hand's width."""


# -- next_step

CHOICE = 48
"""Placements on or into a thing to choose from: a dozen spots, four headings each."""

MORE_CHOICE = 192
"""Where no more room can be made: also the spots from higher up, each a drop in simulation."""


# -- order

TOP = 0.005
"""How far [m] below its highest point an object's top begins: noise and unevenness of a flat one are less."""

REMOVAL_RISK = 0.05
"""Chance that a grasp, a lift or a placement of an arm in simulation disturbs something by itself."""


# -- plan

MOST_STEPS = 3
"""For each object: a plan that handles one more often goes in circles."""
