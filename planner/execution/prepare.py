"""The next step, prepared by another process while the arm acts: chosen for the scene as it should be by then.

OMPL and PyBullet do not let other threads of their process think meanwhile.
"""

import logging
import os
import pickle
from concurrent.futures import Future
from dataclasses import dataclass
from types import TracebackType

from topple.planner.decide.goal import Goal
from topple.planner.planning.step import Context, NextStep, Task
from topple.planner.transfer.transfer import Transfer, after
from topple.topology.errors import ToppleError
from topple.topology.situation import Situation
from topple.topology.workers import WorkerPool

log = logging.getLogger(__name__)


@dataclass(frozen=True, eq=False)
class Question:
    """What a step is prepared from.

    Attributes:
        situation: What is seen before the arm acts.
        transfer: What the arm is about to do.
        task: What is to be reached.
        goal: The same, read for the scene.
        context: What the step after it will be chosen in, where all goes as it should.
    """

    situation: Situation
    transfer: Transfer
    task: Task
    goal: Goal
    context: Context


@dataclass(frozen=True, eq=False)
class Prepared:
    """A step for a scene that nobody has seen yet.

    Attributes:
        step: The step.
        task: The task, with what it learned while it chose.
    """

    step: NextStep
    task: Task


class Preparer:
    """A process that prepares one step after the other, for as long as this is entered.

    Where it is lost, or cannot be started or asked, nothing is prepared: what would have been is chosen after
    the look as ever. What it answers does not depend on how long that takes.

    Args:
        on: Whether to prepare anything; nothing is where there is no second core.
    """

    def __init__(self, on: bool) -> None:
        self._pool = WorkerPool(1) if on and cores() > 1 else None
        self._asked: Future[Prepared | None] | None = None

    def __enter__(self) -> "Preparer":
        """Start the process: it gets ready while the first look is taken and the first step chosen."""
        if self._pool is not None:
            self._pool.submit(_ready)
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """End the process at once."""
        if self._pool is not None:
            self._pool.kill()

    def begin(self, question: Question) -> None:
        """Have the step prepared that follows the one which the arm is about to do."""
        self.drop()
        if self._pool is None:
            return
        try:
            self._asked = self._pool.submit(_prepared, pickle.dumps(question, pickle.HIGHEST_PROTOCOL))
        except Exception as error:  # a task or an orderer of the caller's own may refuse in any way
            log.info("nothing is prepared: what is asked cannot go to another process: %s", error)

    def drop(self) -> None:
        """Wait for no answer: what was asked about did not come about."""
        if self._asked is not None:
            self._asked.cancel()
            self._asked = None

    def answer(self) -> Prepared | None:
        """Wait for what was asked last; None where there is nothing."""
        asked, self._asked = self._asked, None
        try:
            return None if asked is None else asked.result()
        except Exception as error:  # whatever it failed of, the one who chooses anew will say
            log.info("nothing was prepared: %s", error)
            return None


def cores() -> int:
    """Cores that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def _ready() -> None:
    """Importing this has loaded what a step is chosen with."""


def _prepared(question: bytes) -> Prepared | None:
    """The step that follows, in a process that prepares it; None where there is none."""
    asked: Question = pickle.loads(question)
    expected = after(asked.situation, asked.transfer)
    try:
        step = asked.task.chooser(expected, asked.goal, asked.context).choose()
    except ToppleError as error:
        log.info("nothing is prepared: %s", error)
        return None
    return None if step is None else Prepared(step, asked.task)
