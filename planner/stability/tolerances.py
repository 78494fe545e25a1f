"""Thresholds of the check of a scene, each with its unit and reason."""

import numpy as np

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

ALONG_FACE = float(np.cos(np.radians(10.0)))
"""Cosine of the angle within which sides of a noisy hull may be of one flat face."""

FLAT_FACE = 0.004
"""Share of a hull's sides that has to be along one direction for a face to be looked for."""

MOST_FACES = 24
"""Flat faces of a body that are looked for."""

OFF_FACE = 0.0003
"""[m] besides the noise within which points are of a face."""

ROUND_REST = 0.04
"""Share of a body's points that may be of no face where edges are all that there is besides."""

STRAYS = 0.005
"""Share of a body's points that may be beyond a face of it."""

DIRECTIONS = 400
"""Directions from which a round body is touched: sides 6 degrees apart."""

FEWEST_OF_FACE = 8
"""Points that a flat face has at the least."""

BULGE = 0.004
"""[m] around the farthest point within which a round side is measured."""

INSIDE_HULL = 0.0015
"""[m] besides four times the noise that points may be inside of a body, else it is not convex."""

SOLID_EDGE = 0.0003
"""[m] by which an edge of a body of a cloud is off, besides half the noise."""

COVERED = 4.0
"""Spacings of a cloud within which a point of it is near all of a body's surface, unless that is hollow."""

CONVEX_SHARE = 0.98
"""Share of a cloud that has to be on the body that it is taken for."""

BESIDES = 0.2
"""Upward part of a contact's normal from which it carries: nearer to level it is leant on."""

# -- verdicts

EXACT = 1e-3
"""Share of its weight that may be missing of the forces on an exact mesh: 0.03 mm beyond its support."""

FACET = float(np.radians(15.0))
"""Angle [rad] between a face and the surface it touches up to which it is a facet of something round."""

ROLLS = 0.07
"""The same as `EXACT` of what stands on facets: its weight may be 2 mm beyond them, as rolling resistance and
facets that are not as round as the thing have it. Balls still roll from 16 degrees on."""

GRIPPING = 10.0
"""Coefficient of friction of what cannot slide: it falls for where its weight is."""

ROLLS_FROM = 1e-6
"""Shift [m] of the centre of mass below which none was found that would make a body stand."""

# -- margins

WAYS = 8
"""Level directions in which a margin is looked for; between them its outline is taken to be straight."""

LEVEL = float(np.cos(np.radians(1.0)))
"""Upward part of normals from which a contact is level: friction there is 2 % off at most."""

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

# -- predicates

CARRIES = 0.1
"""Share of a thing's weight with which something carries it: one of several piers, no solver's tremble."""

HELD_BY_OTHERS = 0.5
"""Share of a thing's weight with which others may push it that is in a hollow: more is a grip."""

STEADY = 0.7
"""Share of a thing's weight that contacts have to give upwards for it to stand: friction gives the rest."""

RIM = 0.002
"""[m] below another's highest point from which a thing is in its hollow: contacts reach in by less."""

CLOUD_RIM = 0.008
"""The same [m] of clouds: what cameras see of a table is as uneven."""

REST_SPEED = 0.01
"""[m/s] below which a thing in anyone's simulator is at rest: soft contacts creep and tremble by a third."""

REST_TURN = 0.1
"""[rad/s] below which it does not turn: 1 cm/s at the rim of a plate."""
