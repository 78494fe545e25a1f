"""Thresholds of arm, each with its unit and reason, by the module that asks them."""

# -- gripper

CUP_FRICTION = 0.5
"""Of a cup on dry wood, metal, glass or stone; 0.2 to 0.3 where they are wet (Schmalz)."""


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


# -- prepared

DENSITY = 1000.0
"""[kg/m3] of a link without a mass, its hull filled: motors and air on the whole."""

TORQUE = 150.0
"""[N m] likewise: enough to hold an arm of 20 kg stretched out."""

TURNING = 1.0
"""[rad/s] likewise: a third of what arms of this size do."""


# -- self_collision

NEAR = 0.005
"""[m] pairs that come this close are kept too, which makes missing one rarer still."""

ALWAYS = 0.9
"""Share of states above which two links overlap by construction of their hulls."""
