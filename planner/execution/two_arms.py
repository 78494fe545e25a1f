"""Two arms at work, one at a time: the second holds what would not stand while the first takes something."""

from dataclasses import replace

import numpy as np

from topple.planner.execution.execute import Outcome, Watch, execute, retreat, withdraw
from topple.planner.execution.tolerances import AT_HOME
from topple.planner.motion.tolerances import GIVES_WAY
from topple.planner.planning.holding import FIRST, SECOND, standing_by
from topple.planner.planning.step import NextStep, Station
from topple.planner.transfer.transfer import Transfer
from topple.robots.driver import Driver
from topple.topology.bodies.solids import Solids


class TwoArms:
    """An arm that takes, and beside it one that may hold.

    Args:
        first: The arm that takes.
        second: The arm that holds; None where there is none.
        seed: Of the searches for ways home.

    Attributes:
        pending: The steps that were decided with a hold which is going on.
        grip: How the second arm holds something now; None where it does not.
    """

    def __init__(self, first: Driver, second: Driver | None, seed: int) -> None:
        self.first, self.second, self._seed = first, second, seed
        self.pending: tuple[NextStep, ...] = ()
        self.grip: Transfer | None = None

    @property
    def stations(self) -> tuple[Station, Station | None]:
        """How the arms stand."""
        return _station(self.first), None if self.second is None else _station(self.second)

    def acting(self, chosen: NextStep) -> Driver:
        """The arm that does a step."""
        return self.second if chosen.by_second and self.second is not None else self.first

    def besides(self, robot: Driver) -> Solids:
        """The bodies (V, 3) of the other arm [m], by name."""
        if self.second is None:
            return {}
        whose, other = (FIRST, self.first) if robot is self.second else (SECOND, self.second)
        return standing_by(whose, _station(other))

    def carry_out(self, chosen: NextStep, watch: Watch) -> Outcome:
        """Do a step, once the second hand holds what it has to.

        Args:
            chosen: The step.
            watch: What looks on at the hand that takes.
        """
        if chosen.grip is not None and self.second is not None:
            closed = execute(chosen.grip, self.second)
            if not closed.success:
                return replace(closed, text=f"the second arm: {closed.text}")
            self.grip = chosen.grip
            if (off := self._gave_way(chosen.grip)) > GIVES_WAY:
                said = f"the second arm gave way by {1e3 * off:.0f} mm as its hand closed."
                return replace(closed, success=False, text=said)
        if chosen.by_second and np.abs(self.first.q_target - np.asarray(self.first.arm.home)).max() > AT_HOME:
            said = "the first arm found no way home, and the second holds on."
            return Outcome(False, said, np.zeros((0, 3)), stuck=True)
        return execute(chosen.transfer, self.acting(chosen), watch)

    def withdraw(self, chosen: NextStep, outcome: Outcome, solids: Solids) -> Outcome:
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
        self._home(self.acting(chosen), solids)
        self.pending = (chosen.then or self.pending[1:]) if outcome.success else ()
        second, grip = self.second, self.grip
        if second is None or chosen.by_second:
            self.grip = None
            return outcome
        if grip is not None:
            if outcome.success and chosen.let_go is None and second.holding:
                return outcome
            if outcome.success and chosen.let_go is not None:
                ended = execute(chosen.let_go, second)
                outcome = replace(outcome, success=ended.success, stuck=ended.stuck)
            else:
                said = "" if second.holding else f" {grip.object} slipped out of the second hand."
                outcome = replace(outcome, text=f"{outcome.text}{said}")
                self.pending = ()
                retreat(list(grip.segments[:-1]), second)
        self.grip = None
        self._home(second, solids)
        return outcome

    def _home(self, robot: Driver, solids: Solids) -> None:
        withdraw(robot, {**solids, **self.besides(robot)}, self._seed)

    def _gave_way(self, grip: Transfer) -> float:
        """How far [m] a link of the second arm is from where the plan has it."""
        assert self.second is not None
        arm = self.second.arm
        there, here = arm.forward(np.stack([grip.q_end, self.second.q_target]))[:, :, :3, 3]
        return float(np.linalg.norm(there - here, axis=1).max())


def _station(robot: Driver) -> Station:
    return Station(robot.arm, robot.pose_base_to_world, robot.q_target)
