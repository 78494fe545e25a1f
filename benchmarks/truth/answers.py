"""Answers of versions of topple, asked in processes of their own, and kept: nothing is asked twice."""

import hashlib
import json
import os
import subprocess
import sys
from collections.abc import Iterator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor, as_completed
from dataclasses import dataclass
from pathlib import Path
from queue import SimpleQueue
from typing import Any

from topple.benchmarks.row import Progress
from topple.benchmarks.truth import asked
from topple.benchmarks.versions import Version
from topple.planner.formats.json_lines import JsonLines
from topple.topology.base.errors import InvalidInput, ToppleError

PROCESSES = 2


@dataclass(frozen=True)
class Question:
    """A scene as it is given to a version.

    Attributes:
        name: Of the scene and the view, for a reader.
        path: File with the arrays, or the scene's own.
        targets: Names to free one by one.
        variant: Jitter, see `asked.jittered`.
        load: Whether the file is a scene's own, that the version reads.
        fixed: Names that never move, where the file does not say.
    """

    name: str
    path: Path
    targets: tuple[str, ...] = ()
    variant: str = ""
    load: bool = False
    fixed: tuple[str, ...] = ()

    def task(self) -> dict[str, Any]:
        """What `asked.py` is told; a turn takes another seed along."""
        seed = round(float(self.variant.partition(" ")[2] or 0))
        return {
            "arrays": str(self.path.resolve()), "variant": self.variant, "targets": list(self.targets),
            "seed": seed, "load": self.load, "fixed": list(self.fixed),
        }  # fmt: skip

    def key(self) -> str:
        """Digest of everything that an answer hangs on but the version."""
        files = {"arrays": self.path, "asked": Path(asked.__file__)}
        told = self.task() | {
            key: hashlib.sha256(path.read_bytes()).hexdigest() for key, path in files.items()
        }
        return hashlib.sha256(json.dumps(told, sort_keys=True).encode()).hexdigest()[:16]


def answers(
    version: Version, questions: Sequence[Question], folder: Path, progress: Progress
) -> dict[Question, Mapping[str, Any]]:
    """Ask a version what it was not asked before.

    Args:
        version: The version.
        questions: What is asked.
        folder: Where answers are kept, a file a version, a line an answer.
        progress: Called as answers come.

    Returns:
        The answer to each question.
    """
    folder.mkdir(parents=True, exist_ok=True)
    keys = {question: question.key() for question in questions}
    with _Kept(folder / f"{version.key}.jsonl") as kept:
        left = [question for question, key in keys.items() if key not in kept.known]
        with _Asked(version, min(PROCESSES, len(left))) as processes:
            for question, found in processes.answers(left):
                kept.add({"key": keys[question], "answer": found})
                progress(f"{version.name}: {len(kept.known)} answers, {question.name} {question.variant}")
        return {question: kept.known[key] for question, key in keys.items()}


class _Kept(JsonLines):
    """Answers of one version."""

    def __init__(self, path: Path) -> None:
        self.known: dict[str, Mapping[str, Any]] = {}
        super().__init__(path, "file of answers", '{"key"')

    def __enter__(self) -> "_Kept":
        return self

    def _take(self, entry: Any) -> None:
        if not isinstance(entry, dict) or entry.keys() != {"key", "answer"}:
            raise InvalidInput('it is no answer, expected {"key": ..., "answer": ...}')
        self.known[entry["key"]] = entry["answer"]

    def add(self, entry: Mapping[str, Any]) -> None:
        super().add(entry)
        self._take(entry)


class _Asked:
    """Processes that answer, to be used with `with`; one that dies costs its own question alone."""

    def __init__(self, version: Version, count: int) -> None:
        self.version, self.started = version, list[subprocess.Popen[str]]()
        self.idle: SimpleQueue[subprocess.Popen[str]] = SimpleQueue()
        for _ in range(count):
            self.idle.put(self._start())

    def __enter__(self) -> "_Asked":
        return self

    def __exit__(self, *_: object) -> None:
        for process in self.started:
            process.kill()
            process.communicate()  # closes its pipes, too

    def answers(self, questions: Sequence[Question]) -> Iterator[tuple[Question, Mapping[str, Any]]]:
        """Every question with its answer, as they come."""
        if questions:
            with ThreadPoolExecutor(len(self.started)) as threads:
                waiting = {threads.submit(self._ask, question): question for question in questions}
                for done in as_completed(waiting):
                    yield waiting[done], done.result()

    def _ask(self, question: Question) -> Mapping[str, Any]:
        process = self.idle.get()
        assert process.stdin is not None and process.stdout is not None
        try:
            process.stdin.write(json.dumps(question.task()) + "\n")
            process.stdin.flush()
            found: Mapping[str, Any] = json.loads(process.stdout.readline())
        except (OSError, ValueError):
            process.kill()
            process = self._start()
            found = {"refused": "the process that was asked is gone", "fault": True}
        self.idle.put(process)
        return found

    def _start(self) -> "subprocess.Popen[str]":
        threads = {name: "1" for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")}
        process = subprocess.Popen(
            [sys.executable, "-P", str(Path(asked.__file__).resolve()), str(self.version.folder)],
            stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True,
            env={**os.environ, **threads, "PYTHONPATH": str(self.version.folder)},
        )  # fmt: skip
        self.started.append(process)
        if process.stdout is None or not process.stdout.readline():
            self.__exit__()
            where = self.version.folder
            raise ToppleError(f"{self.version.name} cannot be asked: its package is not found at {where}")
        return process
