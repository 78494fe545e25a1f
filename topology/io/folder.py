"""A folder with one cloud or mesh file per object, and perhaps a scene.json."""

import os
from collections.abc import Iterable
from pathlib import Path
from typing import Any, cast

from numpy.typing import ArrayLike

from topple.topology.base.arrays import FloatArray
from topple.topology.base.checks import as_name, as_points, as_pose
from topple.topology.base.errors import InvalidInput
from topple.topology.geometry.rigid import move_points
from topple.topology.io.assemble import Parts
from topple.topology.io.geometry import SUFFIXES, read_geometry
from topple.topology.io.limits import check_place, read_text
from topple.topology.io.strict_json import read_json
from topple.topology.io.text import NOTES, TEXTS, no_cloud
from topple.topology.io.tolerances import MOST_LISTED
from topple.topology.scene.mesh import Mesh

_DESCRIPTION = "scene.json"
_KEYS = (
    *("up", "fixed", "viewpoints", "table_plane", "robot_base", "poses", "files"),
    *("masses", "friction", "centres"),
)
_SILENT_KEYS = ("format", "format_version", "name", "comment")


def reads(path: Path) -> bool:
    """Any folder is one: what is in it that is no object is told when it is read."""
    return path.is_dir()


def read(path: Path) -> Parts:
    """Read every object of a folder.

    Each cloud (`.ply`, `.pcd`, or a text: `.xyz`, `.txt`, `.csv`, `.pts`, `.asc`) or mesh (`.obj`,
    `.stl`, `.ply`, `.glb`) is an object named as the file. `scene.json` may give `files` {name: file} to
    name files otherwise or use one twice, `poses` {name: 4x4 object to world}, `masses` {name: kg},
    `friction` {name: coefficient}, `centres` {name: [x, y, z]} of mass in the world, and `up`, `fixed`,
    `viewpoints`, `table_plane`, `robot_base`. What is in the folder and no cloud or mesh, a text with a
    matrix or a trajectory too, is named in a note.

    Args:
        path: The folder.

    Returns:
        What the folder says, in world coordinates.

    Raises:
        InvalidInput: If it has no clouds, two files for one object, or a broken file.
        OSError: If a file cannot be read.
    """
    described = _read_description(path / _DESCRIPTION)
    files = _files_by_object(path, described)
    poses = {
        name: as_pose(cast(ArrayLike, pose), f"pose of {name!r} in {_DESCRIPTION}")
        for name, pose in _mapping_of(described, "poses").items()
    }
    for name in poses:
        if name not in files:
            raise InvalidInput(f"{_DESCRIPTION} has a pose of {name!r}, but the objects are {_list(files)}")
    parts = Parts(
        clouds={},
        fixed=_fixed_names(described),
        up=described.get("up"),
        viewpoints=described.get("viewpoints"),
        table_plane=described.get("table_plane"),
        robot_base=described.get("robot_base"),
        notes=[
            f"{_DESCRIPTION}: the key {key!r} is not known and was ignored"
            for key in described
            if key not in _KEYS + _SILENT_KEYS
        ],
        masses=described.get("masses"),
        friction=described.get("friction"),
        centres=described.get("centres"),
    )
    parts.notes += _note_on_unused(path, files.values())
    for name, file in files.items():
        _add_object(parts, name, file, poses.get(name))
    return parts


def _add_object(parts: Parts, name: str, file: Path, pose_object_to_world: FloatArray | None) -> None:
    points, faces, vertices = read_geometry(file, f"cloud {name!r} ({file.name})")
    if pose_object_to_world is not None:
        points, vertices = (move_points(each, pose_object_to_world) for each in (points, vertices))
    parts.clouds[name] = points
    if faces is not None:
        parts.meshes[name] = Mesh(as_points(vertices, f"mesh {name!r} ({file.name})"), faces)


def _files_by_object(folder: Path, described: dict[str, Any]) -> dict[str, Path]:
    """Name every file: as `files` says, the others after themselves."""
    named: dict[str, Path] = {}
    for name, file in _mapping_of(described, "files").items():
        if not isinstance(file, str):
            raise InvalidInput(f"{_DESCRIPTION} gives {file!r} as the file of {name!r}: expected a file name")
        place = folder / file
        check_place(place, f"the file {file!r} of {name!r} in {_DESCRIPTION}")
        if not place.is_file():
            raise InvalidInput(
                f"{_DESCRIPTION} gives {file!r} as the file of {name!r}, and it does not exist"
            )
        if place.suffix.lower() not in SUFFIXES:
            raise InvalidInput(
                f"{_DESCRIPTION} gives {file!r} as the file of {name!r}: expected {', '.join(SUFFIXES)}"
            )
        named[as_name(name)] = place
    taken = {os.path.realpath(place) for place in named.values()}
    for place in sorted(folder.iterdir()):
        if os.path.realpath(place) in taken or not _is_object(place):
            continue
        if place.stem in named:
            raise InvalidInput(
                f"{named[place.stem].name} and {place.name} are both object {place.stem!r}: "
                f'rename one, or choose in {_DESCRIPTION}: "files": {{name: file}}'
            )
        named[as_name(place.stem)] = place
    if not named:
        raise InvalidInput(
            f"the folder has no clouds or meshes: expected {', '.join(SUFFIXES)}, one per object"
        )
    return named


def _is_object(place: Path) -> bool:
    """Whether something in the folder is an object's file by its name, and a text by what is in it."""
    suffix = place.suffix.lower()
    if suffix not in SUFFIXES or place.name.startswith(".") or not place.is_file():
        return False
    other = no_cloud(place) if suffix in TEXTS else None
    return other is None or (other == NOTES and suffix == ".xyz")


def _note_on_unused(folder: Path, used: Iterable[Path]) -> list[str]:
    """The note on what is in the folder and was not read; hidden files are nobody's objects."""
    known = {os.path.realpath(place) for place in (*used, folder / _DESCRIPTION)}
    left = [place for place in sorted(folder.iterdir()) if os.path.realpath(place) not in known]
    names = [place.name + _kind_of(place) for place in left if not place.name.startswith(".")]
    if not names:
        return []
    more = f" and {len(names) - MOST_LISTED} more" if len(names) > MOST_LISTED else ""
    return [f"not used, being no cloud or mesh: {', '.join(names[:MOST_LISTED])}{more}"]


def _kind_of(place: Path) -> str:
    """Say after an unused file's name that it is a folder, or numbers that are no cloud."""
    if place.suffix.lower() in TEXTS and place.is_file() and (other := no_cloud(place)) not in (None, NOTES):
        return f" ({other})"
    return "/" * place.is_dir()


def _read_description(path: Path) -> dict[str, Any]:
    if not path.exists():
        return {}
    described = read_json(read_text(path, _DESCRIPTION), _DESCRIPTION)
    if not isinstance(described, dict):
        raise InvalidInput(f"{_DESCRIPTION} holds {type(described).__name__}: expected an object {{...}}")
    return cast(dict[str, Any], described)


def _mapping_of(described: dict[str, Any], key: str) -> dict[str, Any]:
    value = described.get(key) or {}
    if not isinstance(value, dict):
        raise InvalidInput(f"{_DESCRIPTION}: {key} holds {type(value).__name__}, expected {{name: ...}}")
    return cast(dict[str, Any], value)


def _fixed_names(described: dict[str, Any]) -> list[str]:
    value = described.get("fixed") or []
    names = [value] if isinstance(value, str) else value
    if not isinstance(names, list) or not all(isinstance(name, str) for name in cast(list[Any], names)):
        raise InvalidInput(f'{_DESCRIPTION}: fixed is {value!r}, expected a list of names, such as ["table"]')
    return cast(list[str], names)


def _list(names: Iterable[str]) -> str:
    return ", ".join(sorted(names))
