"""The task to reach a goal in words, or to free what is named."""

from collections.abc import Collection
from dataclasses import dataclass

from topple.planner.decide.goal import Goal, parse_goal
from topple.planner.planning.next_step import StepChooser
from topple.planner.planning.step import Chooser, Context, Task
from topple.topology.base.arrays import FloatArray
from topple.topology.scene.scene import Scene
from topple.topology.situation.situation import Situation


@dataclass(frozen=True)
class GoalTask:
    """A task in words, or as names of what is to be freed: see `topple.planner.decide.goal.parse_goal`."""

    words: str | Collection[str]

    @staticmethod
    def of(goal: str | Collection[str] | Task) -> Task:
        """What somebody wants, as a task."""
        return goal if isinstance(goal, Task) else GoalTask(goal)

    def in_frame(self, _pose: FloatArray, _up: FloatArray, /) -> Task:
        """The same: words hold in any frame."""
        return self

    def goal(self, scene: Scene) -> Goal:
        """The goal, read for a scene."""
        return parse_goal(self.words, scene)

    def chooser(self, situation: Situation, goal: Goal, context: Context) -> Chooser:
        """What chooses the steps."""
        return StepChooser(situation, goal, context)
