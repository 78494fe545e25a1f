"""A `Driver` of an arm whose controller follows joint trajectories, as those of ROS 2 do, and of its hand."""

from dataclasses import dataclass, field, replace
from typing import Protocol

import numpy as np

from topple.robots.arm.arm import Arm
from topple.robots.arm.gripper import ToolState
from topple.robots.driver import Trajectory
from topple.robots.driver.control import Control
from topple.robots.tolerances import TOLERANCES
from topple.topology.base.arrays import FloatArray
from topple.topology.base.errors import InvalidInput


class Controller(Protocol):
    """What follows joint trajectories; no call waits but `wait` and `tare`."""

    @property
    def joints(self) -> FloatArray:
        """(n,) measured values of the arm's joints [rad] or [m]."""
        ...

    @property
    def moving(self) -> bool:
        """Whether a trajectory is followed: it was not stopped, given up or brought to its end."""
        ...

    @property
    def force(self) -> float:
        """How hard something presses on the hand, beyond what it bore when it was last tared [N]."""
        ...

    def tare(self) -> None:
        """Take what the wrist feels, now that the arm is at rest, for the weight of hand and load; waits."""

    def start(self, times: FloatArray, positions: FloatArray, velocities: FloatArray) -> None:
        """Follow a trajectory from now on: times (t,) [s] from 0, positions and velocities (t, n)."""

    def stop(self) -> None:
        """Follow no more, and hold still."""

    def wait(self, seconds: float) -> None:
        """Let a time [s] pass."""


class HandController(Protocol):
    """What moves two pads and switches a vacuum, or one of the two; its calls return when that is done."""

    @property
    def opening(self) -> float:
        """Measured distance of the pads [m]; 0 without any."""
        ...

    @property
    def sealed(self) -> bool | None:
        """Whether the vacuum stands; None where it is off."""

    def move(self, opening: float, force: float) -> None:
        """Bring the pads to a distance [m] with at most a force [N]; they may stall before."""

    def extend(self, extension: float) -> None:
        """Push the cup out of the palm by a distance [m], if it can be."""

    def switch(self, on: bool) -> None:
        """Switch the vacuum on or off."""


@dataclass
class TrajectoryDriver:
    """An arm behind a controller, and its hand, if it has one.

    Attributes:
        arm: Its kinematics, limits and tools.
        pose_base_to_world: (4, 4) where it stands.
        controller: What moves the arm.
        hand: What moves its hand.
        control: When the end of a trajectory counts as reached, how long that may take, and for how long an
            arm that was told to stop is waited for (`tare`).
        tick: Seconds between two looks at what moves: at 0.1 m/s a guarded motion goes 1 mm on.
        q_target: (n,) joint values that it holds.
        tool_state: How the hand is told to stand.
    """

    arm: Arm
    pose_base_to_world: FloatArray
    controller: Controller
    hand: HandController | None = None
    control: Control = field(default_factory=Control)
    tick: float = 0.01
    q_target: FloatArray = field(init=False)
    tool_state: ToolState = field(init=False)

    def __post_init__(self) -> None:
        self.q_target, self.tool_state = np.array(self.controller.joints), ToolState(self.opening)

    @property
    def opening(self) -> float:
        """Measured distance of the pads; 0 without a jaw."""
        return 0.0 if self.hand is None else self.hand.opening

    @property
    def holding(self) -> bool:
        """Whether the vacuum stands, or the jaw stopped short of where it was told to close to."""
        sealed = None if self.hand is None else self.hand.sealed
        return self.opening - self.tool_state.opening > TOLERANCES.empty_jaw if sealed is None else sealed

    def follow(self, trajectory: Trajectory, *, keep_offset: bool = False) -> float:
        """Follow a joint trajectory to its end; see `Driver`."""
        return self._follow(trajectory, np.inf, keep_offset)

    def follow_until(self, trajectory: Trajectory, force: float) -> float:
        """Follow a joint trajectory, and stop where something holds the hand up; see `Driver`."""
        self.controller.tare()
        return self._follow(trajectory, force)

    def _follow(self, trajectory: Trajectory, force: float, keep_offset: bool = False) -> float:
        times, controller = trajectory.times, self.controller
        short = self.q_target - trajectory.positions[0]
        left = np.ones_like(times) if keep_offset else 1.0 - times / times[-1]
        speed = 0.0 if keep_offset else short / times[-1]
        positions = trajectory.positions + left[:, None] * short
        controller.start(times, positions, trajectory.velocities - speed)
        while controller.moving:
            controller.wait(self.tick)
            if controller.force > force:
                controller.stop()
                controller.wait(self.control.tare)
                self.q_target = np.array(controller.joints)
                return 0.0
        waited = 0.0
        while (error := float(np.abs(controller.joints - positions[-1]).max())) >= self.control.settled:
            if waited >= self.control.patience:
                self.q_target = np.array(controller.joints)
                return error
            controller.wait(self.tick)
            waited += self.tick
        self.q_target = positions[-1]
        return error

    def open(self, opening: float | None = None) -> None:
        """Open the jaw to a pad distance, fully if not given; nothing without a jaw."""
        if self.hand is not None and self.arm.jaw is not None:
            most = self.arm.jaw.max_opening
            self._move(most if opening is None else min(opening, most), self.arm.jaw.force)

    def close(self, force: float) -> float:
        """Close the jaw with a force until it stalls; returns the pads' distance."""
        self._move(0.0, force)
        self.q_target = np.array(self.controller.joints)  # a compliant arm gave way
        return self.opening

    def _move(self, opening: float, force: float) -> None:
        self.tool_state = replace(self.tool_state, opening=opening)
        self._hand.move(opening, force)

    def extend(self, extension: float) -> None:
        """Push the suction cup out of the palm by a distance; nothing without a cup."""
        if self.hand is not None and self.arm.cup is not None:
            self.tool_state = replace(self.tool_state, cup_extension=extension)
            self.hand.extend(extension)

    def suck(self) -> bool:
        """Switch the vacuum on; returns whether the lip seals on something. If not it is off again."""
        self._hand.switch(True)
        if not (sealed := bool(self._hand.sealed)):
            self._hand.switch(False)
        return sealed

    def release(self, opening: float | None = None) -> None:
        """Switch the vacuum off, or open the jaw to a pad distance, fully if not given."""
        if self.hand is not None and self.hand.sealed is not None:
            self.hand.switch(False)
        else:
            self.open(opening)

    def wait(self, seconds: float) -> None:
        """Hold still for a time in [s]."""
        self.controller.wait(seconds)

    @property
    def _hand(self) -> HandController:
        """The hand.

        Raises:
            InvalidInput: There is none.
        """
        if self.hand is None:
            raise InvalidInput(f"{self.arm.name} has no hand to take with: give the driver what moves it")
        return self.hand
