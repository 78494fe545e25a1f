"""Results kept line by line, so that work of hours may be stopped and goes on."""

import errno
import fcntl
import json
import os
import stat
import weakref
from abc import ABC, abstractmethod
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from topple.topology.base.errors import InvalidInput
from topple.topology.io.strict_json import read_json


class JsonLines(ABC):
    """A file of JSON lines; each is appended whole, and a file that is there is gone on with.

    One process keeps it at a time, from when it is opened until it is closed: two that do the same work would
    count it twice.

    Args:
        path: The file; it is made where it is not there.
        kind: What such a file is, in a word or two, for messages.
        start: The JSON text that each line begins with: what is no JSON and begins so was cut off when its
            writer was killed, and is left out; all else is somebody else's.

    Raises:
        InvalidInput: The file cannot be written to, is something else (names the line), or another process
            keeps it.
    """

    def __init__(self, path: Path, kind: str, start: str) -> None:
        self.path, self._kind, self._start = path, kind, start
        if path.exists() and not path.is_file():  # a pipe would be waited for
            raise InvalidInput(f"{path}: cannot keep results there (no file): give another file")
        try:
            self._file = os.open(path, os.O_CREAT | os.O_RDWR | os.O_APPEND | os.O_CLOEXEC, 0o666)
        except OSError as error:
            raise self._as_invalid(error) from error
        self.close = weakref.finalize(self, os.close, self._file)
        try:
            if not stat.S_ISREG(os.fstat(self._file).st_mode):
                raise InvalidInput(f"{path}: is no file that results can be kept in: give another one")
            self._lock()
            line = ""
            with path.open(encoding="utf-8", newline="\n") as lines:
                for number, line in enumerate(lines, start=1):
                    if line.strip():
                        self._read(line.rstrip("\n"), number)
            if line and not line.endswith("\n"):  # the last line was cut off: the next starts afresh
                self._write(b"\n")
        except (OSError, UnicodeDecodeError) as error:
            self.close()
            raise self._as_invalid(error) from error
        except BaseException:
            self.close()
            raise

    def __enter__(self) -> "JsonLines":
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    @abstractmethod
    def _take(self, entry: Any) -> None:
        """Take in what a line of the file says.

        Raises:
            InvalidInput: It is not what such a file holds.
        """

    def add(self, entry: Mapping[str, Any]) -> None:
        """Append an entry, at once and whole.

        Args:
            entry: JSON data.

        Raises:
            InvalidInput: It cannot be written; what was kept before stays.
        """
        try:
            self._write((json.dumps(entry) + "\n").encode())
        except OSError as error:
            raise self._as_invalid(error) from error

    def _read(self, line: str, number: int) -> None:
        try:
            entry: Any = read_json(line, "the line")
        except InvalidInput as error:
            if line.startswith(self._start[: len(line)]) and not line.rstrip().endswith("}"):
                return
            raise self._refusal(number, error) from error
        try:
            self._take(entry)
        except InvalidInput as error:
            raise self._refusal(number, error) from error

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

    def _as_invalid(self, error: Exception) -> InvalidInput:
        return InvalidInput(f"{self.path}: cannot keep results there ({error}): give another file")

    def _refusal(self, number: int, reason: Exception) -> InvalidInput:
        return InvalidInput(
            f"{self.path}: line {number} is no {self._kind} ({reason}): give another file, or take the line "
            "out"
        )

    def _write(self, line: bytes) -> None:
        if os.write(self._file, line) < len(line):  # the rest found no room; a reader skips the line
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
