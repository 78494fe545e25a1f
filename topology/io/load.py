"""load_scene: whatever the path holds, as a Scene."""

import os
from collections.abc import Iterable
from pathlib import Path

from numpy.typing import ArrayLike

from topple.topology.checks import as_direction
from topple.topology.errors import InvalidInput
from topple.topology.io.archive import is_labelled, is_rgbd, read_arrays
from topple.topology.io.assemble import Parts, assemble
from topple.topology.io.clouds import parts_from_clouds
from topple.topology.io.folder import parts_from_folder
from topple.topology.io.labelled import parts_from_labelled
from topple.topology.io.limits import allowing
from topple.topology.io.pcd import is_pcd, read_labelled_pcd
from topple.topology.io.rgbd import parts_from_rgbd
from topple.topology.scene import Scene


def load_scene(
    path: str | os.PathLike[str],
    *,
    fixed: Iterable[str] = (),
    up: ArrayLike | None = None,
    most_bytes: int | None = None,
    allow_outside: bool = False,
) -> Scene:
    """Read a scene from a file or a folder, told apart by content.

    Four kinds are read: an `.npz` of clouds, one array (N, 3) per object; one cloud with a label per point,
    an `.npz` with `points` (N, 3) and `labels` (N,) or a `.pcd` with a field `label`; a folder with one cloud
    or mesh file per object and perhaps a `scene.json`; an RGB-D frame (`.npz` or `.npy`) with `depth`, `K`
    and a mask (H, W) or a stack `masks` (N, H, W). Where nothing is fixed, the table is the object named so,
    else the plane that carries the objects among the pixels or points of the background (label 0).

    The upward direction is `up`, else the one in the file, else the normal of its `table_plane`, else
    that of the plane of a fixed object, else unknown.

    Args:
        path: File or folder.
        fixed: Names of objects that never move, beside those the file names.
        up: Direction (3,) against gravity.
        most_bytes: What the files may unpack to; half a gigabyte where None.
        allow_outside: Whether `files` of a scene.json may lie elsewhere than below its folder.

    Returns:
        The scene; `assumptions` says what was assumed and not given.

    Raises:
        InvalidInput: If the path holds no scene or a broken one; one line that names file and object.
        UnknownObject: If `fixed` names an object that is not there.
    """
    given_up = None if up is None else as_direction(up, "up")
    place = Path(path)
    try:
        with allowing(most_bytes, allow_outside):
            parts = _read(place)
        return assemble(
            parts, [fixed] if isinstance(fixed, str) else list(fixed), given_up if up is None else up
        )
    except InvalidInput as error:
        _name_the_file(error, os.fspath(path))
        raise


def _read(path: Path) -> Parts:
    try:
        if path.is_dir():
            return parts_from_folder(path)
        if not path.exists():
            raise InvalidInput(
                "no such file or folder: expected an .npz, an .npy or a folder of clouds or meshes"
            )
        arrays = read_labelled_pcd(path) if is_pcd(path) else read_arrays(path)
    except OSError as error:
        raise InvalidInput(f"cannot be read: {error.strerror or error}") from error
    if is_labelled(arrays):
        return parts_from_labelled(arrays)
    return parts_from_rgbd(arrays) if is_rgbd(arrays) else parts_from_clouds(arrays)


def _name_the_file(error: InvalidInput, path: str) -> None:
    """Put the path, as it was given, before the message; the error keeps its type and what it carries."""
    error.args = (f"{path}: {error.args[0]}", *error.args[1:])
