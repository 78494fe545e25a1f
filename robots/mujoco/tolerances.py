"""Thresholds of the world on MuJoCo, each with its unit and reason."""

SUBSTEPS = 2
"""Steps of the engine in one of the world, which has 240 Hz: contacts may then be twice as stiff."""

STIFF = (0.006, 1.0)
"""Time [s] in which an overlap is undone, and damping ratio: three steps of the engine, without a bounce."""

HARD = (0.95, 0.99, 0.001, 0.5, 2.0)
"""Share of a contact's force that is not given way to, from first touch to 1 mm deep."""

GRIP = 10.0
"""Stiffness of friction beside that of the normal force: what is held does not creep out of the pads."""

NO_SLIP = 4
"""Rounds that take the creep of friction away after the solver: MuJoCo's is soft otherwise."""

ROTOR = 0.1
"""[kg m2] or [kg] of motor and gear as a joint of an arm feels them: 0.1 to 0.6 in arms of 20 kg."""

FINGER_ROTOR = 0.05
"""[kg] or [kg m2] likewise of a finger, at its pads."""

STIFFNESS = 60.0
"""[1/s] of the computed torque by which joints follow: errors are gone after a twentieth of a second."""

CLOSING = 100.0
"""[1/s] of what a finger is short of, up to its speed: half a millimetre, and its whole force is there."""

PUSHING = 40.0
"""[1/s] likewise of a cup's drive: a plate that hangs on it swings up and down beside the arm from 100 on."""

MOST_PUSH = 200.0
"""[N] of a cup's drive whose file says no effort: what a URDF's slider is taken for elsewhere."""
# -- model

SQUARE = 1e-6
"""How far [m] the corners of a box may be off."""
