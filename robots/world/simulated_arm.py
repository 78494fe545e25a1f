"""An arm in the PyBullet world: torque-limited joints, a jaw that holds by friction, a cup with a vacuum."""

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from topple.robots.arm.arm import Arm
from topple.robots.arm.cup import SuctionCup
from topple.robots.arm.gripper import ToolState
from topple.robots.engine import pybullet
from topple.robots.poses import pose_from, position_and_quaternion
from topple.robots.world.acting_arm import ActingArm
from topple.robots.world.bullet_vacuum import BulletVacuum
from topple.robots.world.tolerances import FINGER_ROTOR, PAD_DAMPING, PAD_STIFFNESS
from topple.robots.world.touch import note_touches
from topple.robots.world.vacuum import Vacuum
from topple.robots.world.world import World
from topple.robots.world.wrist import TorqueNoise, Wrist
from topple.topology.base.arguments import checked_arguments
from topple.topology.base.arrays import FloatArray


@checked_arguments
class SimulatedArm(ActingArm):
    """An `ActingArm` in a world on PyBullet.

    Args:
        world: The world it stands in.
        arm: The arm to load.
        pose_base_to_world: (4, 4) where it stands.
        q: (n,) joint values to start with; the arm's home if not given.
        noise: Of the joints' torque sensors; None: as of an arm made for touching.
        rng: Where the noise comes from; None: a generator seeded with 0.
        beside: Another arm in the same world. While one acts the other holds its targets, and what is called
            on the steps of one is called on those of both.

    Examples:
        >>> with World() as world:
        ...     len(SimulatedArm(world, robot("panda"), np.eye(4)).q_target)
        7
    """

    def __init__(
        self,
        world: World,
        arm: Arm,
        pose_base_to_world: FloatArray,
        q: FloatArray | None = None,
        *,
        noise: TorqueNoise | None = None,
        rng: np.random.Generator | None = None,
        beside: "SimulatedArm | None" = None,
    ) -> None:
        super().__init__(arm, pose_base_to_world, q)
        self._world = world
        self._both: tuple[SimulatedArm, ...] = (self,)
        if beside is not None:
            self._both = beside._both = (self, beside)
            self.on_step = beside.on_step
        position, quaternion = position_and_quaternion(self.pose_base_to_world)
        self.id: int = pybullet.loadURDF(
            str(arm.urdf), position, quaternion, useFixedBase=True, physicsClientId=world.client
        )
        world.register_robot(self.id, self)
        self._index: dict[str, int] = {}
        self._link: dict[str, int] = {}
        self._names: dict[int, str] = {-1: "base"}
        self._limit: dict[str, float] = {}
        for j in range(pybullet.getNumJoints(self.id, physicsClientId=world.client)):
            info: Any = pybullet.getJointInfo(self.id, j, physicsClientId=world.client)
            self._index[info[1].decode()] = j
            self._link[info[12].decode()] = j
            self._names[j] = info[12].decode()
            self._limit[info[1].decode()] = float(info[10])
        self._arm_joints = [self._index[name] for name in arm.joints]
        self._arm_forces = [self._limit[name] for name in arm.joints]
        # motors go on with what they were told
        self._told: tuple[FloatArray, FloatArray] | None = None
        self._hand_told: tuple[ToolState, float, bool] | None = None
        self._reset()
        self._weigh_hinges()
        self._couple_fingers()
        self._file_stiffness = self._stiffness_of_pads()
        loads = JointLoads(world.client, self.id, self._arm_joints, world.time_step)
        self.wrist = Wrist(loads, arm, world.physics.gravity, world.time_step, noise, rng)

    @property
    def world(self) -> World:
        """The world it stands in."""
        return self._world

    def _reset(self) -> None:
        client = self.world.client
        for index, value in zip(self._arm_joints, self.q_target, strict=True):
            pybullet.resetJointState(self.id, index, float(value), physicsClientId=client)
        for name, value in self._hand_values().items():
            pybullet.resetJointState(self.id, self._index[name], value, physicsClientId=client)
        if self.jaw:
            for link in self.jaw.links:
                pybullet.changeDynamics(
                    self.id,
                    self._link[link],
                    lateralFriction=self.jaw.friction,
                    spinningFriction=self.jaw.give,
                    frictionAnchor=0,
                    physicsClientId=client,
                )

    def _stiffness_of_pads(self) -> dict[int, tuple[float, float]]:
        """Stiffness [N/m] and damping [N s/m] of the links with pads whose file says them."""
        found: dict[int, tuple[float, float]] = {}
        for link in map(self._link.__getitem__, self.jaw.links if self.jaw else ()):
            info: Any = pybullet.getDynamicsInfo(self.id, link, physicsClientId=self.world.client)
            if info[9] > 0.0:
                found[link] = (info[9], info[8])
        return found

    def _stiffen_pads(self, pressing: bool) -> None:
        for link, (stiffness, damping) in self._file_stiffness.items():
            pybullet.changeDynamics(
                self.id,
                link,
                contactStiffness=PAD_STIFFNESS if pressing else stiffness,
                contactDamping=PAD_DAMPING if pressing else damping,
                physicsClientId=self.world.client,
            )

    def _weigh_hinges(self) -> None:
        """A finger that turns feels its drive: its links alone are too light for Bullet to hold by gears."""
        jaw, client = self.jaw, self.world.client
        for name in jaw.joints if jaw else ():
            if jaw and self.arm.model.joint(name).kind != "prismatic":
                info: Any = pybullet.getDynamicsInfo(self.id, self._index[name], physicsClientId=client)
                own, rotor = info[2], FINGER_ROTOR * jaw.lever(name) ** 2
                pybullet.changeDynamics(
                    self.id, self._index[name], localInertiaDiagonal=[each + rotor for each in own],
                    physicsClientId=client,
                )  # fmt: skip

    def _couple_fingers(self) -> None:
        """The fingers of a parallel jaw move as one: a gear holds the joints of the others to the first."""
        if not self.jaw or len(self.jaw.joints) < 2:
            return
        first = self.jaw.joints[0]
        span = self.jaw.joint_values[-1] - self.jaw.joint_values[0]
        for k, name in enumerate(self.jaw.joints[1:], start=1):
            axis = pybullet.getJointInfo(self.id, self._index[first], physicsClientId=self.world.client)[13]
            gear = pybullet.createConstraint(
                self.id, self._index[first], self.id, self._index[name], pybullet.JOINT_GEAR, axis,
                [0, 0, 0], [0, 0, 0], physicsClientId=self.world.client,
            )  # fmt: skip
            ratio = -float(span[0] / span[k])
            pybullet.changeConstraint(
                gear, gearRatio=ratio, erp=0.1, maxForce=2 * self.jaw.force, physicsClientId=self.world.client
            )

    # -- what it senses

    def joint_positions(self, names: Sequence[str]) -> FloatArray:
        """Measured values of some joints in [rad] or [m]."""
        return np.array([state[0] for state in self._states(names)])

    def efforts(self, names: Sequence[str]) -> Sequence[float]:
        """Efforts of the motors of some joints in [N m] or [N]."""
        return [float(state[3]) for state in self._states(names)]

    def _states(self, names: Sequence[str]) -> Any:
        indices = [self._index[name] for name in names]
        return pybullet.getJointStates(self.id, indices, physicsClientId=self.world.client)

    def on_pads(self) -> tuple[FloatArray, FloatArray]:
        """Where something presses on the pads (k, 3) in [m], and how (k, 3) in [N], in the world."""
        pads = {self._link[link] for link in self.jaw.links} if self.jaw else set[int]()
        points: Any = pybullet.getContactPoints(bodyA=self.id, physicsClientId=self.world.client)
        pressing = [point for point in points if point[3] in pads]
        places = np.array([point[5] for point in pressing]).reshape(-1, 3)
        return places, np.array([np.multiply(point[9], point[7]) for point in pressing]).reshape(-1, 3)

    # -- what it does

    def _vacuum_on(self, cup: SuctionCup, pose_lip_to_world: FloatArray) -> Vacuum | None:
        return BulletVacuum.on(self.world, self.id, self._link[cup.link], pose_lip_to_world, cup)

    def link_pose(self, link: str) -> FloatArray:
        """(4, 4) measured pose of a link's frame in the world."""
        state: Any = pybullet.getLinkState(
            self.id, self._link[link], computeForwardKinematics=1, physicsClientId=self.world.client
        )
        return pose_from(state[4], state[5])

    def _drive(self, q: FloatArray, v: FloatArray) -> None:
        count = len(self._arm_joints)
        if self._told is None or not (np.array_equal(q, self._told[0]) and np.array_equal(v, self._told[1])):
            self._told = q, v
            pybullet.setJointMotorControlArray(
                self.id, self._arm_joints, pybullet.POSITION_CONTROL, targetPositions=q.tolist(),
                targetVelocities=v.tolist(), forces=self._arm_forces,
                positionGains=[self.control.position_gain] * count,
                velocityGains=[self.control.velocity_gain] * count,
                physicsClientId=self.world.client,
            )  # fmt: skip
        hand = self.tool_state, self._grip_force, self.vacuum is None
        if hand != self._hand_told:
            self._hand_told = hand
            self._drive_hand()

    def _drive_hand(self) -> None:
        if self.jaw:
            share = 2.0 * self._grip_force / len(self.jaw.joints)  # all joints together press both pads
            for name, value in self.jaw.values(self.tool_state).items():
                lever = self.jaw.lever(name)
                self._push(name, value, share * lever, self.jaw.speed / 2 / lever)
        if self.cup:
            push = self.control.seating if self.vacuum is None else math.inf
            for name, value in self.cup.values(self.tool_state).items():
                self._push(name, value, min(push, self._limit[name]), self.cup.speed)

    def _push(self, joint: str, value: float, force: float, speed: float) -> None:
        """Drive a joint of the hand to a value, with a force and a speed in its units."""
        pybullet.setJointMotorControl2(
            self.id, self._index[joint], pybullet.POSITION_CONTROL, targetPosition=value,
            force=force, maxVelocity=speed, physicsClientId=self.world.client,
        )  # fmt: skip

    def _advance(self) -> None:
        self.world.advance()
        if self.vacuum is not None:
            self.vacuum.check()
        self.world.sleep.after_step(set().union(*[arm._note_touches() for arm in self._both]))
        for watch in self.on_step:
            watch()

    def _note_touches(self) -> set[int]:
        """Note what it touches and how hard; PyBullet's numbers of that and of what its cup holds."""
        points: Any = pybullet.getContactPoints(bodyA=self.id, physicsClientId=self.world.client)
        contacts = [
            (name, self._names[point[3]], float(point[9]))
            for point in points
            if point[9] > 0.0 and (name := self.world.name_of(point[2])) is not None
        ]
        note_touches(self.touched, contacts, self.world.time_step)
        held = {self.world.ids[self.vacuum.name]} if self.vacuum is not None else set[int]()
        return held.union(point[2] for point in points)


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
