"""Turning one arrangement into another as a task for an arm, of a plan or of a run."""

from abc import ABC, abstractmethod
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from topple.planner.decide.goal import Goal
from topple.planner.planning.step import Chooser, Context, Task
from topple.planner.rearranging.arrangement import Arrangement
from topple.planner.rearranging.chooser import MoveChooser
from topple.planner.rearranging.problem import Act, Pair
from topple.topology.base.arguments import checked_arguments
from topple.topology.base.arrays import FloatArray
from topple.topology.io.load import AnyScene, as_scene
from topple.topology.scene.scene import Scene
from topple.topology.situation.situation import Situation


@dataclass
class LearnedPrecedences:
    """What an arm was found to need beyond what lies on what, each with how many steps were done by then."""

    pairs: dict[Pair, int] = field(default_factory=dict[Pair, int])

    def now(self, done: Sequence[tuple[str, str]]) -> frozenset[Pair]:
        """Those that still hold: of the places that things had at the start, while they are there.

        Args:
            done: Steps done by now, as (object, action).
        """
        return frozenset(
            pair for pair, count in self.pairs.items() if not _left(pair, {name for name, _ in done[count:]})
        )


def _left(pair: Pair, handled: Collection[str]) -> bool:
    """Whether a pair is about where something was that has been moved since."""
    return any(act is Act.TAKE and name in handled for act, name in pair)


@checked_arguments
class ArrangementTask:
    """The task to make things lie as in a finished arrangement, with the fewest moves that the arm can make.

    Args:
        arrangement: How things shall lie.

    Examples:
        >>> ArrangementTask(Arrangement(scene)).goal(scene).text
        'book on table, cup on book'
    """

    def __init__(self, arrangement: Arrangement) -> None:
        self.arrangement, self.learned = arrangement, LearnedPrecedences()

    def in_frame(self, pose: FloatArray, up: FloatArray, /) -> Task:
        """The same in another frame: pose (4, 4) leads there, up (3,) is against gravity there."""
        return ArrangementTask(self.arrangement.in_frame(pose, up))

    def goal(self, scene: Scene) -> Goal:
        """State the goal: what shall hold in the end.

        Args:
            scene: What is seen at the start.

        Raises:
            InvalidInput: It has other things than the arrangement.
        """
        self.learned = LearnedPrecedences()  # nothing of another plan or run
        return self.arrangement.goal(scene)

    def chooser(self, situation: Situation, goal: Goal, context: Context) -> Chooser:
        """Make the chooser of the next move; see `topple.planner.planning.step.Task`."""
        done = context.done
        return MoveChooser(
            situation, goal, context, self.arrangement,
            learned=self.learned.now(done), learn=lambda pair: self.learned.pairs.setdefault(pair, len(done)),
        )  # fmt: skip


class _LazyTask(ABC):
    """A task that is worked out for the scene whose goal it is asked for."""

    def __init__(self) -> None:
        self._made: ArrangementTask | None = None

    @abstractmethod
    def arrangement(self, scene: Scene) -> Arrangement:
        """How things shall lie, of which a scene says how they do."""

    def in_frame(self, pose: FloatArray, up: FloatArray, /) -> Task:
        """The same in another frame, once it was worked out for a scene in this one."""
        return self if self._made is None else self._made.in_frame(pose, up)

    def goal(self, scene: Scene) -> Goal:
        """State the goal: what shall hold in the end.

        Args:
            scene: What is seen at the start.

        Raises:
            InvalidInput: It is no goal for these things.
            NoSafePlan: There is no room for it.
        """
        self._made = None  # that of another plan or run
        return self._worked_out(scene).goal(scene)

    def chooser(self, situation: Situation, goal: Goal, context: Context) -> Chooser:
        """Make the chooser of the next move; see `topple.planner.planning.step.Task`."""
        return self._worked_out(situation.scene).chooser(situation, goal, context)

    def _worked_out(self, scene: Scene) -> ArrangementTask:
        if self._made is None:
            self._made = ArrangementTask(self.arrangement(scene))
        return self._made


@checked_arguments
class DescribedTask(_LazyTask):
    """The task to make things lie as words say: see `topple.planner.rearranging.words.arrange_by_words`.

    Args:
        words: As "plate on table, bowl on plate, spoon left of plate".

    Examples:
        >>> DescribedTask("cup on table").goal(scene).text
        'book on table, cup on table'
    """

    def __init__(self, words: str) -> None:
        super().__init__()
        self.words = words

    def arrangement(self, scene: Scene) -> Arrangement:
        """The words worked out."""
        from topple.planner.rearranging.words import arrange_by_words  # lets things go in simulation

        return arrange_by_words(self.words, Situation.of(scene))


@checked_arguments
class RelatedTask(_LazyTask):
    """Give things the relations of a document: see `topple.planner.rearranging.related.arrange_by_relations`.

    Args:
        document: What `topple relate --json` prints, of this scene or another one of the same things.

    Examples:
        >>> RelatedTask(relate(scene).to_json()).goal(scene).text
        'book on table, cup on book'
    """

    def __init__(self, document: Mapping[str, Any]) -> None:
        super().__init__()
        self.document = document

    def arrangement(self, scene: Scene) -> Arrangement:
        """The relations worked out."""
        from topple.planner.rearranging.related import arrange_by_relations  # lets things go in simulation

        return arrange_by_relations(self.document, Situation.of(scene))


@checked_arguments
class SameShapesTask(_LazyTask):
    """The task to make things lie as in a scene of things of their shapes, whatever these are called.

    Args:
        goal: How things of these shapes shall lie.

    Examples:
        >>> SameShapesTask(scene).goal(scene).text
        'book on table, cup on book'
    """

    def __init__(self, goal: AnyScene) -> None:
        super().__init__()
        self._goal = as_scene(goal)

    def arrangement(self, scene: Scene) -> Arrangement:
        """The scene, its things named as those they are taken to be."""
        return Arrangement.alike(scene, self._goal)
