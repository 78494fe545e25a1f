"""The folder that a server may read and write, and scenes read from there or from the request itself."""

from collections.abc import Generator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

import msgspec
import numpy as np

from topple.topology.base.errors import InvalidInput
from topple.topology.io.assemble import Parts, assemble
from topple.topology.io.limits import allow, check_place, check_size, confine, read_given
from topple.topology.io.load import load_scene
from topple.topology.io.mjcf import parts_from_mjcf
from topple.topology.scene.scene import Scene

Point = tuple[float, float, float]


class SceneSource(msgspec.Struct, frozen=True, forbid_unknown_fields=True, kw_only=True):
    """A scene: give one of path, clouds and mjcf. Metres."""

    path: Annotated[str, msgspec.Meta(description="file or folder, relative to the served folder")] = ""
    masks: Annotated[str, msgspec.Meta(description="file of masks as SAM's, of a frame without any")] = ""
    clouds: Annotated[
        dict[str, list[Point]], msgspec.Meta(description="points of each object's surface by its name")
    ] = {}
    mjcf: Annotated[str, msgspec.Meta(description="text of an MJCF file")] = ""
    fixed: Annotated[tuple[str, ...], msgspec.Meta(description="names that never move, as the table")] = ()
    up: Annotated[Point | None, msgspec.Meta(description="direction against gravity")] = None
    viewpoints: Annotated[tuple[Point, ...], msgspec.Meta(description="camera centres, of clouds")] = ()


@dataclass(frozen=True)
class Root:
    """The one folder of a server.

    Attributes:
        folder: The folder, without links.
        fixed: Names that never move, in scenes that name none.
        up: Direction against gravity, for scenes that give none.
        seed: Of every search.
        max_bytes: What a file, or the clouds of a request, may unpack to; as much as is usual where None.
    """

    folder: Path
    fixed: tuple[str, ...] = ()
    up: Point | None = None
    seed: int = 0
    max_bytes: int | None = None

    @staticmethod
    def at(folder: str | Path, **more: Any) -> "Root":
        """A root at a folder; more are attributes by name.

        Raises:
            InvalidInput: There is no such folder.
        """
        place = Path(folder).resolve()
        if not place.is_dir():
            raise InvalidInput(f"--root {folder}: no such folder; expected the one that is served")
        return Root(place, **more)

    @contextmanager
    def _confine_reading(self) -> Generator[None, None, None]:
        with confine(self.folder), allow(self.max_bytes, self.folder):
            yield

    def place(self, path: str) -> Path:
        """The place of a path in the folder, links followed.

        Raises:
            InvalidInput: It is outside, by `..`, as an absolute path or by a link.
        """
        with confine(self.folder):
            return check_place(self.folder / path, path)

    def scene(self, source: SceneSource) -> Scene:
        """Read a scene.

        Raises:
            InvalidInput: It is none, is given in no way or in two, is too large, or is not below the folder.
        """
        given = [key for key in ("path", "clouds", "mjcf") if getattr(source, key)]
        if len(given) != 1:
            raise InvalidInput(f"the scene has {' and '.join(given) or 'nothing'}: give path, clouds or mjcf")
        fixed, up = source.fixed or self.fixed, source.up or self.up
        with self._confine_reading():
            if source.path:
                masks: dict[str, Any] = {"masks": self.place(source.masks)} if source.masks else {}
                return load_scene(self.place(source.path), fixed=fixed, up=up, **masks)
            if source.mjcf:
                check_size(len(source.mjcf), "the MJCF")
                return assemble(parts_from_mjcf(source.mjcf, self.folder), list(fixed), up)
            check_size(24 * sum(map(len, source.clouds.values())), "the clouds")  # three floats a point
        clouds = {name: np.array(points, dtype=np.float64) for name, points in source.clouds.items()}
        seen_from = np.array(source.viewpoints, dtype=np.float64) if source.viewpoints else None
        return assemble(Parts(dict(clouds), viewpoints=seen_from), list(fixed), up)

    def read(self, path: str) -> bytes:
        """Read a file.

        Raises:
            InvalidInput: It is not below the folder, is too large, or cannot be read.
        """
        with self._confine_reading():
            return read_given(self.place(path), path)
