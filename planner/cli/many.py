"""Many scenes on a command line: on all cores, or the workers of a dask cluster."""

import argparse
import os
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from dataclasses import dataclass
from functools import partial
from typing import Any, TypeVar

from topple.planner.cli.console import complain
from topple.planner.cli.main import WRONG_USE
from topple.planner.cli.options import scene_paths
from topple.planner.cli.progress import Progress
from topple.planner.workers import Lost, mapped, worker_pool
from topple.topology.errors import InvalidInput, NotInstalled

Answer = TypeVar("Answer")

SCENES_A_WORKER = 3
"""Scenes from which another process pays: it takes half a second to start, a scene as long or longer."""


def for_each_scene(
    args: argparse.Namespace,
    work: Callable[[str], Answer],
    show: Callable[[str, Answer], int],
    progress: Progress,
    processes: bool = True,
) -> int:
    """Do the same to every scene, on all cores where there are many.

    One that fails keeps none of the others from its turn, and the answers come in the order given.

    Args:
        args: The parsed arguments.
        work: Takes a path, returns the answer; it and its answer can go to another process.
        show: Takes path and answer, prints it, returns the exit code.
        progress: Where to say what is going on.
        processes: False where the work takes all cores by itself.

    Returns:
        The greatest exit code of all.
    """
    paths = scene_paths(args)
    workers = min(os.cpu_count() or 1, len(paths) // SCENES_A_WORKER) if processes else 1
    workers = workers if args.jobs is None else min(args.jobs, len(paths))
    codes = [0]
    with ExitStack() as stack:
        answers: Iterator[Answer | _Refused | Lost[str]] = map(partial(_attempt, work), paths)
        if args.cluster is not None:
            client = stack.enter_context(_cluster(args.cluster))
            count = max(1, len(client.scheduler_info()["workers"]))
            answers = mapped(partial(_attempt, work), paths, client.get_executor, count)
        elif workers > 1:
            answers = mapped(partial(_attempt, work), paths, partial(worker_pool, workers), workers)
        for number, path in enumerate(paths, 1):
            progress(f"{path} ({number} of {len(paths)})" if len(paths) > 1 else path)
            answer = next(answers)
            progress.clear()
            if isinstance(answer, Lost):
                complain(
                    f"{path}: the process that worked on it was lost twice, for want of memory or killed"
                )
                codes.append(WRONG_USE)
            elif isinstance(answer, _Refused):
                complain(answer.why if answer.why.startswith(path) else f"{path}: {answer.why}")
                codes.append(WRONG_USE)
            else:
                codes.append(show(path, answer))
    return max(codes)


def _cluster(address: str) -> Any:
    """A client of a dask scheduler; while it is open its workers take tasks.

    Raises:
        NotInstalled: There is no dask.
        InvalidInput: Nobody answers at that address.
    """
    try:
        from distributed import Client
    except ImportError as error:
        raise NotInstalled("--cluster needs dask", "dask") from error
    try:
        return Client(address, timeout=10)
    except (OSError, ValueError) as error:
        raise InvalidInput(
            f"no dask scheduler answers at {address}: give the address it printed as it started, "
            "such as tcp://host:8786"
        ) from error


@dataclass(frozen=True)
class _Refused:
    """Why a scene has no answer."""

    why: str


def _attempt(work: Callable[[str], Answer], path: str) -> "Answer | _Refused":
    try:
        return work(path)
    except InvalidInput as error:
        return _Refused(str(error))
