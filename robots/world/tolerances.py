"""Thresholds of world, each with its unit and reason, by the module that asks them."""

import numpy as np

# -- bodies

FRICTION = 0.7
"""PyBullet multiplies: two household things then touch with 0.5, between glaze (0.3) and card (0.7)."""

LINK_FRICTION = 0.5
"""Of an arm's links whose file says none: Bullet's own, as of paint on steel."""

ROLLING = 5e-4
"""[m] lever of the rolling resistance: 1.5 % of a can's radius, as for thin steel on wood."""


# -- body_clouds

PIECE = 0.028
"""Size [m] below which a piece of a shell is not halved: on the wall of a mug (radius 4 cm) it is 2.4 mm
off the middle."""

BENT = 0.0025
"""Depth [m] in its own hull up to which a piece of a shell is not halved: what it fills of the hollow."""

DEEP = 0.9
"""Share of a piece's points that must not lie deeper: noise and the fillets of a foot do."""

SHARED = 0.005
"""Points this close [m] to a piece belong to it, too: no gap opens between pieces."""

WALL = 0.004
"""Thickness [m] of a wall of which one side was seen: that of plates, bowls and mugs."""

SMOOTHED = 42
"""Points over whose plane noise is averaged: a disc of 1.1 cm radius on a cloud thinned to 3 mm."""

ONE_PLANE = 0.06
"""Neighbours whose spread across their plane is less than this share (of the variance) lie in one: at a
right edge it is a quarter, on both sides of a wall a tenth and more, with noise on a face a thirtieth."""

SHEET = 84
"""Points of one seen side over whose plane noise is averaged: a disc of 1.0 to 1.5 cm on a cloud thinned to
3 mm, whose noise of 1.4 mm comes down to 0.2 mm, a tenth of what a cup's lip bridges. It then seals on all of
the flat of three plates rebuilt from three views, with half as many points on 48 to 76 of 100 places."""

ONE_SHEET = 0.12
"""As `ONE_PLANE`, for one seen side: there is no other side to keep apart, and noise makes up to a tenth.
With 0.06 that cup seals on 38 to 86 of 100 places."""

STRAYS = 0.9
"""Share of those points that the plane is put through: the others are flying pixels, a hundredth of a plate's
cloud beside what lies on it, or beyond an edge."""

DETAIL = 0.001
"""A hull keeps this much [m] of its detail: below the noise, and balls get by with a few dozen corners."""

AGREED = 0.5
"""Share by which the cameras must agree on the side of a wall they look at."""


# -- camera

MASKS_MISSING = 0.05
"""Chance that a segmentation misses an object in a picture, where its masks are not exact: one in twenty."""


# -- film

BACK = 0.4
"""[m] behind the depth camera: the arm fits into the picture."""


# -- observe

CELLS = 24
"""Rays along an edge of a body's box at most: large boxes get a coarser grid."""

DEEPEST = 8
"""Parts of other bodies a ray may meet before the one it is meant for."""

LARGEST = 5.0
"""[m] what is larger is ground, and cut to the others' surroundings."""

AROUND = 0.25
"""[m] of ground kept beyond the others."""

STEP = 2e-4
"""How far [m] behind a surface a ray goes on."""


# -- simulated_arm

PAD_STIFFNESS = 1e6
"""[N/m] of pads that press: 40 N dent them by 0.04 mm. Bullet lets friction act at one point on either
surface: where they lie deep in each other, the two travel differently as the hand turns, and what is held
lags behind by twice the depth over its width. With the 30 N/mm of PyBullet's own Panda that is a fifth for a
spoon's neck, which works itself out of the hand. What pads only touch they touch as softly as their file
says: a hard touch stops a guarded approach, and pushes what stands lightly."""

FINGER_ROTOR = 0.1
"""[kg] of motor and gear at the pads, as a finger that turns feels them. The links of a 2F-85 alone, of
1e-5 kg m2, are too light for the solver: where its tips press a can of 66 mm with 60 N they bend by 43 mm,
and with these by 1 mm."""

PAD_DAMPING = 3.3e4
"""[N s/m] with which a step of 1/240 s takes back a ninth of the depth, as PyBullet's own Panda does."""


# -- touch

BRUSH = 5.0
"""[N] that a robot may press with for long on what it does not handle: the weight of half a kilogram breaks
nothing, and what it moves counts as moved."""

CHATTER = 0.02
"""[s] without a contact until a touch has ended: those of stiff things chatter at 100 Hz and more."""


# -- vacuum

CLEAR = 2.5e-3
"""[m] the rays pass the cup's own body, which PyBullet pads by some 2 mm in ray tests."""

REACH = 0.01
"""[m] how far before and behind the lip the rays look."""

TILT = np.radians(15)
"""A bellows cup aligns itself with a surface tilted up to about this."""

CONSTRAINT_ERP = 0.2
"""Error reduction: share of a constraint's error that Bullet removes in a step."""

AT_LIMIT = 0.99
"""Share of a limit from which a constraint counts as at it: along an axis it says no more."""

PEEL_STEPS = 3
"""In a row at the limit until the lip is off: rubber gives way, contact spikes do not."""

RAYS = 16
"""Rays around the lip: 6 mm apart on a 30 mm cup, narrower than what a bellows bridges."""


# -- world

THICKNESS = 0.04
"""[m] of a table top."""

TABLE_FRICTION = 0.85
"""Times the 0.7 of household things: 0.6, as measured on unpolished wood."""


# -- wrist

WEAK = 1e-2
"""Share of the strongest direction below which joint torques tell of no force: near a singularity."""


# -- clamps

CLAMPING = 500.0
"""[N] and [N m] that a fixture holds against: a small vice."""


# -- bullet_sleep

ASLEEP_AFTER = 0.5
"""[s] that bodies must rest before they sleep: the speed of one of 10 cm that tips grows e-fold in 0.08 s."""

ASLEEP_EACH = 12
"""Steps between two looks at whether it rests: a twentieth of a second."""


# -- rendering

AMBIENT = 0.6
"""Share of light that comes from everywhere."""

LAMP = (0.4, -0.5, 1.5)
"""Where the rest comes from (3,)."""

SMOOTH = 0.7
"""[rad] up to which an edge is drawn round: a cylinder of twelve sides bends by 0.52, a box by 1.57."""

FLOOR = 15.0
"""[m] from the middle of a floor to where it is no longer drawn."""

FLOOR_COLOUR = (205.0, 205.0, 210.0)
"""Red, green, blue, 0..255, of concrete."""

ARM_TRIANGLES = 12_000
"""Most triangles that an arm is drawn with: of a Panda's 103,000, 99 % of corners within 2 mm of them."""
