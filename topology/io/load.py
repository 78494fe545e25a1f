"""load_scene: whatever the path holds, as a Scene."""

import inspect
import os
from collections.abc import Callable
from pathlib import Path
from typing import Annotated, Any, Protocol

from numpy.typing import ArrayLike

from topple.topology.base.arguments import checked_arguments
from topple.topology.base.arrays import Bodies
from topple.topology.base.checks import Names, as_direction, as_names
from topple.topology.base.errors import InvalidInput
from topple.topology.base.plugins import Table, check_kind
from topple.topology.base.public_names import with_new_names
from topple.topology.io.assemble import Parts, assemble
from topple.topology.io.limits import allow
from topple.topology.scene.scene import Scene


class Reader(Protocol):
    """A format of scenes: a module or an object with two functions."""

    def reads(self, path: Path) -> bool:
        """Whether what is there is of this format, complete or not; the path exists."""
        ...

    def read(self, path: Path, **options: Any) -> Parts:
        """Read a file: `Parts(clouds={name: points})` and whatever else it knows.

        Raises:
            InvalidInput: If it is broken; one line with what was expected.
            OSError: If it cannot be read.
        """
        ...


READERS: Table[Reader] = Table(
    "topple.scenes",
    "reader of scenes",
    {
        "bop": "topple.topology.io.bop",
        "bag": "topple.topology.io.bag",
        "pile": "topple.topology.io.pile",
        "mjcf": "topple.topology.io.mjcf",
        "poses": "topple.topology.io.poses",
        "nodes": "topple.topology.io.nodes",
        "folder": "topple.topology.io.folder",
        "file": "topple.topology.io.file",
    },
)
"""Every format by its name, asked in this order after those of other packages."""


@checked_arguments
def load_scene(
    path: str | os.PathLike[str],
    *,
    fixed: Names = (),
    up: ArrayLike | None = None,
    max_bytes: int | None = None,
    allow_outside: bool = False,
    models: bool | str | os.PathLike[str] | None = None,
    robot_bodies: Bodies | Callable[[Scene], Bodies] = (),
    **options: Any,
) -> Scene:
    """Read a scene from a file or a folder, told apart by content.

    Ten kinds are read: an `.npz` of clouds, one array (N, 3) per object; one cloud with a label per
    point, an `.npz` with `points` (N, 3) and `labels` (N,) or a `.pcd` with a field `label`; a folder
    with one cloud or mesh file per object and perhaps a `scene.json`; an RGB-D frame (`.npz` or `.npy`)
    with `depth`, `K` and a mask (H, W) or a stack `masks` (N, H, W); an image of a scene of a BOP dataset
    (`topple.topology.io.bop`); a frame of a recording of ROS (`topple.topology.io.bag`); a view of a
    recorded pile (`topple.topology.io.pile`); an MJCF file (`topple.topology.io.mjcf`); a list of meshes
    and poses (`topple.topology.io.poses`); a GLB or OBJ file with a node or group an object
    (`topple.topology.io.nodes`). Other packages add more (`READERS`).

    Where nothing is fixed, the table is the object named so, else the plane that carries the objects among
    the pixels or points of the background (label 0).

    The upward direction is `up`, else the one in the file, else the normal of its `table_plane`, else
    that of the plane of a fixed object, else unknown.

    Args:
        path: File or folder.
        fixed: Names of objects that never move, beside those the file names.
        up: Direction (3,) against gravity.
        max_bytes: What the files may unpack to; half a gigabyte where None.
        allow_outside: Whether `files` of a scene.json may lie elsewhere than below its folder.
        models: A folder of known models, which take the place of what was seen of objects of their names
            where they fit (`topple.topology.with_models`); or whether the models of a BOP dataset are taken
            at their true poses although there is depth.
        robot_bodies: Corners (V, 3) [m] of bodies whose points are nobody's, or what gives them for the
            scene: a robot in its own picture, `arm.bodies(q, pose_base_to_world)`.
        **options: What its format alone has: `image=3` for a BOP dataset and a recording.

    Returns:
        The scene; `assumptions` says what was assumed and not given.

    Raises:
        InvalidInput: If the path holds no scene or a broken one; one line that names file and object.
        UnknownObject: If `fixed` names an object that is not there.

    Examples:
        >>> np.savez("scene.npz", **scene.clouds)
        >>> load_scene("scene.npz", fixed="table", up=[0, 0, 1]).names
        ('table', 'book', 'cup')
    """
    given_up = None if up is None else as_direction(up, "up")
    place = _as_path(path)
    if isinstance(models, bool):
        options["models"] = models
    try:
        with allow(max_bytes, None if allow_outside else place):
            parts = _read(place, options)
            scene = assemble(
                parts, as_names(fixed), given_up if up is None else up,
                robot_bodies,
            )  # fmt: skip
            if models is None or isinstance(models, bool):
                return scene
            from topple.topology.io.known_models import with_models  # which few ask for

        with allow(max_bytes, None if allow_outside else Path(models)):
            return with_models(scene, models)
    except InvalidInput as error:
        _name_the_file(error, os.fspath(path))
        raise


AnyScene = Annotated[
    Scene | str | os.PathLike[str], "clouds and meshes make one by name, scene_from_objects({'mug': mesh})"
]
"""A scene as it is, or the path of one; and what to say where it is neither."""


@checked_arguments
def as_scene(source: AnyScene) -> Scene:
    """A scene as it is, or read from a path; see `load_scene`.

    Args:
        source: Either.

    Raises:
        InvalidInput: If it is neither, or what the path holds is none.
    """
    return source if isinstance(source, Scene) else load_scene(source)


def _as_path(path: str | os.PathLike[str]) -> Path:
    if not os.fspath(path):
        raise InvalidInput("the path of the scene is empty: expected that of a file or a folder")
    return Path(path)


def _read(path: Path, options: dict[str, Any]) -> Parts:
    try:
        if not path.exists():
            raise InvalidInput(
                "no such file or folder: expected an .npz, an .npy or a folder of clouds or meshes"
            )
        known = path.is_dir() or path.is_file()  # a pipe would be waited for
        if known and (found := READERS.first(lambda reader: reader.reads(path))) is not None:
            name, reader = found
            given = _check_options(name, reader, options)
            with READERS.blame(name):
                return check_kind(reader.read(path, **given), Parts)
    except OSError as error:
        raise InvalidInput(f"cannot be read: {error.strerror or error}") from error
    raise InvalidInput(
        "neither a file nor a folder: expected an .npz, an .npy or a folder of clouds or meshes"
    )


def _check_options(name: str, reader: Reader, options: dict[str, Any]) -> dict[str, Any]:
    """Options by the names that they have now; refuse those that a format does not have."""
    known = inspect.signature(reader.read).parameters
    options = with_new_names(options, known)
    stray = [key for key in options if key not in known]
    if stray and not any(each.kind is each.VAR_KEYWORD for each in known.values()):
        raise InvalidInput(f"is of the format {name!r}, which has no option {', '.join(stray)}: leave it out")
    return options


def _name_the_file(error: InvalidInput, path: str) -> None:
    """Put the path, as it was given, before the message; the error keeps its type and what it carries."""
    error.args = (f"{path}: {error.args[0]}", *error.args[1:])
