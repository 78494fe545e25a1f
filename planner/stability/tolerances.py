"""Thresholds of the check of a scene, each with its unit and reason."""

# -- footing

TOUCHES = 0.0013
"""Gap [m] up to which two meshes touch: PyBullet leaves a millimetre between what is at rest."""

SINKS = 0.0018
"""Depth [m] to which meshes at rest reach into each other: soft contacts of simulators do, under a load."""

DEEPEST = 0.02
"""Depth [m] up to which one is measured: beyond it a pose is plainly wrong, and how much helps nobody."""

CLOUD_TOUCHES = 0.0015
"""Gap [m] between flat faces of clouds up to which they touch, besides twice the noise."""

CLOUD_SINKS = 0.002
"""Depth [m] of one flat face of a cloud in another from which it is in it, besides twice the noise."""

CLOUD_EDGE = 0.001
"""[m] by which the edge of a face of a cloud is off, besides twice the noise: half the points' spacing."""

BESIDES = 0.2
"""Upward part of a contact's normal from which it carries: nearer to level it is leant on."""

# -- verdicts

EXACT = 1e-3
"""Share of its weight that may be missing of the forces on an exact mesh: 0.03 mm beyond its support."""

GRIPPING = 10.0
"""Coefficient of friction of what cannot slide: it falls for where its weight is."""

ROLLS_FROM = 1e-6
"""Shift [m] of the centre of mass below which none was found that would make a body stand."""

# -- margins

WAYS = 8
"""Level directions in which a margin is looked for; between them its outline is taken to be straight."""

FARTHEST = 1.0
"""Largest margin [m] that is told: further than any object of a table is wide."""

STEEPEST = 20.0
"""Largest slope that is tried, tangent of 87 degrees: what stands on it is held."""

STRONGEST = 100.0
"""Largest push that is tried, in weights of the object: what withstands it is wedged."""

# -- mend

LEAST_MOVE = 0.005
"""Longest shift [m] by which a scene is mended: further is another scene."""

MENDS_BY = 0.0005
"""[m] further than the edge that a weight is brought: what just stands falls at a touch."""

MENDING_ROUNDS = 6
"""Shifts one after the other: what one brings down onto another one may tip there."""
