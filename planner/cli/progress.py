"""One line on stderr about what is going on, once it takes over a second."""

import sys
import threading
import time
from types import TracebackType

_PATIENCE = 1.0  # [s] what takes less is not worth a line
_TICK = 0.25  # [s] between two looks at the clock
_PAUSE = 2.0  # [s] between two lines of a log


class Progress:
    """Says on stderr what is going on and for how long; a callback for the library's progress.

    On a terminal one line is drawn over and over and wiped at the end; elsewhere each new message is
    a line of its own, so that a log stays readable.

    Example:
        >>> with Progress("relate") as progress:
        ...     progress("reading scene.npz")
    """

    def __init__(self, command: str) -> None:
        self._command = command
        self._message = ""
        self._shown: str | None = None
        self._started = 0.0
        self._written = float("-inf")
        self._over = threading.Event()
        self._drawing = threading.Lock()
        self._thread = threading.Thread(target=self._watch, daemon=True)
        self._terminal = sys.stderr.isatty()

    def __enter__(self) -> "Progress":
        """Start the clock."""
        self._started = time.monotonic()
        self._thread.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, traceback: TracebackType | None
    ) -> None:
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

    def clear(self) -> None:
        """Wipe the line, so that something else can be printed in its place."""
        with self._drawing:
            if self._terminal and self._shown is not None:
                sys.stderr.write("\r\x1b[K")
                sys.stderr.flush()
                self._shown = None

    def _watch(self) -> None:
        while not self._over.wait(_TICK):
            seconds = time.monotonic() - self._started
            message = self._message
            if seconds < _PATIENCE or not message:
                continue
            with self._drawing:
                if self._terminal:
                    sys.stderr.write(f"\r\x1b[Ktopple {self._command}: {message} ({seconds:.0f} s)"[:118])
                elif message == self._shown or seconds - self._written < _PAUSE:
                    continue
                else:
                    self._written = seconds
                    sys.stderr.write(f"topple {self._command}: {message} ({seconds:.0f} s)\n")
                self._shown = message
                sys.stderr.flush()
