"""Thresholds of hands, each with its unit and reason, by the module that asks them."""

import numpy as np

# -- fingers

LONGEST_STROKE = 0.1
"""[m] that one finger slides at most: fingers of hands for 20 cm do; the axis of a SCARA goes farther."""

# -- jaws

LEAST_STROKE = 0.005
"""[m] that pads come closer at least, else it is no jaw."""

OVERLAP = 0.002
"""[m] by which the hulls of closed pads may overlap: rubber, or rough meshes."""

FLAT = (0.0005, 0.0015, 0.003)
"""[m] what is this close to a finger's innermost vertex belongs to its pad."""

TIP = 0.5
"""Share of a finger, from its tip, in which the pad is looked for."""

LONGEST_PAD = 0.04
"""[m] from the tip: what is farther back does not hold."""

USUAL_PAD = 0.008
"""[m] of a flat pad at least; one that is less is round or rough: more of it counts."""

LEAST_PAD = 0.004
"""[m] extent given to pads that touch in a line or a point."""

FORCE = 40.0
"""[N] where the URDF states no effort: small electric jaws close with 20 to 80."""

STRONGEST = 100.0
"""[N] of a jaw whose URDF states more: efforts of simulations are often made up."""

SAMPLES = 17
"""Joint values at which the distance of the pads is measured: linkages are not linear."""

SNAP = np.cos(np.radians(20.0))
"""Cosine of the angle within which a hand points along an axis of its mounting link."""

# -- hinged

WIDEST_TURN = 2.6
"""[rad] that a finger turns at most: a wrist turns farther."""

LEAST_FINGER = 0.03
"""[m] from its hinge to the tip of a finger at least."""

SHORTER = 0.85
"""Of the moving finger's length, how far the fixed one reaches beside it at least: they end together; a palm
beside half a hand does not, and the link before a wrist ends at its axis."""

LEAN = 0.8
"""[rad] between the faces at most: what friction of 0.5 holds between two is 0.93, twice its cone."""

HINGED_PAD = 0.02
"""[m] along the fingers, from where the tip of the turned one is at `LEAN`: there they hold at any angle."""

HINGE_STATES = 33
"""Angles at which the distance is measured: it grows with the tangent."""

LEVELS = 12
"""Heights of a finger at which its face is looked at."""

EDGE = 0.003
"""[m] from a tip that is rounded."""
