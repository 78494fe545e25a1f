"""What a fuzzer knows of one reader: a sound file, how it is read, and what its answer has to be."""

import io
import os
import tempfile
import zipfile
from collections.abc import Callable, Generator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

Parts = Mapping[str, bytes]
"""Files of a folder, members of an archive, or the one file, by name."""


@dataclass(frozen=True)
class Reader:
    """One reader of topple.

    Attributes:
        name: What it reads.
        parts: A small sound input.
        read: Reads what was written to a path.
        wrong: What of an answer cannot be, by another reading of the same path; None where all is well.
        path: What is read below the folder that the parts are in; "" for the folder itself.
        packed: Whether the parts are members of one archive.
    """

    name: str
    parts: Callable[[], Parts]
    read: Callable[[Path], object]
    wrong: Callable[[object, Path], str | None]
    path: str = ""
    packed: bool = False

    def write(self, parts: Parts, folder: Path) -> Path:
        """Write an input.

        Args:
            parts: The input.
            folder: Where it is written to; an input of the same reader there is replaced.

        Returns:
            The path to be read.
        """
        if self.packed:
            (folder / self.path).write_bytes(packed(parts))
        else:
            for name, content in parts.items():
                (folder / name).parent.mkdir(exist_ok=True)
                (folder / name).write_bytes(content)
        return folder / self.path


SECRET = "topple-secret"
"""The first word of the file that links lead to."""


@contextmanager
def misplaced(kind: str, place: Path) -> Generator[None, None, None]:
    """Put something that is no file of the folder in the place of a file of it.

    Args:
        kind: One of `KINDS`.
        place: The file.
    """
    place.unlink()
    with tempfile.TemporaryDirectory(prefix=SECRET) as other:
        outside = Path(other) / f"{SECRET}{place.suffix}"
        outside.write_text(f"{SECRET}\n", encoding="ascii")
        KINDS[kind](place, outside)
        try:
            yield
        finally:
            place.rmdir() if kind == "folder" else place.unlink()


KINDS: dict[str, Callable[[Path, Path], None]] = {
    "pipe": lambda place, _: os.mkfifo(place),
    "folder": lambda place, _: place.mkdir(),
    "device": lambda place, _: place.symlink_to("/dev/zero"),
    "link": lambda place, outside: place.symlink_to(outside),
}
"""What may stand where a file is expected."""


def packed(parts: Parts) -> bytes:
    """An archive of parts, not compressed, so that what is altered in it is found."""
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w") as archive:
        for name, content in parts.items():
            archive.writestr(name, content)
    return buffer.getvalue()
