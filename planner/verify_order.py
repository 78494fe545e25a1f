"""Dependencies checked by simulation: every object is taken away in rebuilt worlds, within a budget."""

import multiprocessing
import os
import time
from collections.abc import Mapping, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from dataclasses import dataclass

import numpy as np

from topple.planner.dependency import Dependency, DependencyGraph
from topple.planner.rebuild import Rebuilt, rebuild
from topple.planner.whatif import FRICTIONS, Outcome, Trial, try_out
from topple.topology.statics import Statics

BUDGET = 20.0
"""Seconds that checking a pile of eight may take on two cores."""

TRUSTED = 0.6
"""An object that sagged by more than this share of a move (1 cm or 10 degrees) while its rebuilt body came to
rest was rebuilt wrongly: what simulation says about it is not believed against what statics says."""


@dataclass(frozen=True, eq=False)
class Votes:
    """What the simulations said.

    Attributes:
        moved: (first, then) -> share of trials in which taking `then` moved `first`.
        sagged: name -> largest sag, as a share of a move.
        trials: Trials finished, each of one friction and a part of the objects.
        complete: False where the budget ran out before all trials were done.
    """

    moved: Mapping[tuple[str, str], float]
    sagged: Mapping[str, float]
    trials: int
    complete: bool

    def trusts(self, first: str, then: str) -> bool:
        """Whether both bodies stood still on their own in simulation."""
        return all(self.sagged.get(name, np.inf) < TRUSTED for name in (first, then))


def ask(statics: Statics, seed: int = 0, budget: float | None = None, workers: int | None = None) -> Votes:
    """Take every object away in simulation, once per friction.

    Args:
        statics: The scene at rest.
        seed: Seed of the simulations.
        budget: Seconds they may take, `BUDGET` where not given.
        workers: Processes, one per core where not given.

    Returns:
        The votes; the same for the same seed unless the budget ran out.
    """
    deadline = time.monotonic() + (BUDGET if budget is None else max(budget, 0.0))
    rebuilt = rebuild(statics)
    names = list(rebuilt.bodies)
    workers = max(1, min(workers or os.cpu_count() or 1, 8))
    tasks = [
        (Trial(between, table, 0.0, seed), names[part::workers])
        for between, table in FRICTIONS
        for part in range(workers)
        if names[part::workers]
    ]
    outcomes = _run(rebuilt, tasks, workers, deadline)
    return _count(outcomes, len(outcomes) == len(tasks))


def _run(
    rebuilt: Rebuilt, tasks: Sequence[tuple[Trial, list[str]]], workers: int, deadline: float
) -> list[Outcome]:
    """Outcomes in the order of the tasks, those that were done in time."""
    pool = ProcessPoolExecutor(workers, mp_context=multiprocessing.get_context("spawn"))
    try:
        futures: list[Future[Outcome]] = [pool.submit(try_out, rebuilt, *task) for task in tasks]
        waiting = set(futures)
        while waiting and time.monotonic() < deadline:
            _, waiting = wait(waiting, timeout=deadline - time.monotonic(), return_when=FIRST_COMPLETED)
        return [future.result() for future in futures if future.done()]
    finally:
        processes = list(pool._processes.values())  # pyright: ignore[reportPrivateUsage]
        pool.shutdown(wait=False, cancel_futures=True)
        if time.monotonic() >= deadline:
            for process in processes:  # a simulation cannot be asked to stop
                process.terminate()
        for process in processes:
            process.join()


def _count(outcomes: Sequence[Outcome], complete: bool) -> Votes:
    """Votes of all outcomes."""
    seen: dict[tuple[str, str], list[bool]] = {}
    sagged: dict[str, float] = {}
    for outcome in outcomes:
        for name, move in outcome.sagged.items():
            share = max(move.distance / 0.01, float(np.degrees(move.angle)) / 10.0)
            sagged[name] = max(sagged.get(name, 0.0), share)
        for then, moves in outcome.moves.items():
            for first, move in moves.items():
                seen.setdefault((first, then), []).append(move.beyond(0.01, 10))
    return Votes({pair: float(np.mean(v)) for pair, v in seen.items()}, sagged, len(outcomes), complete)


def confirmed(graph: DependencyGraph, votes: Votes) -> DependencyGraph:
    """The graph after the votes.

    Args:
        graph: Dependencies by reasoning, with every edge, not reduced.
        votes: What simulation said.

    Returns:
        Pairs whose bodies stood still in simulation have the edges simulation found, with the reasons
        statics gave where it found them too; all other pairs keep the edges of statics.
    """
    kept: list[Dependency] = []
    for edge in graph.dependencies:
        share = votes.moved.get((edge.first, edge.then))
        if share is None or not votes.trusts(edge.first, edge.then):
            kept.append(edge)
        elif share >= 0.5:
            confidence = (edge.confidence + share) / 2
            kept.append(Dependency(edge.first, edge.then, edge.reason, confidence))
    known = {(edge.first, edge.then) for edge in graph.dependencies}
    for (first, then), share in votes.moved.items():
        if share >= 0.5 and (first, then) not in known and votes.trusts(first, then):
            kept.append(Dependency(first, then, "blocking", 0.5 + share / 4))
    return DependencyGraph.of(graph.names, kept)
