"""How the joints of a simulated arm and its hand are driven."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Control:
    """How the joints are driven.

    Attributes:
        position_gain: Share of the position error that a step removes; 0.3 follows within a milliradian.
        velocity_gain: Share of the velocity error that a step removes.
        settled: Joint error in [rad] below which the end of a trajectory counts as reached.
        strayed: Joint error in [rad] on the way beyond which the arm stops: it was pushed, or met something.
            That is a centimetre or two at the hand; an arm that nothing touches keeps within 0.006.
        patience: Seconds to wait for that.
        stall: Pad speed in [m/s] below which a closing jaw counts as closed on something.
        turn_admittance: Speed in [rad/s] at which a closing hand turns under a torque of 1 N m on its pads.
        gentle: Force in [N] with which a jaw closes until both pads lie on something: less than turns a bowl.
        tare: Seconds of readings at rest whose mean tares the wrist: it leaves a fifth of their noise.
        seating: Force in [N] that pushes a cup out until it holds something: enough to seat its lip.
    """

    position_gain: float = 0.3
    velocity_gain: float = 1.0
    settled: float = 2e-3
    strayed: float = 0.03
    patience: float = 0.6
    stall: float = 2e-3
    turn_admittance: float = 12.0
    gentle: float = 5.0
    tare: float = 0.1
    seating: float = 10.0
