"""Results kept line by line, so that a bench of hours may be stopped and goes on."""

import errno
import fcntl
import json
import os
import stat
import weakref
from collections.abc import Mapping
from pathlib import Path
from types import TracebackType
from typing import Any

from topple.benchmarks.behaviour import BEHAVIOUR
from topple.benchmarks.episodes import FORMAT, Ending
from topple.topology.errors import InvalidInput
from topple.topology.io.strict_json import read_json

START = json.dumps({"format": FORMAT})[:-1]
"""How a line begins: what is no JSON and begins so was cut off, all else is somebody else's."""


class Journal:
    """A file of JSON lines; each tells which version of behaviour it is of, and only today's count.

    One process keeps it at a time, from when it is opened until it is closed: two that play the same would
    count it twice.

    Args:
        path: The file; it is made where it is not there.

    Raises:
        InvalidInput: The file cannot be written to, is something else (names the line), or another process
            keeps it.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self.stale = 0
        self.entries: list[Mapping[str, Any]] = []
        if path.exists() and not path.is_file():  # a pipe would be waited for
            raise InvalidInput(f"{path}: cannot keep results there (no file): give another file")
        try:
            self._file = os.open(path, os.O_CREAT | os.O_RDWR | os.O_APPEND | os.O_CLOEXEC, 0o666)
        except OSError as error:
            raise self._refused(error) from error
        self.close = weakref.finalize(self, os.close, self._file)
        try:
            if not stat.S_ISREG(os.fstat(self._file).st_mode):
                raise InvalidInput(f"{path}: is no file that results can be kept in: give another one")
            self._lock()
            text = path.read_text(encoding="utf-8")
            for number, line in enumerate(text.split("\n"), start=1):
                if line.strip():
                    self._take(line, number)
            if text and not text.endswith("\n"):  # the last line was cut off: the next starts afresh
                self._write(b"\n")
        except (OSError, UnicodeDecodeError) as error:
            self.close()
            raise self._refused(error) from error
        except BaseException:
            self.close()
            raise

    def __enter__(self) -> "Journal":
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()

    def _lock(self) -> None:
        """Keep others out, as far as the file system can."""
        try:
            fcntl.flock(self._file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError as error:
            raise InvalidInput(
                f"{self.path}: another process keeps its results there: wait for it, or give another file"
            ) from error
        except OSError:  # a network's file system without locks
            return

    def _refused(self, error: Exception) -> InvalidInput:
        return InvalidInput(f"{self.path}: cannot keep results there ({error}): give another file")

    def _take(self, line: str, number: int) -> None:
        """Take in a line; one that was cut off when a bench was killed stands for what is played again."""
        try:
            entry: Any = read_json(line, "the line")
        except InvalidInput as error:
            if line.startswith(START[: len(line)]) and not line.rstrip().endswith("}"):
                return
            raise self._refusal(number, str(error)) from error
        if not isinstance(entry, dict) or entry.get("format") != FORMAT:
            raise self._refusal(number, f"it is no result, expected {START}, ...}}")
        if entry.get("behaviour") != BEHAVIOUR:
            self.stale += 1
            return
        try:
            Ending.from_json(entry)
        except InvalidInput as error:
            raise self._refusal(number, str(error)) from error
        self.entries.append(entry)

    def _refusal(self, number: int, reason: str) -> InvalidInput:
        return InvalidInput(
            f"{self.path}: line {number} is no journal of a bench ({reason}): give another file, or take the "
            "line out"
        )

    def add(self, entry: Mapping[str, Any]) -> None:
        """Append an entry, at once and whole.

        Args:
            entry: JSON data.

        Raises:
            InvalidInput: It cannot be written; what was kept before stays.
        """
        kept = {**entry, "behaviour": BEHAVIOUR}
        try:
            self._write((json.dumps(kept) + "\n").encode())
        except OSError as error:
            raise self._refused(error) from error
        self.entries.append(kept)

    def _write(self, line: bytes) -> None:
        if os.write(self._file, line) < len(line):  # the rest found no room; a reader skips the line
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
