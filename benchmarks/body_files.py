"""Bodies read from a folder: convex parts, surface and mass, as object sets are published."""

import json
from pathlib import Path
from typing import Any

import numpy as np

from topple.robots.world.bodies import GREY, Body
from topple.robots.world.tolerances import FRICTION
from topple.topology.base.arrays import FloatArray
from topple.topology.base.errors import InvalidInput
from topple.topology.scene.mesh import Mesh


def body_from_files(folder: str | Path, name: str | None = None, *, friction: float = FRICTION) -> Body:
    """Read a body from a folder with `collision.obj`, and `mesh.obj` and `meta.json` where there are such.

    Args:
        folder: Holds `collision.obj`, one convex part per `o` group; `mesh.obj`, the surface; and
            `meta.json` with `mass_kg` and `rgba`.
        name: Name in the scene; None: the folder's.
        friction: Coulomb coefficient.

    Returns:
        The body, in the frame of the files.

    Raises:
        InvalidInput: If a file is missing or is not what it should be; names it.
    """
    folder = Path(folder)
    parts = _parts_of(folder / "collision.obj")
    meta = _meta_of(folder / "meta.json")
    red, green, blue, opacity = (float(c) for c in meta.get("rgba") or GREY)
    return Body.of(
        name or folder.name,
        parts,
        mesh=_mesh_of(folder / "mesh.obj"),
        mass=meta.get("mass_kg"),
        friction=friction,
        color=(red, green, blue, opacity),
        kind=folder.name,
    )


def _parts_of(path: Path) -> list[FloatArray]:
    """Vertices of each `o` group of a Wavefront file."""
    groups: list[list[list[float]]] = []
    try:
        for line in path.read_text(encoding="utf-8").splitlines():
            if line.startswith("o "):
                groups.append([])
            elif line.startswith("v "):
                if not groups:
                    groups.append([])
                groups[-1].append([float(word) for word in line.split()[1:4]])
    except (OSError, ValueError) as error:
        raise InvalidInput(f"{path} cannot be read as a Wavefront file: {error}") from error
    parts = [np.array(group) for group in groups if len(group) >= 4]
    if not parts:
        raise InvalidInput(f"{path} has no part of four vertices: expected one convex part per `o` group")
    return parts


def _meta_of(path: Path) -> dict[str, Any]:
    """What the folder says about its object; nothing if it says nothing."""
    if not path.is_file():
        return {}
    try:
        return dict(json.loads(path.read_text(encoding="utf-8")))
    except (ValueError, TypeError) as error:
        raise InvalidInput(f"{path} cannot be read: {error}; expected a JSON object with mass_kg") from error


def _mesh_of(path: Path) -> Mesh | None:
    """The one mesh of a file, if there is the file."""
    if not path.is_file():
        return None
    import trimesh

    loaded: Any = trimesh.load_mesh(str(path), process=False)
    return Mesh(np.asarray(loaded.vertices), np.asarray(loaded.faces, dtype=np.int64))
