"""One line on stderr about what is going on, how far it is, what is left, once it takes over a second."""

import re
import sys
import threading
import time
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from rich.progress import Progress as Bar

_PATIENCE = 1.0  # [s] what takes less is not worth a line
_WORK = 1.5  # [s] of the processor, in a log: a refusal takes less, and stays one line on a busy machine
_WAITING = 10.0  # [s] after which a log has a line all the same: others may be at work for us
_TICK = 0.25  # [s] between two looks at the clock
_PAUSE = 2.0  # [s] between two lines of a log
_COUNT = re.compile(r"\b(\d+) of (\d+)\b")  # how far it is, where a message says so
_BAR = 18  # characters of the bar
_TIMED = 2  # of those that are counted, before what is left is told


def _left(seconds: float) -> str:
    """A time that is left, in words that do not pretend to more than they know."""
    return f"about {seconds:.0f} s left" if seconds < 90 else f"about {seconds / 60:.0f} min left"


def _bar(command: str) -> "Bar":
    """A line of the terminal's width; what is printed beside it on the same terminal comes above it."""
    from rich.console import Console
    from rich.progress import BarColumn, TextColumn
    from rich.progress import Progress as Bar
    from rich.table import Column

    rest = Column(ratio=1, no_wrap=True, overflow="ellipsis")
    bar = Bar(
        TextColumn(f"topple {command}:", markup=False),
        BarColumn(_BAR),
        TextColumn("{task.description}", markup=False, table_column=rest),
        TextColumn("{task.fields[left]}"),
        TextColumn("{task.fields[seconds]}"),
        console=Console(file=sys.stderr),
        expand=True,
        transient=True,
        auto_refresh=False,
        redirect_stdout=sys.stdout.isatty(),
    )
    bar.add_task("", total=None, left="", seconds="")
    return bar


class Progress:
    """Says on stderr what is going on and for how long; a callback for the library's progress.

    Where a message counts ("pile 3 of 20") there is a bar, and what is left once a share of it was timed.
    On a terminal one line as wide as that is drawn over and over and wiped at the end; elsewhere each new
    message is a line of its own, so that a log stays readable.

    Example:
        >>> with Progress("relate") as progress:
        ...     progress("reading scene.npz")
    """

    def __init__(self, command: str) -> None:
        self._command = command
        self._message = ""
        self._shown: str | None = None
        self._count: tuple[int, int] | None = None
        self._counted = (0.0, 0)  # since when, from which count on
        self._started, self._worked = 0.0, 0.0
        self._written = float("-inf")
        self._over = threading.Event()
        self._drawing = threading.Lock()
        self._thread = threading.Thread(target=self._watch, daemon=True)
        self._terminal = sys.stderr.isatty()
        self._bar: Bar | None = None

    def __enter__(self) -> "Progress":
        """Start the clock."""
        self._started, self._worked = time.monotonic(), time.process_time()
        self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        """Stop, and wipe the line."""
        self._over.set()
        self._thread.join()
        self.clear()

    def __call__(self, message: str) -> None:
        """Say what is going on from now on.

        Args:
            message: A few words.
        """
        self._message = message
        found = _COUNT.search(message)
        if found is None:
            return  # a word between two that count
        number, total = int(found[1]), int(found[2])
        if self._count is None or total != self._count[1] or number < self._count[0]:
            self._counted = time.monotonic(), number
        self._count = (number, total) if 0 < number <= total else None

    def _draw(self, seconds: float) -> None:
        """A bar, and what is left by what those counted took; one that wanders where nothing is counted."""
        if self._bar is None:
            self._bar = _bar(self._command)
            self._bar.start()
        number, total = self._count or (1, None)
        done = number - 1  # the one that is told of is not done yet
        since, first = self._counted
        timed, left = number - first, ""
        if total is not None and timed >= _TIMED:
            left = _left((time.monotonic() - since) / timed * (total - done))
        (task,) = self._bar.task_ids
        self._bar.update(task, description=self._message, completed=done, total=total)
        self._bar.update(task, left=left, seconds=f"({seconds:.0f} s)")
        self._bar.refresh()

    def clear(self) -> None:
        """Wipe the line until the next message, so that something else can be printed in its place."""
        with self._drawing:
            self._message = ""
            if self._bar is not None:
                self._bar.stop()
                self._bar = None

    def _worth_a_line(self, seconds: float) -> bool:
        at_work = self._terminal or time.process_time() - self._worked > _WORK or seconds > _WAITING
        return seconds > _PATIENCE and at_work

    def _watch(self) -> None:
        while not self._over.wait(_TICK):
            seconds = time.monotonic() - self._started
            with self._drawing:
                message = self._message
                if not message or not self._worth_a_line(seconds):
                    continue
                if self._terminal:
                    self._draw(seconds)
                elif message != self._shown and seconds - self._written >= _PAUSE:
                    self._written, self._shown = seconds, message
                    sys.stderr.write(f"topple {self._command}: {message} ({seconds:.0f} s)\n")
                    sys.stderr.flush()
