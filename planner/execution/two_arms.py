"""Two arms at work, one at a time: one holds what would not stand while the other takes something."""

from dataclasses import replace

import numpy as np

from topple.planner.execution.execute import TAKEN, Outcome, Watch, execute, go_home, retreat
from topple.planner.execution.lift_monitor import LiftMonitor
from topple.planner.execution.tolerances import AT_HOME
from topple.planner.motion.tolerances import GIVES_WAY
from topple.planner.planning.holding import FIRST, SECOND, standing_by
from topple.planner.planning.step import NextStep
from topple.planner.transfer.transfer import Transfer
from topple.robots.arm.arm import Station
from topple.robots.driver import Driver, Fixture
from topple.topology.bodies.solids import Solids


class TwoArms:
    """An arm, and beside it one for what takes two.

    Args:
        first: The arm that does what takes one.
        second: The other arm; None where there is none.
        seed: Of the searches for ways home.
        fixture: What keeps things still until a hand holds them; None where nothing does.

    Attributes:
        queued: The steps that were decided with a hold which is going on.
        grip: How one of them holds something now; None where none does.
    """

    def __init__(
        self, first: Driver, second: Driver | None, seed: int, fixture: Fixture | None = None
    ) -> None:
        self.first, self.second, self._seed, self._fixture = first, second, seed, fixture
        self.queued: tuple[NextStep, ...] = ()
        self.grip: Transfer | None = None

    @property
    def stations(self) -> tuple[Station, Station | None]:
        """How the arms stand."""
        return _station(self.first), None if self.second is None else _station(self.second)

    @property
    def clamped(self) -> frozenset[str]:
        """Names of the objects that a fixture keeps still now."""
        return frozenset() if self._fixture is None else frozenset(self._fixture.clamped)

    def arm_of(self, chosen: NextStep) -> Driver:
        """The arm that does a step."""
        return self.second if chosen.by_second and self.second is not None else self.first

    def obstacles(self, robot: Driver) -> Solids:
        """The bodies (V, 3) of the other arm [m], by name."""
        if self.second is None:
            return {}
        prefix, other = (FIRST, self.first) if robot is self.second else (SECOND, self.second)
        return standing_by(prefix, _station(other))

    def carry_out(self, chosen: NextStep, watch: Watch, monitor: LiftMonitor | None = None) -> Outcome:
        """Do a step, once the other hand holds what it has to.

        Args:
            chosen: The step.
            watch: What looks on at the hand that takes.
            monitor: What its lift is watched with.
        """
        acting = self.arm_of(chosen)
        other = self._beside(acting)
        outcome = self._execute(chosen, acting, other, watch, monitor)
        if other is None or outcome.motion is None:
            return outcome
        still = other.pose_base_to_world @ other.arm.forward(other.q_target, other.tool_state)[0]
        return replace(outcome, motion=replace(outcome.motion, beside=still))

    def _execute(
        self,
        chosen: NextStep,
        acting: Driver,
        other: Driver | None,
        watch: Watch,
        monitor: LiftMonitor | None,
    ) -> Outcome:
        if chosen.grip is not None and other is not None:
            closed = execute(chosen.grip, other)
            if not closed.success:
                return replace(closed, text=f"the other arm: {closed.text}", motion=None)
            self.grip = chosen.grip
            if (off := _gave_way(other, chosen.grip)) > GIVES_WAY:
                said = f"the other arm gave way by {1e3 * off:.0f} mm as its hand closed."
                return replace(closed, success=False, text=said, motion=None)
        if self._holds(chosen) and other is not None:
            if np.abs(other.q_target - np.asarray(other.arm.home)).max() > AT_HOME:
                said = "the other arm found no way home, and this one holds on."
                return Outcome(False, said, np.zeros((0, 3)), stuck=True)
        return execute(chosen.transfer, acting, self._release_watch(chosen, watch), monitor)

    def finish(self, chosen: NextStep, outcome: Outcome, solids: Solids) -> Outcome:
        """Bring home the arm that acted, and go on with a hold, or end it: as decided, or since it failed.

        Args:
            chosen: The step.
            outcome: What became of it.
            solids: Convex parts of everything, in the world [m], as they should be now.

        Returns:
            The outcome, with what became of the hold.
        """
        if outcome.stuck:
            return outcome
        acting = self.arm_of(chosen)
        other, grip = self._beside(acting), self.grip
        self._home(acting, solids)
        self.queued = (chosen.then or self.queued[1:]) if outcome.success else ()
        if other is None:
            return outcome
        if grip is not None and not self._holds(chosen):
            if outcome.success and chosen.let_go is None and other.holding:
                return outcome
            if outcome.success and chosen.let_go is not None:
                ended = execute(chosen.let_go, other)
                outcome = replace(outcome, success=ended.success, stuck=ended.stuck)
            else:
                said = "" if other.holding else f" {grip.object} slipped out of the other hand."
                outcome = replace(outcome, text=f"{outcome.text}{said}")
                self.queued = ()
                retreat(list(grip.segments[:-1]), other)
        self.grip = None
        self._home(other, solids)
        return outcome

    def _release_watch(self, chosen: NextStep, watch: Watch) -> Watch:
        """Make a watch that has a fixture let go of the object as soon as the hand has closed on it."""

        def look_on(moment: str, tool: str) -> None:
            watch(moment, tool)
            if moment == TAKEN and self._fixture is not None:
                self._fixture.release(chosen.transfer.object)

        return look_on

    def _beside(self, robot: Driver) -> Driver | None:
        """The other arm."""
        return self.first if robot is self.second else self.second

    def _holds(self, chosen: NextStep) -> bool:
        """Whether a step is about what is held: the arm that holds it takes it away."""
        return self.grip is not None and self.grip.object == chosen.transfer.object

    def _home(self, robot: Driver, solids: Solids) -> None:
        go_home(robot, {**solids, **self.obstacles(robot)}, self._seed)


def _gave_way(robot: Driver, grip: Transfer) -> float:
    """How far [m] a link of an arm that holds is from where the plan has it."""
    there, here = robot.arm.forward(np.stack([grip.q_end, robot.q_target]))[:, :, :3, 3]
    return float(np.linalg.norm(there - here, axis=1).max())


def _station(robot: Driver) -> Station:
    return Station(robot.arm, robot.pose_base_to_world, robot.q_target)
