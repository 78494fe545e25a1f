"""The force on a hand, from the torques of the arm's joints: what arms with torque sensors feel by."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from topple.robots.arm.arm import Arm
from topple.robots.world.tolerances import WEAK
from topple.topology.base.arrays import FloatArray


@dataclass(frozen=True)
class TorqueNoise:
    """What the torque sensors of an arm's joints get wrong.

    At the hand of a Panda that works on a table, 1 N m at every joint comes to 6 N: the noise to 0.13 N and
    the offset to 1.3 N, more than the makers of such arms state. An offset that changes with the arm's
    posture or its warmth is not modelled.

    Attributes:
        deviation: Standard deviation of a joint's reading in [N m], four of 1 kHz in a time step.
        offset: Standard deviation among joints of what is the same in all readings in [N m].
    """

    deviation: float = 0.02
    offset: float = 0.2

    @classmethod
    def none(cls) -> "TorqueNoise":
        """Sensors without faults."""
        return cls(0.0, 0.0)


class Wrist:
    """What presses on the hand, or on what it holds, beyond what it bore when it was last tared.

    The joints' torques less what moving the arm itself takes (inverse dynamics, and friction of the joints)
    are what a force on the hand takes, and the arm's Jacobian says which.

    Args:
        loads: What the engine measures: given whether the arm is taken to be at rest, the values of the arm's
            joints (n,), their speeds (n,), and their torques less those of the arm's own motion (n,).
        arm: The arm.
        gravity: In [m/s2].
        time_step: In [s].
        noise: Of the joints' sensors; None: as of an arm made for touching.
        rng: Where the noise comes from; None: a generator seeded with 0.
    """

    def __init__(
        self,
        loads: Callable[[bool], tuple[FloatArray, FloatArray, FloatArray]],
        arm: Arm,
        gravity: float,
        time_step: float,
        noise: TorqueNoise | None = None,
        rng: np.random.Generator | None = None,
    ) -> None:
        self._loads, self._chain = loads, arm.chain
        self._gravity, self._time_step = gravity, time_step
        self._noise, self._rng = noise or TorqueNoise(), rng or np.random.default_rng(0)
        self._offset = self._rng.normal(0.0, self._noise.offset, len(arm.joints))
        self._velocity, self._bias = np.zeros(3), np.zeros(3)

    def reading(self) -> FloatArray:
        """Force (3,) in [N] that an arm at rest exerts with its hand, in the base: offset and load in one."""
        return self._felt(still=True)[0]

    def tare(self, readings: Sequence[FloatArray]) -> None:
        """Take the mean of some readings at rest for the sensors' offset and the weight of what is held."""
        self._bias = np.mean(readings, axis=0)

    def force(self) -> float:
        """How hard something presses in [N]; to be asked after every time step."""
        felt, acceleration = self._felt(still=False)
        mass = float(np.linalg.norm(self._bias)) / self._gravity
        return float(np.linalg.norm(felt - self._bias - mass * acceleration))

    def _felt(self, still: bool) -> tuple[FloatArray, FloatArray]:
        """Force that the hand exerts (3,) in [N] and its acceleration (3,) in [m/s2], in the base."""
        q, speeds, left = self._loads(still)
        frames = self._chain.frames(q[None])
        jacobian = self._chain.jacobian(frames, frames[:, -1, :3, 3])[0]
        velocity = (jacobian @ speeds)[:3]
        acceleration, self._velocity = (velocity - self._velocity) / self._time_step, velocity
        left = left + self._offset + self._rng.normal(0.0, self._noise.deviation, len(left))
        return np.linalg.lstsq(jacobian.T, left, rcond=WEAK)[0][:3], acceleration
