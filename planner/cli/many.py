"""Many scenes on a command line: on all cores, or the workers of a dask cluster."""

import argparse
import os
from collections.abc import Callable, Generator, Iterator, Mapping
from contextlib import contextmanager, nullcontext
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

from topple.planner.cli.console import complain, print_json, print_text
from topple.planner.cli.main import DONE, NO_SAFE_PLAN, WRONG_USE
from topple.planner.cli.options import scene_paths
from topple.planner.cli.progress import Progress
from topple.planner.errors import NoSafePlan
from topple.planner.formats.json_lines import JsonLines
from topple.topology.base.errors import InvalidInput, NotInstalled
from topple.topology.base.workers import Lost, WorkerPool, map_tasks

if TYPE_CHECKING:
    from concurrent.futures import Executor

Answer = TypeVar("Answer")

SCENES_A_WORKER = 3
"""Scenes from which another process pays: it takes half a second to start, a scene as long or longer."""


def for_each_scene(
    args: argparse.Namespace,
    work: Callable[[str], Answer],
    show: Callable[["Kept | None", str, Answer], int],
    code_of: Callable[[Mapping[str, Any]], int] = lambda _: DONE,
    processes: bool = True,
) -> int:
    """Do the same to every scene, on all cores where there are many.

    One that fails keeps none of the others from its turn, and the answers come in the order given.

    Args:
        args: The parsed arguments.
        work: Takes a path, returns the answer; it and its answer can go to another process.
        show: Takes the file of `-o` where it is given, path and answer, prints or keeps it, returns the exit
            code. Scenes whose answers the file has from before are left out.
        code_of: The exit code of an answer that is kept.
        processes: False where the work takes all cores by itself.

    Returns:
        The greatest exit code of all.
    """
    output = getattr(args, "output", None)
    there = nullcontext() if output is None else Kept(Path(output), args, code_of)
    with there as kept, Progress(args.command) as progress:
        return _for_each(args, work, partial(show, kept), progress, processes, kept)


def _for_each(
    args: argparse.Namespace,
    work: Callable[[str], Answer],
    show: Callable[[str, Answer], int],
    progress: Progress,
    processes: bool,
    kept: "Kept | None",
) -> int:
    paths, before = scene_paths(args), {} if kept is None else kept.codes
    left = [path for path in paths if path not in before]
    workers = min(os.cpu_count() or 1, len(left) // SCENES_A_WORKER) if processes else 1
    workers = workers if args.jobs is None else min(args.jobs, len(left))
    codes = [0, *(before[path] for path in paths if path in before)]
    alone = args.cluster is None and workers <= 1
    with nullcontext() if alone else executor_at(args.cluster, workers) as executor:
        attempt = partial(_attempt, work)
        answers: Iterator[Answer | _Refused | Lost[str]] = (
            map(attempt, left) if executor is None else map_tasks(attempt, left, executor)
        )
        for number, path in enumerate(left, len(paths) - len(left) + 1):
            progress(f"{path} ({number} of {len(paths)})" if len(paths) > 1 else path)
            answer = next(answers)
            progress.clear()
            if isinstance(answer, Lost):
                why = "the process that worked on it was lost twice, for want of memory or killed"
                complain(f"{path}: {why}")
                codes.append(WRONG_USE)
            elif isinstance(answer, _Refused):
                complain(answer.why if answer.why.startswith(path) else f"{path}: {answer.why}")
                complain(*(f"{path}: {line}" for line in answer.certificate if line not in answer.why))
                codes.append(answer.code)
            else:
                codes.append(show(path, answer))
    if kept is not None and not args.json:
        print_text(f"{kept.path} has answers to {len(kept.codes)} scenes.")
    return max(codes)


@contextmanager
def executor_at(address: str | None, processes: int) -> "Generator[Executor]":
    """An executor, which ends with the context.

    Args:
        address: Of a dask scheduler, whose workers take the tasks; None for processes of this machine.
        processes: How many of these.

    Yields:
        The executor.

    Raises:
        NotInstalled: There is no dask.
        InvalidInput: Nobody answers at that address.
    """
    if address is None:
        with WorkerPool(processes) as pool:
            yield pool
        return
    try:
        from distributed import Client
    except ImportError as error:
        raise NotInstalled("--cluster needs dask", "dask") from error
    try:
        client = Client(address, timeout=10)
    except (OSError, ValueError) as error:
        raise InvalidInput(
            f"no dask scheduler answers at {address}: give the address it printed as it started, "
            "such as tcp://host:8786"
        ) from error
    with client:
        yield client.get_executor()


class Kept(JsonLines):
    """Answers in a file (`-o`), a line for each scene: the same command leaves out what is there.

    Args:
        path: The file; see `JsonLines`.
        args: The parsed arguments: answers to other ones are refused.
        code_of: The exit code of an answer.

    Attributes:
        codes: Scenes whose answers are there, each with its exit code.
    """

    def __init__(
        self, path: Path, args: argparse.Namespace, code_of: Callable[[Mapping[str, Any]], int]
    ) -> None:
        given = {key: value for key, value in vars(args).items() if key not in _NOT_ASKED}
        self._asked = {key: value for key, value in given.items() if value != args.parser.get_default(key)}
        self._code_of, self.codes = code_of, dict[str, int]()
        super().__init__(path, f"answer of this topple {args.command}", '{"scene": "')

    def __enter__(self) -> "Kept":
        return self

    def _take(self, entry: Any) -> None:
        if not isinstance(entry, dict) or not isinstance(entry.get("scene"), str):
            raise InvalidInput('it is no answer, expected {"scene": ...}')
        if entry.get("asked") != self._asked:
            raise InvalidInput(f"it was asked with {entry.get('asked')}, expected {self._asked}")
        self.codes[entry["scene"]] = self._code_of(entry)

    def add(self, entry: Mapping[str, Any]) -> None:
        """Append the answer to a scene; see `JsonLines.add`."""
        super().add({**entry, "asked": self._asked})
        self.codes[entry["scene"]] = self._code_of(entry)


def store(as_json: bool, kept: Kept | None, path: str, document: Mapping[str, Any]) -> bool:
    """Store the answer to a scene in the file of `-o`, or print it as JSON with `--json`.

    Args:
        as_json: Whether JSON is asked for.
        kept: The file, if there is one.
        path: Of the scene.
        document: The answer.

    Returns:
        Whether that was done; else it is to be shown in words.
    """
    answer = {"scene": path, **document}
    if kept is not None:
        kept.add(answer)
    elif as_json:
        print_json(answer)
    return as_json or kept is not None


_NOT_ASKED = ("parser", "said", "command", "scenes", "output", "jobs", "cluster", "json")
"""Arguments that say where scenes are answered, and how that is shown."""


@dataclass(frozen=True)
class _Refused:
    """Why a scene has no answer."""

    why: str
    code: int = WRONG_USE
    certificate: tuple[str, ...] = ()


def _attempt(work: Callable[[str], Answer], path: str) -> "Answer | _Refused":
    try:
        return work(path)
    except InvalidInput as error:
        return _Refused(str(error))
    except NoSafePlan as error:
        return _Refused(str(error), NO_SAFE_PLAN, error.certificate)
