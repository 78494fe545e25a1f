"""What topple asks of an arm that carries a plan out: a simulated one, another simulator's, or a real one.

Nothing here tells what the arm is about to take or what it meets: a driver moves joints and a hand, and feels
a force, the pads' distance and the vacuum.
"""

from collections.abc import Callable, Collection, Iterator
from dataclasses import dataclass, fields
from typing import Annotated, Protocol, runtime_checkable

import numpy as np
from msgspec import Meta

from topple.robots.arm.arm import Arm
from topple.robots.arm.gripper import ToolState
from topple.topology.base.arrays import FloatArray, freeze
from topple.topology.base.values import ByValue

# (n,) and (m, n) numbers, in a file a list and a list of lists
Samples = np.ndarray[tuple[int], np.dtype[np.float64]]
Rows = np.ndarray[tuple[int, int], np.dtype[np.float64]]
_LIST = Meta(extra_json_schema={"items": {"type": "number"}})
_LISTS = Meta(extra_json_schema={"items": {"type": "array", "items": {"type": "number"}}})


@dataclass(frozen=True, eq=False)
class Trajectory(ByValue):
    """Joint positions over time: times (t,) [s] from 0, positions (t, n) [rad] or [m], velocities (t, n)."""

    times: Annotated[Samples, _LIST]
    positions: Annotated[Rows, _LISTS]
    velocities: Annotated[Rows, _LISTS]

    def __post_init__(self) -> None:
        for each in fields(self):
            object.__setattr__(self, each.name, freeze(getattr(self, each.name)))

    def __iter__(self) -> Iterator[FloatArray]:
        return iter((self.times, self.positions, self.velocities))


@runtime_checkable
class Driver(Protocol):
    """An arm with its hand.

    Every method returns when what it asks for is done, or cannot be done. Forces are in [N], lengths in [m].

    Examples:
        >>> with World() as world:
        ...     isinstance(SimulatedArm(world, robot("panda"), np.eye(4)), Driver)
        True
    """

    @property
    def arm(self) -> Arm:
        """Its kinematics, limits and tools."""
        ...

    @property
    def pose_base_to_world(self) -> FloatArray:
        """(4, 4) where it stands."""
        ...

    @property
    def q_target(self) -> FloatArray:
        """(n,) joint values that it holds, in [rad] or [m]."""
        ...

    @property
    def tool_state(self) -> ToolState:
        """How the hand is told to stand."""
        ...

    @property
    def opening(self) -> float:
        """Measured distance of the pads; 0 without a jaw."""
        ...

    @property
    def holding(self) -> bool:
        """Whether the jaw stalls on something before it is closed, or the cup's vacuum stands."""
        ...

    def follow(self, trajectory: Trajectory, *, keep_offset: bool = False) -> float:
        """Follow a joint trajectory to its end.

        Args:
            trajectory: It should start where the arm is, or near.
            keep_offset: Stay as far beside the trajectory as the arm is at its start, instead of joining it.

        Returns:
            The largest joint error at the end in [rad] or [m]. A driver that stops an arm which is pushed off
            its path says how far it is from the end; the rest of the path is then driven once more.
        """
        ...

    def follow_until(self, trajectory: Trajectory, force: float) -> float:
        """Follow a joint trajectory, and stop where something holds the hand up: a guarded motion.

        Args:
            trajectory: It should start where the arm is.
            force: What the wrist feels more than at the start when it stops: the hand's weight and that of
                what it holds are none of it.

        Returns:
            The largest joint error at the end, or 0 where it stopped before.
        """
        ...

    def open(self, opening: float | None = None) -> None:
        """Open the jaw to a pad distance, fully if not given; nothing without a jaw."""
        ...

    def close(self, force: float) -> float:
        """Close the jaw with a force until it stalls; returns the pads' distance."""
        ...

    def extend(self, extension: float) -> None:
        """Push the suction cup out of the palm by a distance; nothing without a cup."""
        ...

    def suck(self) -> bool:
        """Switch the vacuum on; returns whether the lip seals on something. If not it is off again."""
        ...

    def release(self, opening: float | None = None) -> None:
        """Switch the vacuum off, or open the jaw to a pad distance, fully if not given."""
        ...

    def wait(self, seconds: float) -> None:
        """Hold still for a time in [s]."""
        ...


@runtime_checkable
class Interruptible(Protocol):
    """What a driver offers besides whose motions can be stopped by what others see."""

    def follow_while(self, trajectory: Trajectory, going: Callable[[], bool]) -> float:
        """Follow a joint trajectory, as far beside it as the arm is, for as long as `going` says True.

        Args:
            trajectory: It should start where the arm is, or near.
            going: Asked many times a second.

        Returns:
            The largest joint error at the end, or 0 where it stopped before.
        """
        ...


@runtime_checkable
class Fixture(Protocol):
    """What keeps things where they stand, such as a vice, until a hand holds them."""

    @property
    def clamped(self) -> Collection[str]:
        """Names of what it keeps now."""
        ...

    def release(self, name: str) -> None:
        """Let go of an object: the hand has closed on it."""
        ...
