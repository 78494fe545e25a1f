"""An arm that acts in a world, whatever engine plays it: how it follows motions, closes and feels."""

from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator, Sequence

import numpy as np

from topple.robots.arm.arm import Arm
from topple.robots.arm.cup import SuctionCup
from topple.robots.arm.gripper import FINGERS, ToolState
from topple.robots.driver import Trajectory
from topple.robots.driver.control import Control
from topple.robots.poses import inverse
from topple.robots.tolerances import TOLERANCES
from topple.robots.world.compliance import Compliance
from topple.robots.world.physical_world import PhysicalWorld
from topple.robots.world.rendering import NOBODY, Shown, surfaces_of
from topple.robots.world.touch import Touch
from topple.robots.world.vacuum import Vacuum
from topple.robots.world.wrist import Wrist
from topple.topology.base.arrays import FloatArray, round_off
from topple.topology.base.errors import InvalidInput


class ActingArm(ABC):
    """A `Driver` of one arm in a world; records everything it touches, for a judge to see.

    Args:
        arm: The arm.
        pose_base_to_world: (4, 4) where it stands.
        q: (n,) joint values to start with; the arm's home if not given.
    """

    wrist: Wrist

    def __init__(
        self,
        arm: Arm,
        pose_base_to_world: FloatArray,
        q: FloatArray | None = None,
    ) -> None:
        self.arm, self.control = arm, Control()
        self.pose_base_to_world = np.array(pose_base_to_world, dtype=float)
        self.q_target = self._sent = round_off(np.array(arm.home if q is None else q, dtype=float))
        self.jaw, self.cup = arm.jaw, arm.cup
        self._opening, self._extension = arm.open_hand.opening, arm.open_hand.cup_extension
        self._grip_force = self.jaw.force if self.jaw else 0.0
        self.vacuum: Vacuum | None = None
        self.touched: dict[str, Touch] = {}
        self.on_step: list[Callable[[], None]] = []

    @property
    @abstractmethod
    def world(self) -> PhysicalWorld:
        """The world it stands in."""

    def _hand_values(self) -> dict[str, float]:
        return self.arm.hand_values(self.tool_state)

    # -- what it senses

    @property
    def joint_names(self) -> tuple[str, ...]:
        """Of the arm's joints, then of its hand's."""
        return (*self.arm.joints, *self._hand_values())

    @property
    def q(self) -> FloatArray:
        """(n,) measured joint values in [rad]."""
        return self.joint_positions(self.arm.joints)

    @property
    def joint_targets(self) -> FloatArray:
        """(k,) what the arm's joints, then its hand's, are told to be, in [rad] or [m]."""
        return np.array([*self._sent, *self._hand_values().values()])

    @abstractmethod
    def joint_positions(self, names: Sequence[str]) -> FloatArray:
        """Measured values of some joints in [rad] or [m]."""

    @property
    def opening(self) -> float:
        """Measured distance of the pads in [m]; 0 without a jaw."""
        if not self.jaw:
            return 0.0
        values = self.joint_positions(self.jaw.joints)
        return self.jaw.opening(dict(zip(self.jaw.joints, values.tolist(), strict=True)))

    @property
    def grip_force(self) -> float:
        """Force in [N] with which the jaw's motors press each pad, as currents tell; 0 without a jaw."""
        if not self.jaw:
            return 0.0
        efforts = self.efforts(self.jaw.joints)
        pushed = [abs(e) / self.jaw.lever(name) for name, e in zip(self.jaw.joints, efforts, strict=True)]
        return float(sum(pushed)) / 2.0  # all joints together press both pads

    @abstractmethod
    def efforts(self, names: Sequence[str]) -> Sequence[float]:
        """Efforts of the motors of some joints in [N m] or [N]."""

    @property
    def sealed(self) -> bool | None:
        """Whether the cup's vacuum stands; None where it is off."""
        return None if self.vacuum is None else self.vacuum.sealed

    def unseal(self) -> None:
        """Switch the vacuum off."""
        if self.vacuum is not None:
            self.vacuum.off()
            self.vacuum = None

    @abstractmethod
    def on_pads(self) -> tuple[FloatArray, FloatArray]:
        """Where something presses on the pads (k, 3) in [m], and how (k, 3) in [N], in the world."""

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
        if (sealed := self.sealed) is not None:
            return sealed
        short = self.opening - self._opening
        return short > TOLERANCES.empty_jaw and self.grip_force > TOLERANCES.stalled * self._grip_force

    def pose_in_hand(self, name: str, tool: str) -> FloatArray:
        """(4, 4) pose_object_to_tool of an object: how it moves in the hand is what a judge asks."""
        return inverse(self.tool_pose(tool)) @ self.world.pose(name)

    def tool_pose(self, tool: str) -> FloatArray:
        """(4, 4) pose_tool_to_world where a tool truly is."""
        frame = self.arm.tool(tool)
        return self.link_pose(frame.link) @ frame.pose_tool_to_link

    @abstractmethod
    def link_pose(self, link: str) -> FloatArray:
        """(4, 4) measured pose of a link's frame in the world."""

    def link_poses(self) -> dict[str, FloatArray]:
        """Link -> (4, 4) measured pose of its frame in the world."""
        found = {link: self.link_pose(link) for link in self.arm.links[1:]}
        return {self.arm.links[0]: self.pose_base_to_world, **found}

    def shown(self) -> Iterator[Shown]:
        """Surfaces of the arm that cameras see, where they are now."""
        poses = self.link_poses()
        for link, surfaces in surfaces_of(self.arm).items():
            for surface in surfaces:
                yield surface, poses[link], NOBODY

    def _error(self) -> float:
        return float(np.abs(self.q - self.q_target).max())

    # -- what it does

    def step(self, count: int = 1) -> None:
        """Holds the present targets for `count` steps of the world, watching contacts and the vacuum."""
        for _ in range(count):
            self._send(self.q_target, np.zeros_like(self.q_target))
            self._advance()

    def wait(self, seconds: float) -> None:
        """Holds still for a time in [s]."""
        self.step(max(1, round(seconds / self.world.time_step)))

    def follow(self, trajectory: Trajectory, *, keep_offset: bool = False) -> float:
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

    def follow_until(self, trajectory: Trajectory, force: float) -> float:
        """Follow a joint trajectory, and stop where something holds the hand up: a guarded motion.

        The arm holds still for a moment before, to tare the wrist.

        Args:
            trajectory: It should start where the arm is.
            force: In [N], what the wrist feels more than at the start when the arm stops.

        Returns:
            The largest joint error at the end in [rad], or 0 where it stopped before.
        """
        self.tare()
        return self._follow(trajectory, lambda: self.wrist.force() > force)

    def follow_while(self, trajectory: Trajectory, going: Callable[[], bool]) -> float:
        """Follow a joint trajectory beside which the arm stays, and stop where something says so.

        Args:
            trajectory: It should start where the arm is, or near; the arm stays as far beside it as it is.
            going: Asked after every time step; False stops the arm.

        Returns:
            As `follow_until`.
        """
        return self._follow(trajectory, lambda: not going(), keep_offset=True)

    def tare(self) -> None:
        """Hold still for a moment and take what the wrist feels for its offset and the weight of the hand."""
        readings: list[FloatArray] = []
        for _ in range(max(1, round(self.control.tare / self.world.time_step))):
            self.step()
            readings.append(self.wrist.reading())
        self.wrist.tare(readings)

    def _follow(
        self, trajectory: Trajectory, stop: Callable[[], bool] = lambda: False, keep_offset: bool = False
    ) -> float:
        times, steps = trajectory.times, int(np.ceil(trajectory.times[-1] / self.world.time_step))
        short = self.q_target - trajectory.positions[0]
        sampled = np.minimum(np.arange(1, steps + 1) * self.world.time_step, times[-1])
        for t, q, v in zip(
            sampled.tolist(),
            _interpolate(sampled, times, trajectory.positions),
            _interpolate(sampled, times, trajectory.velocities),
            strict=True,
        ):
            q += short if keep_offset else (1.0 - t / times[-1]) * short
            v -= 0.0 if keep_offset else short / times[-1]
            self._send(q, v)
            self._advance()
            if stop():
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
            opening = self.jaw.max_opening if opening is None else min(opening, self.jaw.max_opening)
            self._opening = float(round_off(opening))
            self._grip_force = self.jaw.force
            self._stiffen_pads(False)
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
        self._stiffen_pads(True)
        self._wait_for_hand()
        return self.opening

    def extend(self, extension: float) -> None:
        """Pushes the suction cup out of the palm by a distance in [m] and waits for it."""
        if self.cup and self.cup.joint is not None:
            self._extension = float(round_off(extension))
            self._wait_for_hand()

    def release(self, opening: float | None = None) -> None:
        """Switches the vacuum off, or opens the jaw to a pad distance in [m], fully if not given."""
        if self.sealed is not None:
            self.unseal()
        else:
            self.open(opening)

    def suck(self) -> bool:
        """Switch the vacuum on.

        Returns:
            Whether the lip seals on an object; if not, the vacuum is off again.

        Raises:
            InvalidInput: The hand has no cup.
        """
        if not self.cup:
            raise InvalidInput(f"{self.arm.name} has no suction cup: use a robot such as panda-suction")
        tool = next(name for name, tool in self.arm.tools.items() if tool.gripper.cup is self.cup)
        self.vacuum = self._vacuum_on(self.cup, self.tool_pose(tool))
        if self.cup.joint is not None:  # what gave way as the lip was seated does not push back
            self._extension = float(self.joint_positions([self.cup.joint])[0])
        return self.vacuum is not None

    @abstractmethod
    def _vacuum_on(self, cup: SuctionCup, pose_lip_to_world: FloatArray) -> Vacuum | None:
        """The cup's vacuum, where its lip at a pose (4, 4) seals on something that moves."""

    def _stiffen_pads(self, pressing: bool) -> None:
        """Make pads stiff while they press, where the engine lets soft ones drag what they hold."""
        del pressing

    def _give_way(self, compliance: Compliance) -> None:
        """Holds what a compliant arm would, with these forces on its pads."""
        assert self.jaw is not None
        tool = self.arm.tool(FINGERS)
        pose_tool_to_world = self.link_pose(tool.link) @ tool.pose_tool_to_link
        places, forces = self.on_pads()
        places = places - pose_tool_to_world[:3, 3]
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
                now = self.joint_positions(joints)
                still = np.abs(now - before).max() < self.control.stall * 12 * self.world.time_step
                moving, before = (moving + 1 if still else 0), now
                if moving >= 3:
                    return

    def _send(self, q: FloatArray, v: FloatArray) -> None:
        self._sent = round_off(q)
        self._drive(self._sent, round_off(v))

    @abstractmethod
    def _drive(self, q: FloatArray, v: FloatArray) -> None:
        """Tell the motors where to go: joint values (n,) and speeds (n,)."""

    @abstractmethod
    def _advance(self) -> None:
        """Let the world take a step, watching contacts and the vacuum."""


def _interpolate(when: FloatArray, times: FloatArray, values: FloatArray) -> FloatArray:
    """(k, n) values at k times [s], linear between those (t, n) given at t times [s]."""
    return np.stack([np.interp(when, times, column) for column in values.T], axis=1)
