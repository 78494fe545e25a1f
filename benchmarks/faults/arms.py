"""Arms that go wrong: each hands on to another driver, and spoils one thing of what it does."""

from collections.abc import Generator
from contextlib import contextmanager

import numpy as np

from topple.robots.arm.arm import Arm
from topple.robots.arm.gripper import ToolState
from topple.robots.driver import Trajectory
from topple.robots.engine import pybullet
from topple.robots.world.simulated_arm import SimulatedArm
from topple.topology.base.arrays import FloatArray

PUSHED = 0.02  # [m] that the hand is pushed aside
PUSH = 1000.0  # [N] that the push grows to at most: motors give way to a third of that
PUSH_TIME = 1.0  # [s] in which it grows: who leans against an arm does not hit it


class Through:
    """A driver that hands everything on to a simulated arm.

    Args:
        inner: The arm.
        rng: When and where to things go wrong.
    """

    def __init__(self, inner: SimulatedArm, rng: np.random.Generator) -> None:
        self.inner, self.rng = inner, rng

    @property
    def arm(self) -> Arm:
        """Its kinematics, limits and tools."""
        return self.inner.arm

    @property
    def pose_base_to_world(self) -> FloatArray:
        """(4, 4) where it stands, as it believes."""
        return self.inner.pose_base_to_world

    @property
    def q_target(self) -> FloatArray:
        """(n,) joint values that it holds [rad]."""
        return self.inner.q_target

    @property
    def tool_state(self) -> ToolState:
        """How the hand is told to stand."""
        return self.inner.tool_state

    @property
    def opening(self) -> float:
        """Measured distance of the pads [m]."""
        return self.inner.opening

    @property
    def holding(self) -> bool:
        """Whether something is in the hand."""
        return self.inner.holding

    def follow(self, trajectory: Trajectory, *, keep_offset: bool = False) -> float:
        """Follow a joint trajectory to its end."""
        return self.inner.follow(trajectory, keep_offset=keep_offset)

    def follow_until(self, trajectory: Trajectory, force: float) -> float:
        """Follow a joint trajectory, and stop where something holds the hand up."""
        return self.inner.follow_until(trajectory, force)

    def open(self, opening: float | None = None) -> None:
        """Open the jaw."""
        self.inner.open(opening)

    def close(self, force: float) -> float:
        """Close the jaw."""
        return self.inner.close(force)

    def extend(self, extension: float) -> None:
        """Push the cup out."""
        self.inner.extend(extension)

    def suck(self) -> bool:
        """Switch the vacuum on."""
        return self.inner.suck()

    def release(self, opening: float | None = None) -> None:
        """Let go."""
        self.inner.release(opening)

    def wait(self, seconds: float) -> None:
        """Hold still."""
        self.inner.wait(seconds)


class Pushed(Through):
    """Somebody pushes the hand aside by two centimetres, once, in the middle of a long motion."""

    def __init__(self, inner: SimulatedArm, rng: np.random.Generator) -> None:
        super().__init__(inner, rng)
        self._left = int(rng.integers(0, 4))  # motions before the one in which it happens
        self._aside = rng.uniform(0.0, 2.0 * np.pi)

    def follow(self, trajectory: Trajectory, *, keep_offset: bool = False) -> float:
        """Follow a trajectory, and be pushed at half of its way."""
        self._left -= 1
        if self._left != -1:
            return super().follow(trajectory, keep_offset=keep_offset)
        with self._somebody(trajectory):
            return super().follow(trajectory, keep_offset=keep_offset)

    @contextmanager
    def _somebody(self, trajectory: Trajectory) -> Generator[None, None, None]:
        """Pushes the hand at half of the time until it is off its path, or half a second."""
        inner, world = self.inner, self.inner.world
        tool = next(iter(inner.arm.tools))
        link = inner.arm.tool(tool).link
        number = inner._link[link]
        start, direction = world.time, np.array([np.cos(self._aside), np.sin(self._aside), 0.0])
        off = False

        def push() -> None:
            nonlocal off
            t = world.time - start
            middle = float(trajectory.times[-1]) / 2.0
            if off or not middle <= t <= middle + PUSH_TIME:
                return
            q = np.array([np.interp(t, trajectory.times, column) for column in trajectory.positions.T])
            frame = inner.arm.tool(tool).pose_tool_to_link
            here = (inner.link_pose(link) @ frame)[:3, 3]
            there = (inner.pose_base_to_world @ inner.arm.tool_pose(q, tool)[0])[:3, 3]
            if float((here - there) @ direction) >= PUSHED:
                off = True
                return
            force = PUSH * (t - middle) / PUSH_TIME * direction
            pybullet.applyExternalForce(
                inner.id, number, force.tolist(), here.tolist(), pybullet.WORLD_FRAME,
                physicsClientId=world.client,
            )  # fmt: skip

        inner.on_step.append(push)
        try:
            yield
        finally:
            inner.on_step.remove(push)


class Jammed(Through):
    """The jaw closes, and from some moment on does not open any more."""

    def __init__(self, inner: SimulatedArm, rng: np.random.Generator) -> None:
        super().__init__(inner, rng)
        self._left = int(rng.integers(0, 6))  # times that it still opens

    def open(self, opening: float | None = None) -> None:
        """Open it, or not."""
        self._left -= 1
        if self._left >= 0:
            super().open(opening)

    def release(self, opening: float | None = None) -> None:
        """Let go, or not."""
        self._left -= 1
        if self._left >= 0:
            super().release(opening)


class Leaking(Through):
    """The vacuum breaks down half-way through a motion with something on the cup, once."""

    def __init__(self, inner: SimulatedArm, rng: np.random.Generator) -> None:
        super().__init__(inner, rng)
        self._left = int(rng.integers(0, 2))  # motions with something on the cup before it happens

    def follow(self, trajectory: Trajectory, *, keep_offset: bool = False) -> float:
        """Follow a trajectory, and lose what hangs there at half of its way."""
        if self.inner.vacuum is None or not self.inner.holding:
            return super().follow(trajectory, keep_offset=keep_offset)
        self._left -= 1
        if self._left != -1:
            return super().follow(trajectory, keep_offset=keep_offset)
        start, world = self.inner.world.time, self.inner.world

        def leak() -> None:
            if self.inner.vacuum is not None and world.time - start > trajectory.times[-1] / 2.0:
                self.inner.vacuum.off()

        self.inner.on_step.append(leak)
        try:
            return super().follow(trajectory, keep_offset=keep_offset)
        finally:
            self.inner.on_step.remove(leak)


class Misplaced(Through):
    """Stands three centimetres from where it believes to stand."""

    def __init__(self, inner: SimulatedArm, rng: np.random.Generator) -> None:
        super().__init__(inner, rng)
        angle = rng.uniform(0.0, 2.0 * np.pi)
        self._believed = inner.pose_base_to_world.copy()
        self._believed[:2, 3] += 0.03 * np.array([np.cos(angle), np.sin(angle)])

    @property
    def pose_base_to_world(self) -> FloatArray:
        """(4, 4) where it believes to stand."""
        return self._believed
