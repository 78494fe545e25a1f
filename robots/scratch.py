"""Folders for files that are needed for a while; those of processes that were killed are cleared away."""

import fcntl
import os
import shutil
import tempfile
from functools import cache
from pathlib import Path

PREFIX = "topple-"
LOCK = ".in-use"


class Scratch:
    """A folder of its own in the system's folder for temporary files.

    Whoever uses it holds a lock on a file in it, which the system gives up with the process. The first one
    that a process makes clears away those that nobody holds.

    Attributes:
        path: The folder.
    """

    def __init__(self) -> None:
        _clear(Path(tempfile.gettempdir()))
        while True:
            self.path = Path(tempfile.mkdtemp(prefix=PREFIX))
            try:
                self._lock = os.open(self.path / LOCK, os.O_CREAT | os.O_RDWR | os.O_CLOEXEC, 0o600)
                fcntl.flock(self._lock, fcntl.LOCK_EX)
            except FileNotFoundError:
                continue
            if (self.path / LOCK).exists():
                return
            os.close(self._lock)  # taken for a stale one before it was locked

    def close(self) -> None:
        """Remove the folder with all that is in it; more than once does no harm."""
        if self._lock >= 0:
            shutil.rmtree(self.path, ignore_errors=True)
            os.close(self._lock)
            self._lock = -1


@cache
def _clear(place: Path) -> None:
    """Remove the folders of processes that are gone, once in a process."""
    for lock in place.glob(f"{PREFIX}*/{LOCK}"):
        try:
            held = os.open(lock, os.O_RDWR | os.O_CLOEXEC | os.O_NOFOLLOW)
        except OSError:  # somebody else's, or gone by now
            continue
        try:
            fcntl.flock(held, fcntl.LOCK_EX | fcntl.LOCK_NB)
            shutil.rmtree(lock.parent, ignore_errors=True)
        except OSError:  # in use
            pass
        finally:
            os.close(held)
