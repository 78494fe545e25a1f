"""Output files are written whole or not at all, and so are sets of them."""

import os
import tempfile
from collections.abc import Mapping
from pathlib import Path

from topple.topology.base.errors import InvalidInput


def check_writable(path: str | os.PathLike[str]) -> Path:
    """Refuse an output path nothing can be written to, before the work that would be lost.

    Args:
        path: The file that is to be written.

    Returns:
        The path.

    Raises:
        InvalidInput: If it is a folder, its folder does not exist, or writing there is not allowed.
    """
    place = Path(path)
    if place.is_dir():
        raise InvalidInput(f"{place}: cannot be written, it is a folder; expected a file name")
    if place.exists() and not place.is_file():  # a device or a pipe is written as it is
        return place
    folder = place.resolve().parent
    if not folder.is_dir():
        raise InvalidInput(f"{place}: cannot be written, the folder {folder} does not exist; make it first")
    if not os.access(folder, os.W_OK | os.X_OK) or (place.exists() and not os.access(place, os.W_OK)):
        raise InvalidInput(f"{place}: cannot be written, permission denied")
    return place


def make_folder(path: str | os.PathLike[str]) -> Path:
    """Make a folder for output files, with those above it; one already there is fine.

    Args:
        path: The folder.

    Returns:
        The path.

    Raises:
        InvalidInput: If it cannot be made.
    """
    try:
        Path(path).mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise InvalidInput(f"{path}: cannot be made a folder, {error.strerror or error}") from error
    return Path(path)


def write_whole(path: str | os.PathLike[str], content: str | bytes) -> Path:
    """Write a file so that a reader finds the old content or the new one, never a part.

    The content goes to a file beside the target, which then takes the target's place.

    Args:
        path: The file; a symbolic link keeps pointing where it does.
        content: Text (written as UTF-8) or bytes.

    Returns:
        The path.

    Raises:
        InvalidInput: If the file cannot be written; nothing is left behind.
    """
    return write_all({path: content})[0]


def write_all(contents: Mapping[str | os.PathLike[str], str | bytes]) -> list[Path]:
    """Write files that belong together: all of them, or none.

    Args:
        contents: Path -> text (written as UTF-8) or bytes.

    Returns:
        The paths.

    Raises:
        InvalidInput: If one of them cannot be written; what was there of all of them stays.
    """
    places = [check_writable(path) for path in contents]
    ready: list[tuple[Path, Path]] = []
    place = Path()
    try:
        for place, content in zip(places, contents.values(), strict=True):
            data = content.encode("utf-8") if isinstance(content, str) else content
            if place.exists() and not place.is_file():
                place.write_bytes(data)
            else:
                ready.append((_beside(place.resolve(), data), place.resolve()))
        for part, place in ready:
            os.replace(part, place)
    except OSError as error:
        raise InvalidInput(f"{place}: cannot be written, {error.strerror or error}") from error
    finally:
        for part, _ in ready:
            part.unlink(missing_ok=True)
    return places


def _beside(place: Path, data: bytes) -> Path:
    """Write a file beside another one, with that one's permissions; its path.

    While it is written it has no name, where the file system can do that: nothing of it is left then, even if
    the process is killed.
    """
    folder = os.open(place.parent, os.O_RDONLY | os.O_DIRECTORY)
    try:
        handle, part = _nameless(place)
        try:
            with os.fdopen(handle, "wb", closefd=False) as file:
                file.write(data)
                file.flush()
                os.fsync(handle)
            os.fchmod(handle, _mode(place))
            if part is None:
                part = place.parent / f".{place.name}.{os.getpid()}-{os.urandom(4).hex()}.part"
                os.link(f"/proc/self/fd/{handle}", part.name, dst_dir_fd=folder, follow_symlinks=True)
        except BaseException:
            if part is not None:
                part.unlink(missing_ok=True)
            raise
        finally:
            os.close(handle)
    finally:
        os.close(folder)
    return part


def _nameless(place: Path) -> tuple[int, Path | None]:
    """A new file beside a place, without a name where there can be such; its descriptor, and its path."""
    try:
        return os.open(place.parent, os.O_TMPFILE | os.O_RDWR | os.O_CLOEXEC, 0o600), None
    except OSError:
        handle, part = tempfile.mkstemp(prefix=f".{place.name}.", suffix=".part", dir=place.parent)
        return handle, Path(part)


def _mode(place: Path) -> int:
    """Permissions of the file there, or those a new file would get."""
    if place.exists():
        return place.stat().st_mode & 0o7777
    mask = os.umask(0)
    os.umask(mask)
    return 0o666 & ~mask
