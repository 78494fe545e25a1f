"""The next step, prepared by another process while the arm acts, for the scene as it should be by then.

OMPL and PyBullet do not let other threads of their process think meanwhile.
"""

import logging
import os
import pickle
from collections.abc import Callable
from concurrent.futures import Future
from contextlib import suppress
from dataclasses import dataclass, replace
from types import TracebackType
from typing import Any

from topple.planner.decide.goal import Goal
from topple.planner.planning.follow import next_step
from topple.planner.planning.step import Context, NextStep, Task
from topple.planner.transfer.prediction import after
from topple.planner.transfer.recertify import recertify
from topple.planner.transfer.transfer import Transfer
from topple.topology.base.errors import ToppleError
from topple.topology.base.workers import WorkerPool
from topple.topology.bodies.solids import Solids
from topple.topology.scene.scene import Scene
from topple.topology.situation.situation import Situation

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
    """A step that was chosen before the look that it is done after.

    Attributes:
        step: The step, with proofs on what is seen.
        task: The task, with what it learned while it chose.
        solids: The bodies that are seen.
    """

    step: NextStep
    task: Task
    solids: Solids


class Preparer:
    """A process that prepares one step after the other, for as long as this is entered.

    Where it is lost, or cannot be started or asked, nothing is prepared: what would have been is chosen after
    the look as ever. What it answers does not depend on how long that takes.

    Args:
        on: Whether to prepare anything; nothing is where there is no second core.
    """

    def __init__(self, on: bool) -> None:
        self._pool = WorkerPool(1) if on and cores() > 1 else None
        self._asked: list[Future[Any]] = []

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

    @property
    def on(self) -> bool:
        """Whether anything is prepared."""
        return self._pool is not None

    def begin(self, question: Question) -> None:
        """Have the step chosen that follows the one which the arm is about to do."""
        self.drop()
        self._ask(_choose, question)

    def prove(self, scene: Scene) -> None:
        """Have what is being chosen proven on what is seen by now."""
        if self._asked:  # bodies are made of clouds alone, and pictures take long to send
            bodies = Scene(scene.clouds, scene.fixed, scene.up, scene.viewpoints, matter=scene.matter)
            self._ask(_prove, bodies)

    def drop(self) -> None:
        """Wait for no answer: what was asked about did not come about."""
        for asked in self._asked:
            asked.cancel()
        self._asked = []

    def answer(self) -> Prepared | None:
        """Wait for the step that is chosen and proven; None where there is none."""
        asked, self._asked = self._asked, []
        try:
            return asked[-1].result() if len(asked) > 1 else None
        except Exception as error:  # whatever it failed of, the one who chooses anew will say
            log.info("nothing was prepared: %s", error)
            return None

    def _ask(self, work: Callable[[bytes], object], about: object) -> None:
        if self._pool is None:
            return
        try:
            self._asked.append(self._pool.submit(work, pickle.dumps(about, pickle.HIGHEST_PROTOCOL)))
        except Exception as error:  # a task or an orderer of the caller's own may refuse in any way
            log.info("nothing is prepared: what is asked cannot go to another process: %s", error)


def cores() -> int:
    """Cores that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


# -- in the other process


_chosen: tuple[Question, NextStep] | None = None  # kept from one task to the next: only its proof goes back


def _ready() -> None:
    """Importing this has loaded what a step is chosen with."""


def _choose(question: bytes) -> None:
    """Choose the step that follows, where there is one."""
    global _chosen
    _chosen = None
    asked: Question = pickle.loads(question)
    expected = after(asked.situation, asked.transfer)
    with suppress(ToppleError):
        step = next_step(asked.task, expected, asked.goal, asked.context)
        _chosen = None if step is None else (asked, step)


def _prove(seen: bytes) -> Prepared | None:
    """Prove it on a scene; None where there is none, or no proof."""
    if _chosen is None:
        return None
    (asked, step), situation = _chosen, Situation(pickle.loads(seen))
    station = asked.context.station
    found = recertify(step.transfer, situation, station)
    return None if found is None else Prepared(replace(step, transfer=found), asked.task, situation.solids)
