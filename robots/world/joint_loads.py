"""What the joints of an arm in the PyBullet world bear beyond the arm's own motion."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from topple.robots.engine import pybullet
from topple.topology.arrays import FloatArray


class JointLoads:
    """Torques of the joints less what moving the arm itself takes: inverse dynamics, friction of the joints.

    Args:
        client: PyBullet's number of the simulation.
        robot: PyBullet's number of the robot.
        joints: PyBullet's indices of the arm's joints.
        time_step: In [s].
    """

    def __init__(self, client: int, robot: int, joints: Sequence[int], time_step: float) -> None:
        self._client, self._robot, self._time_step = client, robot, time_step
        every = range(pybullet.getNumJoints(robot, physicsClientId=client))
        infos: list[Any] = [pybullet.getJointInfo(robot, j, physicsClientId=client) for j in every]
        self._moving = [info[0] for info in infos if info[2] != pybullet.JOINT_FIXED]
        self._damping = np.array([infos[j][6] for j in self._moving])
        self._columns = [self._moving.index(j) for j in joints]
        self._speeds = np.zeros(len(self._moving))

    def __call__(self, still: bool) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Values, speeds and loads (n,) of the arm's joints; `still` takes the arm to be at rest."""
        states: Any = pybullet.getJointStates(self._robot, self._moving, physicsClientId=self._client)
        q, speeds, torques = (np.array([state[k] for state in states]) for k in (0, 1, 3))
        change = np.zeros_like(speeds) if still else (speeds - self._speeds) / self._time_step
        self._speeds = speeds
        own: Any = pybullet.calculateInverseDynamics(
            self._robot, q.tolist(), speeds.tolist(), change.tolist(), physicsClientId=self._client
        )
        left = torques - np.array(own) - self._damping * speeds
        return q[self._columns], speeds[self._columns], left[self._columns]
