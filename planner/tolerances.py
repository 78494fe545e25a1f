"""What the rooms of the planner have in common: from where on a thing counts as disturbed."""

import numpy as np

DISTURBED = 0.01
"""[m] from where on an object counts as moved: three times the noise of a depth camera at a metre, and less
than what topples a neighbour."""

TURNED = float(np.radians(10.0))
"""[rad] from where on it counts as turned: what a hand does not feel as it lets go, and a spoon on a rim
survives."""

HIT = 0.05
"""[N s] of a touch, beyond a brush, from where on what is not handled was hit: it sets a cup of 0.26 kg
going at 0.2 m/s, as a fall by 2 mm does. One step of pinning by less than 17 N is none."""

ALIKE = 1e-6
"""[m], [rad] or share by which what a plan says of its arm may differ from what is found: last digits."""

STEPS_ROUND = 72
"""Turns about an axis that are looked at: 5 degrees apart, half of what counts as turned."""

ALL_PAIRS_UP_TO = 200
"""Objects of which `topple relate` lists every pair: 19,900 pairs, 6 MB of JSON."""

MOST_ANSWER = 4_000_000
"""Bytes of an answer to a language model: more than it can read, and the plan of a dozen steps."""
