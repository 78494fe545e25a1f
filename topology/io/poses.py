"""A `poses.json`: which mesh stands where, as estimators of poses give it."""

from pathlib import Path
from typing import Any, cast

from topple.topology.base.checks import as_name, as_points, as_pose
from topple.topology.base.errors import InvalidInput
from topple.topology.geometry.rigid import move_points
from topple.topology.io.assemble import Parts
from topple.topology.io.geometry import read_geometry
from topple.topology.io.limits import allow_below, read_text
from topple.topology.io.strict_json import read_json
from topple.topology.scene.mesh import Mesh

_EXPECTED = '[{"name": "mug", "mesh": "meshes/mug.obj", "pose": 4x4 object to world}, ...]'
_KNOWN = ("up", "fixed", "viewpoints", "table_plane", "masses", "friction", "centres")


def reads(path: Path) -> bool:
    """Whether it is called as one."""
    return path.suffix.lower() == ".json" and path.is_file()


def read(path: Path) -> Parts:
    """Read meshes at their poses.

    Args:
        path: The file: a list of `{name, mesh, pose}`, or such a list as `objects` beside `up`, `fixed`,
            `viewpoints`, `table_plane`, `masses`, `friction` and `centres`. Meshes lie below its folder, in
            [m]; poses are 4x4, object to world.

    Returns:
        What it says, in world coordinates.

    Raises:
        InvalidInput: It is no such file, or a mesh cannot be read.
        OSError: A file cannot be read.
    """
    told = read_json(read_text(path, path.name), path.name)
    described = cast(dict[str, Any], told) if isinstance(told, dict) else {"objects": told}
    listed = described.get("objects")
    if not isinstance(listed, list) or not listed:
        raise InvalidInput(f"it lists no objects: expected {_EXPECTED}")
    parts = Parts({}, **{key: described[key] for key in _KNOWN if key in described})
    with allow_below(path.parent):
        for number, entry in enumerate(cast(list[Any], listed)):
            _add(parts, path.parent, number, entry)
    return parts


def _add(parts: Parts, folder: Path, number: int, entry: Any) -> None:
    """Add one object of the list."""
    if not isinstance(entry, dict) or not all(isinstance(entry.get(key), str) for key in ("name", "mesh")):
        raise InvalidInput(f"object {number} has no name or no mesh: expected {_EXPECTED}")
    name = as_name(cast(str, entry["name"]))
    if name in parts.clouds:
        raise InvalidInput(f"two objects are called {name!r}: give each its own name")
    pose = as_pose(entry.get("pose"), f"pose of {name!r}")
    points, faces, vertices = read_geometry(folder / cast(str, entry["mesh"]), f"mesh of {name!r}")
    parts.clouds[name] = move_points(points, pose)
    if faces is not None:
        parts.meshes[name] = Mesh(as_points(move_points(vertices, pose), f"mesh {name!r}"), faces)
