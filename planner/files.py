"""Output files are written whole or not at all."""

import os
import tempfile
from pathlib import Path

from topple.topology.errors import InvalidInput


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
    place = check_writable(path)
    data = content.encode("utf-8") if isinstance(content, str) else content
    try:
        if place.exists() and not place.is_file():
            place.write_bytes(data)
        else:
            _replace(place.resolve(), data)
    except OSError as error:
        raise InvalidInput(f"{place}: cannot be written, {error.strerror or error}") from error
    return place


def _replace(place: Path, data: bytes) -> None:
    handle, beside = tempfile.mkstemp(prefix=f".{place.name}.", suffix=".part", dir=place.parent)
    try:
        with os.fdopen(handle, "wb") as file:
            file.write(data)
            file.flush()
            os.fsync(file.fileno())
        os.chmod(beside, _mode(place))
        os.replace(beside, place)
    except BaseException:
        os.unlink(beside)
        raise


def _mode(place: Path) -> int:
    """Permissions of the file there, or those a new file would get."""
    if place.exists():
        return place.stat().st_mode & 0o7777
    mask = os.umask(0)
    os.umask(mask)
    return 0o666 & ~mask
