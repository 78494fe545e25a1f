"""Thresholds of hands, each with its unit and reason, by the module that asks them."""

import numpy as np

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
