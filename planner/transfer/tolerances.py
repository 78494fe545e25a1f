"""Thresholds of transfer, each with its unit and reason, by the module that asks them."""

# -- checks

MARGIN = 0.004
"""What is carried keeps this to everything, if any way does: depth noise and tracking [m]."""

CONTACT = 0.006
"""Bodies this close touch: noise of two clouds [m]."""


# -- handling

SEEDS = 24
"""Random starts of inverse kinematics for each pose: finds nearly all that are reachable."""

AT_ONCE = 6
"""Hands and places that inverse kinematics is asked for at once: mostly one of the best will do, and fewer
make more batches of those that will not."""

STRAIN_STEP = 0.05
"""[rad] between states that joints are asked to hold: what gravity asks changes by a twentieth at most."""


# -- stages

LINE_STEP = 0.01
"""[rad] between checked states of straight ways, which pass close by things."""

ROUNDING = 2e-5
"""[m] proven clearance that writing a plan with six digits cannot use up."""


# -- transfer

TIRED = 2
"""Failures of one tool after which another has its turn: a surface that leaks leaks elsewhere too."""

NARROW = 3
"""Ways barred at the usual distance that are tried again at any distance, before giving up."""

LEVEL = 0.02
"""[rad] a placement that tilts a thing less keeps it upright: noise of the up direction."""

ALL_GRASPS = 60
"""Grasps tried by an arm of few joints: most of those that are tilted are not in its plane."""
