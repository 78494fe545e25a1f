"""Give readers what is not sound, and count what they make of it."""

import logging
import os
import signal
import sys
import tempfile
import threading
import time
import warnings
from collections.abc import Generator
from contextlib import contextmanager, nullcontext
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from types import FrameType

import numpy as np

from topple.benchmarks.fuzz.mutate import mutated
from topple.benchmarks.fuzz.reader import KINDS, SECRET, Parts, Reader, misplaced
from topple.topology.base.errors import ToppleError

SECONDS = 5.0
"""What reading a small file may take."""
WAITED = 6.0
"""How many times as long it may take by the clock: others compute, too, and what waits does not compute."""
MEGABYTES = 1000.0
"""What it may add to what the process holds at most."""
EXAMPLES = 3
MISPLACED = 20
"""Every so manieth input has something else where a file is expected."""


@dataclass(frozen=True)
class ReaderCount:
    """What came of one reader's inputs.

    Attributes:
        reader: Its name.
        inputs: How many it was given.
        clean: How many it read rightly, or refused with an error of topple in one line.
        broken: The others: another exception, a warning, too long, too much, or an answer that cannot be.
        examples: What happened to the first of these, with the number that makes the input again.
    """

    reader: str
    inputs: int
    clean: int
    broken: int
    examples: tuple[str, ...] = ()


def fuzz(reader: Reader, inputs: int, seed: int = 0) -> ReaderCount:
    """Fuzz one reader.

    Args:
        reader: The reader.
        inputs: How many changed files it is given.
        seed: Seed of the changes; input `i` is the same whatever their number.

    Returns:
        What came of it.
    """
    broken: list[str] = []
    sound = reader.parts()
    with tempfile.TemporaryDirectory(prefix="topple-fuzz-") as folder:
        place = Path(folder)
        for number in range(inputs):
            turn, due = divmod(number, MISPLACED)
            kind = list(KINDS)[turn % len(KINDS)] if due == MISPLACED - 1 else None
            complaint = tried(reader, changed(reader, sound, number, seed), place, kind)
            if complaint is not None:
                broken.append(f"input {number} of seed {seed}: {complaint}")
    return ReaderCount(reader.name, inputs, inputs - len(broken), len(broken), tuple(broken[:EXAMPLES]))


def changed(reader: Reader, sound: Parts, number: int, seed: int) -> Parts:
    """One input: one of its parts changed.

    Args:
        reader: The reader.
        sound: Its sound input.
        number: Which input.
        seed: Seed of the changes.

    Returns:
        The parts, an archive as one part under the archive's name.
    """
    rng = np.random.default_rng([seed, number])
    names = list(sound)
    name = names[int(rng.integers(len(names)))]
    return {**sound, name: mutated(sound[name], rng)}


def tried(reader: Reader, parts: Parts, folder: Path, kind: str | None = None) -> str | None:
    """Have a reader read an input.

    Args:
        reader: The reader.
        parts: The input.
        folder: Where it is written to.
        kind: Of `KINDS`, what stands in the place of a file of it; its answer is not looked at then.

    Returns:
        What is wrong with what came of it, None where nothing is.
    """
    path = reader.write(parts, folder)
    place = path if reader.path else path / sorted(parts)[len(str(parts)) % len(parts)]
    held, begun = _peak(anew=True), time.process_time()
    said: str | None = None
    lines: list[str] = []
    try:
        with (
            nullcontext() if kind is None else misplaced(kind, place),
            _interrupted_after(2 * SECONDS), warnings.catch_warnings(), _logged(lines), _watched(lines),
        ):  # fmt: skip
            warnings.simplefilter("error")
            answer = reader.read(path)
            said = reader.wrong(answer, path) if kind is None else None
    except ToppleError as error:
        said = None if "\n" not in str(error) and str(error).strip() else f"no line: {str(error)!r:.80}"
    except (Exception, _Endless) as error:
        said = f"{type(error).__name__}: {' '.join(str(error).split()):.160}"
    if said is None and lines and not (reader.path and kind == "link"):  # which whoever names it may mean
        said = f"logged {lines[0]!r:.160}"
    if said is None and (spent := time.process_time() - begun) > SECONDS:
        said = f"took {spent:.1f} s"
    if said is None and (grown := _peak() - held) > MEGABYTES:
        said = f"took {grown:.0f} MB"
    return said


class _Lines(logging.Handler):
    """What would be printed beside the one line of a refusal."""

    def __init__(self, lines: list[str]) -> None:
        super().__init__(logging.WARNING)
        self._lines = lines

    def emit(self, record: logging.LogRecord) -> None:
        """Take a record down."""
        self._lines.append(record.getMessage())


@contextmanager
def _logged(lines: list[str]) -> Generator[None, None, None]:
    """Take down warnings and errors that are logged, by whatever library."""
    handler, root = _Lines(lines), logging.getLogger()
    root.addHandler(handler)
    try:
        yield
    finally:
        root.removeHandler(handler)


_watching: list[list[str]] = []


@cache
def _install() -> None:
    """Have Python tell of programs that are started, and of files outside that are opened; it has no undo."""

    def tell(event: str, args: tuple[object, ...]) -> None:
        if _watching and event in ("subprocess.Popen", "os.posix_spawn", "os.exec", "os.system"):
            _watching[-1].append(f"started {args[0]}")
        if _watching and event == "open" and isinstance(args[0], str) and SECRET in os.path.realpath(args[0]):
            _watching[-1].append(f"opened {args[0]}")

    sys.addaudithook(tell)


@contextmanager
def _watched(lines: list[str]) -> Generator[None, None, None]:
    """Take down what a reader does that none should."""
    _install()
    _watching.append(lines)
    try:
        yield
    finally:
        _watching.pop()


class _Endless(BaseException):
    """What ends a reader that does not: nothing that it catches."""


@contextmanager
def _interrupted_after(seconds: float) -> Generator[None, None, None]:
    """End what takes longer, where signals reach: in a main thread."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return

    def end(number: int, frame: FrameType | None) -> None:
        raise _Endless(f"not done after {seconds:g} s")

    clocks = {signal.SIGPROF: (signal.ITIMER_PROF, 1.0), signal.SIGALRM: (signal.ITIMER_REAL, WAITED)}
    before = {number: signal.signal(number, end) for number in clocks}
    for clock, factor in clocks.values():
        signal.setitimer(clock, factor * seconds)
    try:
        yield
    finally:
        for number, (clock, _) in clocks.items():
            signal.setitimer(clock, 0.0)
            signal.signal(number, before[number])


def _peak(anew: bool = False) -> float:
    """What the process held at most [MB], from now on where it is to begin anew."""
    if anew:
        Path("/proc/self/clear_refs").write_text("5", encoding="ascii")
    status = Path("/proc/self/status").read_text(encoding="utf-8")
    return float(status.partition("VmHWM:")[2].split()[0]) / 1e3
