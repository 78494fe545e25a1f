"""The force that a hand feels at the wrist, as a force sensor in a robot's flange or its joints tell it."""

from typing import Any

import numpy as np

from topple.robots.engine import pybullet
from topple.robots.poses import pose_from
from topple.topology.arrays import FloatArray


class Wrist:
    """What is borne by the arm's last joint, less the weight and inertia of all that hangs on it.

    What hangs there is weighed by `zero`, when nothing else touches it.

    Args:
        client: PyBullet's number of the simulation.
        robot: PyBullet's number of the robot.
        joint: Index of the arm's last joint.
        gravity: In [m/s2].
        time_step: In [s].
    """

    def __init__(self, client: int, robot: int, joint: int, gravity: float, time_step: float) -> None:
        self._client, self._robot, self._joint = client, robot, joint
        self._gravity, self._time_step = gravity, time_step
        pybullet.enableJointForceTorqueSensor(robot, joint, True, physicsClientId=client)
        self.zero()

    def zero(self) -> None:
        """Take what is borne now for the weight of the hand and of what it holds, at rest."""
        self._bias, self._speed = self._read()

    def force(self) -> float:
        """What presses on the hand or on what it holds in [N]; to be asked once a time step."""
        borne, speed = self._read()
        acceleration, self._speed = (speed - self._speed) / self._time_step, speed
        mass = float(np.linalg.norm(self._bias)) / self._gravity
        return float(np.linalg.norm(borne - self._bias - mass * acceleration))

    def _read(self) -> tuple[FloatArray, FloatArray]:
        """Force on the joint in the world (3,) in [N], and the speed of its link (3,) in [m/s]."""
        state: Any = pybullet.getLinkState(
            self._robot, self._joint, 1, computeForwardKinematics=1, physicsClientId=self._client
        )
        borne: Any = pybullet.getJointState(self._robot, self._joint, physicsClientId=self._client)[2]
        return pose_from(state[4], state[5])[:3, :3] @ borne[:3], np.array(state[6])
