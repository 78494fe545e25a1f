"""What files may be: regular ones, below the scene's folder, that unpack to no more than is allowed."""

import os
import stat
from collections.abc import Generator
from contextlib import contextmanager
from contextvars import ContextVar
from pathlib import Path
from typing import BinaryIO

from topple.topology.base.errors import InvalidInput
from topple.topology.io.tolerances import MOST_BYTES

_most: ContextVar[int] = ContextVar("_most", default=MOST_BYTES)
_root: ContextVar[Path | None] = ContextVar("_root", default=None)
_outermost: ContextVar[Path | None] = ContextVar("_outermost", default=None)


@contextmanager
def allow(size: int | None, root: Path | None) -> Generator[None, None, None]:
    """Say in a block what files may be.

    Args:
        size: Bytes that they may unpack to; as before where None.
        root: The folder, or the one file, that they lie in; anywhere where None.
    """
    most, before = _most.set(_most.get() if size is None else size), _root.set(root)
    try:
        yield
    finally:
        _most.reset(most)
        _root.reset(before)


@contextmanager
def confine(root: Path) -> Generator[None, None, None]:
    """Say in a block that nothing outside a folder is read, whatever a format or a caller allows besides."""
    before = _outermost.set(root)
    try:
        yield
    finally:
        _outermost.reset(before)


@contextmanager
def allow_below(folder: Path) -> Generator[None, None, None]:
    """Say that files may lie in another folder, which a format names, where they may not lie anywhere."""
    with allow(None, None if _root.get() is None else folder):
        yield


def check_place(path: Path, what: str) -> Path:
    """Refuse what lies elsewhere than it may, by `..`, an absolute path or a link.

    Args:
        path: The file.
        what: What it is, for the message.

    Returns:
        Where it lies, links followed.

    Raises:
        InvalidInput: It does.
    """
    root, outermost = _root.get(), _outermost.get()
    try:
        place = Path(os.path.realpath(path))
    except ValueError as error:
        raise InvalidInput(f"{what} is called {str(path)!r}, which no file can be: {error}") from error
    if outermost is not None and not place.is_relative_to(os.path.realpath(outermost)):
        raise InvalidInput(f"{what} is not below the root: expected a path in the folder that is served")
    if root is not None and not place.is_relative_to(os.path.realpath(root)):
        raise InvalidInput(
            f"{what} is not below the folder: copy it there, or allow it with allow_outside=True"
        )
    return place


@contextmanager
def open_file(path: Path, what: str) -> Generator[BinaryIO, None, None]:
    """Open a file to read it. Everything that is read passes here.

    Args:
        path: The file.
        what: What it is, for the message.

    Yields:
        The open file.

    Raises:
        InvalidInput: It lies elsewhere than it may, or is a pipe, a device or a folder.
        OSError: It cannot be read.
    """
    check_place(path, what)
    handle = os.open(path, os.O_RDONLY | os.O_CLOEXEC | os.O_NONBLOCK)  # a pipe would be waited for
    try:
        if not stat.S_ISREG(os.fstat(handle).st_mode):
            raise InvalidInput(f"{what} is a pipe, a device or a folder: expected a file")
        with os.fdopen(handle, "rb", closefd=False) as file:
            yield file
    finally:
        os.close(handle)


def read_bytes(path: Path, what: str) -> bytes:
    """Read a whole file, of what size is allowed.

    Args:
        path: The file.
        what: What it is, for the message.

    Returns:
        Its content.

    Raises:
        InvalidInput: As for `open_file`, or it is too large.
        OSError: It cannot be read.
    """
    with open_file(path, what) as file:
        size = os.fstat(file.fileno()).st_size
        check_size(size, what)
        return file.read(size)


def read_given(path: Path, what: str) -> bytes:
    """Read a whole file that somebody named; as `read_bytes`, but InvalidInput where it cannot be read."""
    try:
        return read_bytes(path, what)
    except OSError as error:
        raise InvalidInput(f"{what}: cannot be read, {error.strerror or error}") from error


def read_text(path: Path, what: str) -> str:
    """Read a whole text.

    Args:
        path: The file.
        what: What it is, for the message.

    Returns:
        Its content, without the mark that some editors begin a text with.

    Raises:
        InvalidInput: As for `read_bytes`, or it is no UTF-8.
        OSError: It cannot be read.
    """
    try:
        return read_bytes(path, what).decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise InvalidInput(f"{what} is no text: {error}") from error


def size_limit() -> int:
    """Bytes that a file may unpack to."""
    return _most.get()


def check_size(size: int, what: str) -> None:
    """Refuse what would unpack to more than is allowed.

    Args:
        size: Bytes that it declares, or has.
        what: What it is, for the message.

    Raises:
        InvalidInput: It is too much.
    """
    if not 0 <= size <= _most.get():
        raise InvalidInput(
            f"{what} would unpack to {size / 1e6:.0f} MB, and {_most.get() / 1e6:.0f} MB are allowed: thin "
            "the clouds, or allow more with max_bytes=N"
        )
