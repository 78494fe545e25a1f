"""An arm in the PyBullet world: torque-limited joints, a jaw that holds by friction, a cup with a vacuum."""

import math
from collections.abc import Callable
from typing import Any

import numpy as np

from topple.robots.arm.arm import Arm
from topple.robots.arm.gripper import ToolName, ToolState
from topple.robots.driver import Motion
from topple.robots.engine import pybullet
from topple.robots.poses import inverse, pose_from, position_and_quaternion
from topple.robots.tolerances import TOLERANCES
from topple.robots.world.compliance import Compliance
from topple.robots.world.control import Control
from topple.robots.world.touch import Touch, note_touches
from topple.robots.world.vacuum import Vacuum
from topple.robots.world.world import World
from topple.robots.world.wrist import TorqueNoise, Wrist
from topple.topology.arrays import FloatArray
from topple.topology.errors import InvalidInput


class SimulatedArm:
    """A `Driver` of one arm in a world; records everything it touches, for a judge to see.

    Args:
        world: The world it stands in.
        arm: The arm to load.
        pose_base_to_world: (4, 4) where it stands.
        q: (n,) joint values to start with; the arm's home if not given.
        control: Gains and waits.
        noise: Of the joints' torque sensors; None: as of an arm made for touching.
        rng: Where the noise comes from; None: a generator seeded with 0.
    """

    def __init__(
        self,
        world: World,
        arm: Arm,
        pose_base_to_world: FloatArray,
        q: FloatArray | None = None,
        control: Control | None = None,
        *,
        noise: TorqueNoise | None = None,
        rng: np.random.Generator | None = None,
    ) -> None:
        self.world, self.arm, self.control = world, arm, control or Control()
        self.pose_base_to_world = np.array(pose_base_to_world, dtype=float)
        position, quaternion = position_and_quaternion(self.pose_base_to_world)
        self.id: int = pybullet.loadURDF(
            str(arm.urdf), position, quaternion, useFixedBase=True, physicsClientId=world.client
        )
        world.register_robot(self.id)
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
        self.q_target = np.array(arm.home if q is None else q, dtype=float)
        self.jaw, self.cup = arm.jaw, arm.cup
        self._opening = self.jaw.max_opening if self.jaw else 0.0
        self._extension = self.cup.stowed if self.cup else 0.0
        self._grip_force = self.jaw.force if self.jaw else 0.0
        self._reset()
        self._couple_fingers()
        self.wrist = Wrist(
            world.client, self.id, arm, self._arm_joints, world.physics.gravity, world.time_step, noise, rng
        )
        self.vacuum: Vacuum | None = None
        self.touched: dict[str, Touch] = {}
        self.on_step: list[Callable[[], None]] = []

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

    def _hand_values(self) -> dict[str, float]:
        values = self.jaw.values(self._opening) if self.jaw else {}
        return values | (self.cup.values(self._extension) if self.cup else {})

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

    @property
    def q(self) -> FloatArray:
        """(n,) measured joint values in [rad]."""
        states: Any = pybullet.getJointStates(self.id, self._arm_joints, physicsClientId=self.world.client)
        return np.array([state[0] for state in states])

    @property
    def opening(self) -> float:
        """Measured distance of the pads in [m]; 0 without a jaw."""
        if not self.jaw:
            return 0.0
        states: Any = pybullet.getJointStates(
            self.id, [self._index[name] for name in self.jaw.joints], physicsClientId=self.world.client
        )
        return self.jaw.opening({name: state[0] for name, state in zip(self.jaw.joints, states, strict=True)})

    @property
    def grip_force(self) -> float:
        """Force in [N] with which the jaw's motors press each pad, as currents tell; 0 without a jaw."""
        if not self.jaw:
            return 0.0
        states: Any = pybullet.getJointStates(
            self.id, [self._index[name] for name in self.jaw.joints], physicsClientId=self.world.client
        )
        pushed = [abs(s[3]) / self.jaw.lever(name) for name, s in zip(self.jaw.joints, states, strict=True)]
        return float(sum(pushed)) / 2.0  # all joints together press both pads

    @property
    def tool_state(self) -> ToolState:
        """How the hand is told to stand."""
        return ToolState(self._opening, self._extension)

    @property
    def holding(self) -> bool:
        """Whether the jaw stalls on something before it is where it was told to close, or the vacuum stands.

        It is what an encoder and the motor's current tell, not what is between the pads: fingers that are
        held up from outside count as well.
        """
        if self.vacuum is not None:
            return self.vacuum.sealed
        short = self.opening - self._opening
        return short > TOLERANCES.empty_jaw and self.grip_force > TOLERANCES.stalled * self._grip_force

    def pose_in_hand(self, name: str, tool: str) -> FloatArray:
        """(4, 4) pose_object_to_tool of an object: how it moves in the hand is what a judge asks."""
        return inverse(self.tool_pose(tool)) @ self.world.pose(name)

    def tool_pose(self, tool: str) -> FloatArray:
        """(4, 4) pose_tool_to_world where a tool truly is."""
        frame = self.arm.tool(tool)
        return self.link_pose(frame.link) @ frame.pose_tool_to_link

    # -- what it does

    def step(self, count: int = 1) -> None:
        """Holds the present targets for `count` steps of the world, watching contacts and the vacuum."""
        for _ in range(count):
            self._drive(self.q_target, np.zeros_like(self.q_target))
            self._advance()

    def wait(self, seconds: float) -> None:
        """Holds still for a time in [s]."""
        self.step(max(1, round(seconds / self.world.time_step)))

    def follow(self, trajectory: Motion, *, keep_offset: bool = False) -> float:
        """Follow a joint trajectory and wait until its end is reached.

        An arm that is not where the trajectory starts does not jump there: it joins on the way. One that is
        pushed off its path (`Control.strayed`) stops, and holds where it is then.

        Args:
            trajectory: Times, positions and velocities; it should start where the arm is, or near.
            keep_offset: Stay as far beside the trajectory as the arm is at its start instead of joining it.

        Returns:
            The largest joint error at the end in [rad]: above `Control.settled` something is in the way. Of
            an arm that stopped before, how far it is from the end.
        """
        return self._follow(trajectory, keep_offset=keep_offset)

    def follow_until(self, trajectory: Motion, force: float) -> float:
        """Follow a joint trajectory, and stop where something holds the hand up: a guarded motion.

        The arm holds still for a moment before, to tare the wrist.

        Args:
            trajectory: It should start where the arm is.
            force: In [N], what the wrist feels more than at the start when the arm stops.

        Returns:
            The largest joint error at the end in [rad], or 0 where it stopped before.
        """
        self.tare()
        return self._follow(trajectory, force)

    def tare(self) -> None:
        """Hold still for a moment and take what the wrist feels for its offset and the weight of the hand."""
        readings: list[FloatArray] = []
        for _ in range(max(1, round(self.control.tare / self.world.time_step))):
            self.step()
            readings.append(self.wrist.reading())
        self.wrist.tare(readings)

    def _follow(self, trajectory: Motion, force: float = math.inf, keep_offset: bool = False) -> float:
        times, steps = trajectory.times, int(np.ceil(trajectory.times[-1] / self.world.time_step))
        short = self.q_target - trajectory.positions[0]
        for k in range(1, steps + 1):
            t = min(k * self.world.time_step, float(times[-1]))
            q = np.array([np.interp(t, times, column) for column in trajectory.positions.T])
            v = np.array([np.interp(t, times, column) for column in trajectory.velocities.T])
            q += short if keep_offset else (1.0 - t / times[-1]) * short
            v -= 0.0 if keep_offset else short / times[-1]
            self._drive(q, v)
            self._advance()
            if force < math.inf and self.wrist.force() > force:
                self.q_target = q
                return 0.0
            if np.abs((now := self.q) - q).max() > self.control.strayed:
                self.q_target = now
                self.step(round(self.control.patience / self.world.time_step))
                return float(np.abs(now - trajectory.positions[-1]).max())
        self.q_target = trajectory.positions[-1] + (short if keep_offset else 0.0)
        for _ in range(round(self.control.patience / self.world.time_step)):
            if self._error() < self.control.settled:
                break
            self.step()
        return self._error()

    def open(self, opening: float | None = None) -> None:
        """Opens the jaw to a pad distance in [m], fully if not given, and waits for it."""
        if self.jaw:
            self._opening = self.jaw.max_opening if opening is None else min(opening, self.jaw.max_opening)
            self._grip_force = self.jaw.force
            self._wait_for_hand()

    def close(self, force: float) -> float:
        """Closes the jaw with a force in [N] until it stalls.

        The pad that comes first does not push the object to the other one, and pads that meet it askew do not
        turn it: the jaw closes gently while the hand gives way, as a compliant arm does, and presses after.

        Returns:
            The distance of the pads in [m]: near zero when there is nothing between them.

        Raises:
            InvalidInput: If the hand has no fingers.
        """
        if not self.jaw:
            raise InvalidInput(f"{self.arm.name} has no fingers to close: use a robot with a parallel jaw")
        self._opening = 0.0
        force = min(force, self.jaw.force)
        self._grip_force = min(force, self.control.gentle)
        compliance = Compliance(
            self.arm,
            self.pose_base_to_world,
            self.q_target,
            stride=self.jaw.speed / 2.0 * self.world.time_step,
            turn=self.control.turn_admittance * self.world.time_step,
        )
        self._wait_for_hand(lambda: self._give_way(compliance))
        self._grip_force = force
        self._wait_for_hand()
        return self.opening

    def extend(self, extension: float) -> None:
        """Pushes the suction cup out of the palm by a distance in [m] and waits for it."""
        if self.cup and self.cup.joint is not None:
            self._extension = extension
            self._wait_for_hand()

    def suck(self) -> bool:
        """Switches the vacuum on.

        Returns:
            Whether the lip seals on an object; if not, the vacuum is off again.

        Raises:
            InvalidInput: If the hand has no cup.
        """
        if not self.cup:
            raise InvalidInput(f"{self.arm.name} has no suction cup: use a robot such as panda-suction")
        tool = self.arm.tool(ToolName.SUCTION)
        pose_lip_to_world = self.link_pose(tool.link) @ tool.pose_tool_to_link
        self.vacuum = Vacuum.on(self.world, self.id, self._link[self.cup.link], pose_lip_to_world, self.cup)
        if self.cup.joint is not None:  # what gave way as the lip was seated does not push back
            index, client = self._index[self.cup.joint], self.world.client
            self._extension = float(pybullet.getJointState(self.id, index, physicsClientId=client)[0])
        return self.vacuum is not None

    def release(self, opening: float | None = None) -> None:
        """Switches the vacuum off, or opens the jaw to a pad distance in [m], fully if not given."""
        if self.vacuum is not None:
            self.vacuum.off()
            self.vacuum = None
        else:
            self.open(opening)

    def link_pose(self, link: str) -> FloatArray:
        """(4, 4) measured pose of a link's frame in the world."""
        state: Any = pybullet.getLinkState(
            self.id, self._link[link], computeForwardKinematics=1, physicsClientId=self.world.client
        )
        return pose_from(state[4], state[5])

    def link_poses(self) -> dict[str, FloatArray]:
        """Link -> (4, 4) measured pose of its frame in the world."""
        found = {link: self.link_pose(link) for link in self.arm.links if link in self._link}
        return {self.arm.links[0]: self.pose_base_to_world, **found}

    def _error(self) -> float:
        return float(np.abs(self.q - self.q_target).max())

    def _give_way(self, compliance: Compliance) -> None:
        """Holds what a compliant arm would, with these forces on its pads."""
        assert self.jaw is not None
        tool = self.arm.tool(ToolName.FINGERS)
        pose_tool_to_world = self.link_pose(tool.link) @ tool.pose_tool_to_link
        pads = {self._link[link] for link in self.jaw.links}
        points: Any = pybullet.getContactPoints(bodyA=self.id, physicsClientId=self.world.client)
        pressing = [point for point in points if point[3] in pads]
        places = np.array([point[5] for point in pressing]).reshape(-1, 3) - pose_tool_to_world[:3, 3]
        forces = np.array([np.multiply(point[9], point[7]) for point in pressing]).reshape(-1, 3)
        turn = pose_tool_to_world[:3, :3]
        self.q_target = compliance.after(self.q_target, pose_tool_to_world, places @ turn, forces @ turn)

    def _wait_for_hand(self, each_step: Callable[[], None] | None = None) -> None:
        """Until the hand's joints stand still, or three seconds have passed."""
        joints = list(self._hand_values())
        moving, before = 0, np.full(len(joints), np.inf)
        for k in range(round(3.0 / self.world.time_step)):
            self.step()
            if each_step is not None:
                each_step()
            if k % 12 == 0:
                states: Any = pybullet.getJointStates(
                    self.id, [self._index[name] for name in joints], physicsClientId=self.world.client
                )
                now = np.array([state[0] for state in states])
                still = np.abs(now - before).max() < self.control.stall * 12 * self.world.time_step
                moving, before = (moving + 1 if still else 0), now
                if moving >= 3:
                    return

    def _drive(self, q: FloatArray, v: FloatArray) -> None:
        client, count = self.world.client, len(self._arm_joints)
        pybullet.setJointMotorControlArray(
            self.id, self._arm_joints, pybullet.POSITION_CONTROL, targetPositions=q.tolist(),
            targetVelocities=v.tolist(), forces=self._arm_forces,
            positionGains=[self.control.position_gain] * count,
            velocityGains=[self.control.velocity_gain] * count,
            physicsClientId=client,
        )  # fmt: skip
        if self.jaw:
            share = 2.0 * self._grip_force / len(self.jaw.joints)  # all joints together press both pads
            for name, value in self.jaw.values(self._opening).items():
                pybullet.setJointMotorControl2(
                    self.id, self._index[name], pybullet.POSITION_CONTROL, targetPosition=value,
                    force=share * self.jaw.lever(name),
                    maxVelocity=self.jaw.speed / 2 / self.jaw.lever(name), physicsClientId=client,
                )  # fmt: skip
        if self.cup:
            push = self.control.seating if self.vacuum is None else math.inf
            for name, value in self.cup.values(self._extension).items():
                pybullet.setJointMotorControl2(
                    self.id, self._index[name], pybullet.POSITION_CONTROL, targetPosition=value,
                    force=min(push, self._limit[name]), maxVelocity=self.cup.speed, physicsClientId=client,
                )  # fmt: skip

    def _advance(self) -> None:
        self.world.step()
        if self.vacuum is not None:
            self.vacuum.check()
        note_touches(self.touched, self.world, self.id, self._names)
        for watch in self.on_step:
            watch()
