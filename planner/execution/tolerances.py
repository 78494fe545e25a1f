"""Thresholds of execution, each with its unit and reason, by the module that asks them."""

# -- execute

TOUCHDOWN = 1.0
"""[N] an object that presses this much on what is below stands on it: the arm goes no further."""

STILL = 0.1
"""[s] before the force at the wrist is taken for the weight of the hand and of what it holds."""

SHALLOW = 0.005
"""[m] before the end of the way in that a grasp still holds: a third of a pad."""

OFF_COURSE = 0.03
"""[rad] an arm this far from its goal is held up by something."""

NOTHING = 0.001
"""[m] pads closer than this have nothing between them."""

AT_HOME = 0.01
"""[rad]."""

SPEED = 0.5
"""Share of the joints' velocity limits on the way home."""


# -- look

FINE = 0.002
"""[m] between the points kept of an object: what three cameras at a metre see apart."""

COARSE = 0.008
"""[m] between those of a table: finer than the foot of what stands on it."""

MOVED = 0.01
"""[m] from where on a thing lies elsewhere than expected: three times the depth noise."""

SEEN_THROUGH = 0.02
"""[m] beyond a remembered point a camera sees: ten times the depth noise."""

GONE = 0.5
"""Share of its points that must be seen through until a remembered thing is believed to be gone."""


# -- loop

STUCK = 0.005
"""[m] an arm this deep in something when it starts stands in it: depth noise is a third of that."""


# -- rehearsal

SAGGED = 0.01
"""[m] a body that moves this far until it rests was not understood."""

EDGE = 0.02
"""[m] a table reaches beyond what was seen of it."""

# -- associate

STAYED = 0.03
"""[m] between clouds of one object: it was nudged, or is seen from another side."""

ELSEWHERE = 0.3
"""[m] that an object falls or rolls at most while the arm acts, unlike it may look included."""

LIKENESS = 4.0
"""[m] of way that a metre of difference in spread counts: a box spreads by a quarter of its edge."""

# -- associate

SPACING = 0.005
"""[m] between points that are compared: finer than STAYED."""
