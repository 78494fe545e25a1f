"""Which step a run does next: chosen from what is seen and remembered, or prepared while the arm acted."""

from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace

import numpy as np

from topple.planner.decide.goal import Goal
from topple.planner.decide.turn import Ahead
from topple.planner.errors import NoSafePlan
from topple.planner.execution.execute import Outcome
from topple.planner.execution.look import Look
from topple.planner.execution.memory import Memory
from topple.planner.execution.prepare import Preparer, Question
from topple.planner.execution.tolerances import AT_HOME, STUCK
from topple.planner.execution.two_arms import TwoArms
from topple.planner.motion.collision import Checker
from topple.planner.planning.follow import next_step
from topple.planner.planning.step import Context, NextStep, Task
from topple.topology.base.arguments import checked_arguments


@checked_arguments
@dataclass(frozen=True)
class RunLimits:
    """What ends a run that gets nowhere.

    Attributes:
        attempts: Tries at one object before the run gives up on it, until another one was taken away.
        actions: Actions in all for each object of the scene.
        settle: Seconds of simulated time to wait after an action before looking.

    Examples:
        >>> RunLimits(attempts=2).attempts
        2
    """

    attempts: int = 3
    actions: int = 3
    settle: float = 1.0


class StepSelector:
    """Selects the steps of a run one by one, and remembers what became of them.

    Args:
        task: What is to be reached.
        arms: The arms.
        asked: What the steps are chosen in, but for how the arms stand and what is remembered.
        attempts: Tries at one object before it is given up, until another one was taken away.

    Attributes:
        task: What is to be reached, with what was learned while a step was prepared.
        preparer: What prepares the next step while the arm acts; by default nothing does.
        prepared: The step selected last where it was prepared, else None.
    """

    def __init__(self, task: Task, arms: TwoArms, asked: Context, attempts: int) -> None:
        self.task, self._arms, self._asked, self._attempts = task, arms, asked, attempts
        self.preparer = Preparer(False)
        self.prepared: NextStep | None = None
        self._memory = Memory()
        self._ahead: Ahead | None = None

    def unmet(self, look: Look, goal: Goal) -> tuple[str, ...]:
        """Say what is still missing for the goal."""
        return self.task.chooser(look.situation, goal, self._context(self._memory)).unmet()

    def check_start(self, look: Look, goal: Goal) -> None:
        """See that the arm stands clear, where there is something to do.

        Raises:
            NoSafePlan: It stands in something.
        """
        robot = self._arms.first
        checker = Checker(
            robot.arm, robot.pose_base_to_world, look.situation.solids, tool_state=robot.tool_state
        )
        deep = [contact for contact in checker.contacts(robot.q_target) if contact.distance < -STUCK]
        if deep and self.unmet(look, goal):
            where = f"{deep[0].a} is {-1e3 * deep[0].distance:.0f} mm inside {deep[0].b}"
            words = f"the arm starts in collision: {where}"
            raise NoSafePlan(words, (words,))

    def choose(self, look: Look, goal: Goal) -> NextStep | None:
        """The next step, chosen now; None where nothing is left to do.

        What a watched lift moved goes first where that can be; where it cannot, that lift is tried again.

        Raises:
            NoSafePlan: Something is left to do, and nothing that may be done now can be.
        """
        try:
            return next_step(self.task, look.situation, goal, self._context(self._memory))
        except NoSafePlan:
            if not self._memory.beliefs.measured:
                raise
        context = self._context(self._memory)
        context = replace(context, beliefs=replace(self._memory.beliefs, measured=frozenset()))
        return next_step(self.task, look.situation, goal, context)

    def moved_with(self, name: str) -> set[str]:
        """Objects that a lift of an object was seen to move, both being as they were."""
        return {first for first, then in self._memory.beliefs.measured if then == name}

    def next(self, look: Look, goal: Goal) -> tuple[Look, NextStep | None]:
        """The step that was decided with a hold or prepared, where that can be done; else one chosen now.

        Args:
            look: What is seen.
            goal: What shall hold in the end.

        Returns:
            The look, with what is known of it by now, and the step; None where nothing is left to do.

        Raises:
            NoSafePlan: As for `choose`.
        """
        if self._arms.queued:
            return look, self._arms.queued[0]
        robot = self._arms.first
        away = np.abs(robot.q_target - robot.arm.home).max()
        prepared, self.prepared = self.preparer.answer(), None
        if prepared is None or away > AT_HOME:
            return look, self.choose(look, goal)
        self.task, self.prepared = prepared.task, prepared.step
        known = replace(look.situation, known_relations=look.relations, known_solids=prepared.solids)
        return replace(look, situation=known), prepared.step

    def prepare(self, look: Look, chosen: NextStep, goal: Goal) -> None:
        """Have the step prepared that follows one which goes as it should, the arm at home again.

        Args:
            look: What is seen before it.
            chosen: The step that the arm is about to do.
            goal: What shall hold in the end.
        """
        context = self._context(self._memory.after_action(chosen, True).after_look(chosen, True))
        context = replace(context, station=replace(context.station, q=np.asarray(self._arms.first.arm.home)))
        self.preparer.begin(Question(look.situation, chosen.transfer, self.task, goal, context))

    def changes(self, chosen: NextStep) -> list[str]:
        """How a step differs from what was to come by the look before."""
        changed = None if self._ahead is None else self._ahead.change_to(chosen.order)
        return [] if changed is None else [f"The look before it changed the order: {changed}."]

    def record_action(self, chosen: NextStep, outcome: Outcome) -> int:
        """Remember what became of a step, before the look that follows.

        Args:
            chosen: The step.
            outcome: What became of it.

        Returns:
            How many tries at the object there were by now.
        """
        name = chosen.transfer.object
        attempts = self._memory.attempts[name] + 1
        grasp_holds = outcome.stuck or bool(outcome.moved)
        self._memory = self._memory.after_action(chosen, outcome.success, grasp_holds)
        self._ahead = Ahead.of(chosen.order, outcome.success)
        return attempts

    def tries_left(self, name: str) -> int:
        """How many more tries at an object may fail."""
        return self._attempts - self._memory.failures(name)

    def record_look(
        self,
        chosen: NextStep,
        outcome: Outcome,
        surprises: Collection[str],
        changed: Collection[str],
        different: Sequence[str],
    ) -> None:
        """Remember what the look after a step showed.

        Args:
            chosen: The step.
            outcome: What became of it.
            surprises: Objects that were not seen where they should be.
            changed: Those of them that were seen elsewhere.
            different: Relations that are not as predicted, in words: what is being prepared was not for this.
        """
        self._memory = self._memory.after_look(chosen, outcome.success, surprises, changed, outcome.moved)
        if different:
            self.preparer.drop()

    def _context(self, memory: Memory) -> Context:
        """Make the context in which a step is chosen, with the arms as they stand."""
        (station, second), away = self._arms.stations, self._asked.away
        bodies = {**self._arms.obstacles(self._arms.first), **({} if away is None else away.bodies)}
        asked = replace(
            self._asked, station=station, second=second, obstacles=bodies, clamped=self._arms.clamped
        )
        return memory.context(asked, self._attempts)
