"""Thresholds of decide, each with its unit and reason, by the module that asks them."""

# -- assumptions

DEEP = 0.01
"""Depth [m] below another body's hull from which clouds overlap: noise and spacing reach half of it."""

SHARE = 0.1
"""Share of an object's points that lie so deep: a few strays, or a corner of a mask, are less."""

BELOW = 0.01
"""How far [m] below the table's surface the top of an object lies that is said to be below it."""

SUNK = 0.02
"""Depth [m] to which an object reaches below the table's surface that is said: noise reaches half of it."""

LEAST = 1e-5
"""Volume [m³] of what is reckoned with at least: of thin things little more than a face may be seen."""


# -- dependency

COUNTS = 0.45
"""Chance from which a dependency counts: what is overlooked falls, what is made up costs a removal."""

HOLD_EACH_OTHER = 0.8
"""Chance that either of two falls without the other where several cameras say so of both: 21 of 24 do."""

CARRIES = 0.1
"""Upward part of a contact normal above which the lower body carries some of the upper one: 6 degrees."""

RESTS = 0.7
"""Upward part of a contact normal above which the upper body rests on the lower one: 45 degrees."""

PRESSED = -0.3
"""Upward part of a contact normal below which what is taken away lies on what is left."""

BOARD = 0.01
"""What lies this far [m] below a top is under its board: thin things on it are not, despite noise."""


# -- rates

MEETING = 0.005
"""Gap [m] up to which two surfaces count as one contact in a question of what would move."""

CERTAIN = 0.98
"""Reasoning is never believed more than this."""


# -- sequence

SURE = 0.99
"""No chance counts for more than this: what is certain must not hide all else."""

EFFORT = 2400
"""Continuations looked at per step: with 300 partial orders all there are of eight objects."""

LEAST_KEPT = 30
"""Partial orders that are kept of however many objects."""


# -- turn

LIKELY = 0.5
"""Below this a dependency is more likely wrong than right."""


# -- words

SURELY = 0.05
"""Risk below which a step is called sure: 1 of 100 such steps move something else (one camera, 130 steps)."""

GUESS = 0.3
"""Risk from which it is called a guess: 6 of 100 do (17 steps: too few); between the two 10 (181 steps)."""

LABEL = 18
"""Letters of a name in a picture; its tooltip has all of it."""
