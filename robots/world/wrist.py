"""The force on a hand, from the torques of the arm's joints: what arms with torque sensors feel by."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from topple.robots.arm.arm import Arm
from topple.robots.engine import pybullet
from topple.robots.world.tolerances import WEAK
from topple.topology.arrays import FloatArray


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
        client: PyBullet's number of the simulation.
        robot: PyBullet's number of the robot.
        arm: The arm.
        joints: PyBullet's indices of the arm's joints.
        gravity: In [m/s2].
        time_step: In [s].
        noise: Of the joints' sensors; None: as of an arm made for touching.
        rng: Where the noise comes from; None: a generator seeded with 0.
    """

    def __init__(
        self,
        client: int,
        robot: int,
        arm: Arm,
        joints: Sequence[int],
        gravity: float,
        time_step: float,
        noise: TorqueNoise | None = None,
        rng: np.random.Generator | None = None,
    ) -> None:
        self._client, self._robot, self._chain = client, robot, arm.chain
        self._gravity, self._time_step = gravity, time_step
        self._noise, self._rng = noise or TorqueNoise(), rng or np.random.default_rng(0)
        every = range(pybullet.getNumJoints(robot, physicsClientId=client))
        infos: list[Any] = [pybullet.getJointInfo(robot, j, physicsClientId=client) for j in every]
        self._moving = [info[0] for info in infos if info[2] != pybullet.JOINT_FIXED]
        self._damping = np.array([infos[j][6] for j in self._moving])
        self._columns = [self._moving.index(j) for j in joints]
        self._offset = self._rng.normal(0.0, self._noise.offset, len(joints))
        self._speeds, self._velocity, self._bias = np.zeros(len(self._moving)), np.zeros(3), np.zeros(3)

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
        states: Any = pybullet.getJointStates(self._robot, self._moving, physicsClientId=self._client)
        q, speeds, torques = (np.array([state[k] for state in states]) for k in (0, 1, 3))
        change = np.zeros_like(speeds) if still else (speeds - self._speeds) / self._time_step
        self._speeds = speeds
        own: Any = pybullet.calculateInverseDynamics(
            self._robot, q.tolist(), speeds.tolist(), change.tolist(), physicsClientId=self._client
        )
        frames = self._chain.frames(q[None, self._columns])
        jacobian = self._chain.jacobian(frames, frames[:, -1, :3, 3])[0]
        velocity = (jacobian @ speeds[self._columns])[:3]
        acceleration, self._velocity = (velocity - self._velocity) / self._time_step, velocity
        left = (torques - np.array(own) - self._damping * speeds)[self._columns]
        left += self._offset + self._rng.normal(0.0, self._noise.deviation, len(left))
        return np.linalg.lstsq(jacobian.T, left, rcond=WEAK)[0][:3], acceleration
