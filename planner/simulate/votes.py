"""Dependencies checked by simulation: every object is taken away in rebuilt worlds."""

import multiprocessing
import os
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from multiprocessing.connection import Connection, wait

import numpy as np

from topple.planner.budget import check_budget, seconds_left
from topple.planner.decide.dependency import Dependency, DependencyGraph, Reason
from topple.planner.decide.rates import likelihoods, posterior
from topple.planner.simulate.lift import Move
from topple.planner.simulate.lifts import Stage
from topple.planner.simulate.rebuild import rebuild
from topple.planner.simulate.tolerances import FRICTIONS, NOISE, TRUSTED
from topple.topology.base.workers import serve
from topple.topology.statics.rest import Statics


@dataclass(frozen=True, eq=False)
class Votes:
    """What the simulations said.

    Attributes:
        moved: (first, then) -> for each trial, whether taking `then` moved `first`.
        sagged: name -> largest sag, as a share of a move.
        trials: Lifts simulated.
    """

    moved: Mapping[tuple[str, str], tuple[bool, ...]]
    sagged: Mapping[str, float]
    trials: int

    def steady(self, first: str, then: str) -> bool:
        """Whether both bodies stood still on their own in simulation."""
        return all(self.sagged.get(name, np.inf) < TRUSTED for name in (first, then))


@dataclass(frozen=True, eq=False)
class _Lift:
    """One object taken away in one world."""

    then: str
    sagged: Mapping[str, Move]
    moves: Mapping[str, Move]


def ask(
    statics: Statics,
    graph: DependencyGraph,
    seed: int = 0,
    workers: int | None = None,
) -> Votes:
    """Take every object away in simulation, at every friction.

    Args:
        statics: The scene at rest.
        graph: What reasoning found, of these objects.
        seed: Seed of the simulations.
        workers: Processes, one per core where not given.

    Returns:
        The votes; the same for the same seed and number of workers.

    Raises:
        OutOfBudget: The budget of the call ran out.
    """
    names = graph.names
    jitter = NOISE[0 if statics.sight is None else 1]
    trials = [(rough, jitter if number else 0.0, seed + number) for number, rough in enumerate(FRICTIONS)]
    workers = max(1, min(workers or len(os.sched_getaffinity(0)), len(names)))
    shares = [[(trial, names[k::workers]) for trial in trials] for k in range(workers)]
    return _count(_in_processes([_worker(statics, share) for share in shares]))


_Job = Callable[[Connection], None]
_Trial = tuple[tuple[float, float], float, int]
"""Friction between objects and with the table; [m] of jitter of where each body really is, and its seed."""


def _worker(statics: Statics, share: Sequence[tuple[_Trial, Sequence[str]]]) -> _Job:
    """A process's part of the lifts, each sent when it is done."""

    def work(out: Connection) -> None:
        serve()
        for (rough, jitter, seed), names in share:
            stage = Stage(rebuild(statics, jitter, seed), *rough)
            for name in names:
                out.send(_Lift(name, stage.sagged, stage.without(name)))
            stage.close()
        out.close()

    return work


def _in_processes(jobs: Sequence[_Job]) -> list[_Lift]:
    """Run jobs side by side and collect what they send.

    Processes are forked: they share the scene, start at once, and need no importable main module.

    Raises:
        RuntimeError: A process ended with an error.
        OutOfBudget: The budget of the call ran out; the processes are ended.
    """
    context = multiprocessing.get_context("fork")
    pipes = [context.Pipe(duplex=False) for _ in jobs]
    processes = [
        context.Process(target=job, args=(pipe[1],), daemon=True)
        for job, pipe in zip(jobs, pipes, strict=True)
    ]
    found: dict[int, list[_Lift]] = {number: [] for number in range(len(jobs))}
    reading = {pipe[0]: number for number, pipe in enumerate(pipes)}
    try:
        for process, (_, writing) in zip(processes, pipes, strict=True):
            process.start()
            writing.close()
        while reading:
            check_budget()
            left = seconds_left()
            for ready in wait(list(reading), timeout=left if np.isfinite(left) else None):
                assert isinstance(ready, Connection)
                try:
                    found[reading[ready]].append(ready.recv())
                except EOFError:
                    number = reading.pop(ready)
                    processes[number].join()
                    if processes[number].exitcode != 0:
                        raise RuntimeError(
                            f"a simulation ended with exit code {processes[number].exitcode}"
                        ) from None
    finally:
        for process in processes:
            process.terminate()
        for process in processes:
            process.join()
        for receiving, _ in pipes:
            receiving.close()
    return [lift for lifts in found.values() for lift in lifts]


def _count(lifts: Sequence[_Lift]) -> Votes:
    """Votes of all lifts."""
    moved: dict[tuple[str, str], list[bool]] = {}
    sagged: dict[str, float] = {}
    for lift in lifts:
        for name, move in lift.sagged.items():
            sagged[name] = max(sagged.get(name, 0.0), move.share)
        for first, move in lift.moves.items():
            moved.setdefault((first, lift.then), []).append(move.share > 1.0)
    return Votes({pair: tuple(each) for pair, each in moved.items()}, sagged, len(lifts))


def chances(
    prior: Mapping[tuple[str, str], float], votes: Votes, cameras: int | None
) -> dict[tuple[str, str], float]:
    """Chance of every dependency, from reasoning and simulation together.

    Args:
        prior: (first, then) -> chance by reasoning, of every ordered pair.
        votes: What simulation said.
        cameras: How many cameras saw the scene; None where the clouds show whole surfaces.

    Returns:
        (first, then) -> 0..1, for every ordered pair; from cameras no less than by reasoning.
    """
    found: dict[tuple[str, str], float] = {}
    for pair, chance in prior.items():
        each = votes.moved.get(pair, ())
        table = likelihoods(cameras, votes.steady(*pair))
        found[pair] = posterior(chance, sum(each), len(each), table)
        if cameras is not None:
            # Bodies with guessed sides are completed so that they stand: that one stood is no news.
            found[pair] = max(found[pair], chance)
    return found


def confirm(graph: DependencyGraph, chance: Mapping[tuple[str, str], float], votes: Votes) -> DependencyGraph:
    """The graph after simulation.

    Args:
        graph: Dependencies by reasoning, with every edge, not reduced.
        chance: (first, then) -> chance that it holds, of every pair.
        votes: What simulation said.

    Returns:
        The edges that more likely hold than not, and those that reasoning found and simulation does not speak
        against, with the reasons statics gave. New ones are between bodies that stood still by themselves.
    """
    kept: list[Dependency] = []
    for (first, then), value in chance.items():
        known = graph.between(first, then)
        # A body that was rebuilt so wrongly that it sags by itself moves at any touch: no news.
        if known is None and not votes.steady(first, then):
            continue
        if value >= 0.5 or (known is not None and value >= known.confidence):
            edge = Dependency(first, then, Reason.BLOCKING, value) if known is None else known
            kept.append(replace(edge, confidence=value))
    return DependencyGraph.of(graph.names, kept)
