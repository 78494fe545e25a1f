"""Thresholds of arm, each with its unit and reason, by the module that asks them."""

import math

# -- arm

STARTS = (2, 8)
"""Starts of inverse kinematics after which targets that have a state are left alone: most have one by
then."""


# -- arm_chain

SERIES = 4
"""Moving joints one after the other from which a branch is an arm: fingers and heads have at most three."""


# -- gripper

FINGERS_TOUCH, LIP_TOUCH = 2.0, 8.0
"""[N] at the wrist: moves no can yet; seats a cup's lip."""

GRIPPED = 0.2
"""[s] a hand is given to be at rest as it takes hold."""

CLOSED_ON_NOTHING = 0.001
"""[m] pads closer than this have nothing between them."""

FINGER_SLABS = (0.008, 0.015)
"""Fingers taper over their last two centimetres [m]."""

PRESS = 0.6
"""Share of the jaw's continuous force used for a grip: crockery and fruit should survive it."""

HINGED_OPENINGS = 4
"""Openings at which a finger that turns is looked at: between them it swings less than it is thick."""

SWUNG = (0.08, 0.003)
"""[m] from the tip of the turned finger back, and of one prism: it leans by up to its `LEAN`."""

OVER_FACE = 0.002
"""[m] over the face of the fixed finger that what stands there counts for the finger: hulls are rough."""

TRIAL_SHARE = (0.6, 0.75)
"""Of the pads' distance, what a cube takes at most that is surely held: room for what the cameras see wrong.
Where one finger turns it is more: the fixed one reaches beyond it, and a low cube leaves that no room."""

CUP_FRICTION = 0.5
"""Of a cup on dry wood, metal, glass or stone; 0.2 to 0.3 where they are wet (Schmalz)."""


# -- gripper_file

MOST_BYTES = 1 << 15
"""Bytes of a gripper's file, which has a page: parsers take the square of a key's length."""


# -- home

SHARES = (0.4, 0.5, 0.6)
"""Of the arm's reach, how far in front the tool is."""

HEIGHTS = (0.25, 0.35, 0.45)
"""Of the reach, how high above what it works on."""

TALL = 0.5
"""Of the reach, how high the first joint is above the foot of an arm that does not work at its foot's height:
one on a torso."""

ASIDE = 0.1
"""Of the reach, how far its first joint is from the axis of the base of an arm that stands beside it: one of
two."""

BELOW = 0.35
"""Of the reach, how far below its first joint such an arm works: a table before a person's shoulders."""

CLEAR = (0.01, -0.004)
"""[m] between links, wanted and at least: distances are known to the hulls' 4 mm."""

ABOVE = -0.01
"""[m] nothing that moves is deeper below the foot of the base."""

TURNS = 4
"""Turns of the hand about the vertical that are tried."""

SEEDS = 48
"""Random starts of inverse kinematics: a ready pose is looked for once for an arm."""

DRAWN = 4096
"""States drawn where inverse kinematics finds none: arms of fewer than six joints."""


# -- inverse

FULL_DOF = 6
"""Joints from which on an arm reaches poses in a whole region of space and turns."""


# -- kinematics

ROUNDING = 1e-4
"""Added to every reach [m]: more than a solution's residual."""


# -- own_arm

ACCELERATION = {"prismatic": 2.0}
"""Acceleration [m/s2] of a joint by its kind, which URDF cannot say; `ANGULAR_ACCELERATION` for the
others."""

ANGULAR_ACCELERATION = 10.0
"""Acceleration [rad/s2]: moderate for arms that lift 3 to 10 kg."""

SHORTEST_ROD = 0.005
"""Rod [m] of a cup whose lip stands on the link itself."""

MOST_NAMED = 6
"""Links that an assumption names: more fill the screen, and a mobile robot has dozens."""


# -- prepared

DENSITY = 1000.0
"""[kg/m3] of a link without a mass, its hull filled: motors and air on the whole."""

TORQUE = 150.0
"""[N m] likewise: enough to hold an arm of 20 kg stretched out."""

TURNING = 1.0
"""[rad/s] likewise: a third of what arms of this size do."""

EFFORT = {"prismatic": 200.0}
"""Effort [N] of a joint without one, by its kind; `TORQUE` for the others."""

SPEED = {"prismatic": 0.25}
"""Speed [m/s] of a joint without a velocity limit, by its kind; `TURNING` for the others."""


# -- self_collision

NEAR = 0.005
"""[m] pairs that come this close are kept too, which makes missing one rarer still."""

ALWAYS = 0.9
"""Share of states above which two links overlap by construction of their hulls."""

SAMPLES = 4096
"""States drawn: a pair that meets in 0.1 % of them is then missed once in sixty."""


# -- shapes

CYLINDER_SIDES = 24
"""Sides of the prism around a cylinder: it is 0.9 % wider, which is on the safe side."""


# -- urdf

MOST_BODIES = 2000
"""Links and their shapes: a humanoid with both hands has three hundred."""

LONGEST = 1e3
"""Farthest vertex of a shape [m]: no arm is a kilometre long; hulls of far larger numbers are none."""

LONGEST_MESH = 20.0
"""Farthest vertex of a mesh [m]: no link is as long, and in millimetres a link is a hundred long."""

LIKELY_DEGREES = (38.0, 720.0)
"""Limits [rad] of a revolute joint that are taken for degrees: six turns and more, which no wrist makes."""

FULL_TURN = 2 * math.pi
"""How far [rad] a continuous joint may turn either way: cables and hoses allow no more."""


# -- torques

GRAVITY = 9.81
"""Acceleration [m/s2] of what falls freely."""

BESIDE = 0.004
"""[m] that the fixed finger of a hinged jaw keeps to what it comes beside: `least_side_clearance` of the
grasps; as the other finger closes the arm gives way by it."""

USUAL_REACH = 0.9
"""[m] of the arms that ways and places were chosen for."""

SMALL_REACH = 0.6
"""[m] below which they are scaled down: arms that teach reach 0.3 to 0.5."""

BARE = (190, 196, 206)
"""Colour of a link that nobody gave one: a light grey, on which a light shows its form."""

DARKEST = 48
"""Least red, green and blue of a link as it is drawn: a black one would be a silhouette."""

SCREWS = 0.01
"""Share of a link's surface from which a part of it is drawn."""

FINEST = 4
"""Cells more along a drawn part than the root of its triangles: from there on ever fewer are tried."""
