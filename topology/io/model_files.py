"""A folder of known models: which file is the model of an object, told by their names."""

import re
from collections.abc import Collection
from pathlib import Path

import numpy as np

from topple.topology.base.arrays import lengths
from topple.topology.base.errors import InvalidInput
from topple.topology.base.tolerances import LARGEST_HELD, NEIGHBOURS
from topple.topology.bodies.model_registration import Model
from topple.topology.io.geometry import SUFFIXES, Geometry, read_geometry, spread_over
from topple.topology.io.text import TEXTS
from topple.topology.kernels.neighbours import PointTree
from topple.topology.kernels.planes import patch_planes

_MESHES = ("mesh", "textured", "nontextured", "textured_simple", "model")
"""What the mesh in a model's own folder, or one below it as YCB's google_16k, is called, the best first."""
_FIRST, _LAST = re.compile(r"^[0-9]+(-[a-z])?_"), re.compile(r"_[0-9]+$")
_BOP = re.compile(r"obj_[0-9]{6}")


def model_files(folder: Path) -> dict[str, Path]:
    """Find the models of a folder: NAME.obj, .stl, .ply, .glb, .pcd or .xyz, or a folder NAME with a mesh.

    Args:
        folder: The folder, such as the YCB set or the models of a BOP dataset.

    Returns:
        Name of each model -> its file. Of several meshes in a model's folder the one called mesh, textured
        or as the folder counts.

    Raises:
        InvalidInput: It is no folder, or has no models.
        OSError: It cannot be read.
    """
    if not folder.is_dir():
        raise InvalidInput(f"models: {folder} is no folder: expected one with NAME.obj or NAME/mesh.obj")
    found = {place.name: file for place in sorted(folder.iterdir()) if (file := _mesh_below(place))}
    found |= {place.stem: place for place in sorted(folder.iterdir()) if _is_mesh(place)}
    if not found:
        raise InvalidInput(
            f"models: {folder} has no models: expected NAME.obj or NAME/mesh.obj, .stl or .ply"
        )
    return found


def meant_by(name: str, models: Collection[str]) -> list[str]:
    """The models that the name of an object may mean: as it is, or but for numbers before and behind it.

    Args:
        name: Of the object, such as banana, banana_2 or 011_banana.
        models: Names of the models, such as 011_banana.

    Returns:
        The model of the same name, else those that share what is left of it without its numbers; or none.
    """
    readings = (name.lower(), _LAST.sub("", name.lower()))
    for reading in readings:
        if same := [model for model in models if model.lower() == reading]:
            return same
    for reading in readings:
        if alike := [model for model in models if _FIRST.sub("", model.lower()) == _FIRST.sub("", reading)]:
            return alike
    return []


def read_model(name: str, file: Path) -> tuple[Model, Geometry]:
    """Read a model.

    Args:
        name: Its name.
        file: A mesh or a cloud, in [m]; in [mm] where it is called as those of BOP, obj_000005.

    Returns:
        The model, and the file as `read_geometry` reads it.

    Raises:
        InvalidInput: It is broken, or too large for metres.
        OSError: It cannot be read.
    """
    unit = 1e-3 if _BOP.fullmatch(file.stem) else 1.0  # [m]
    points, faces, vertices = geometry = read_geometry(file, f"model {name!r} ({file.name})", unit)
    if (longest := float(np.ptp(vertices, axis=0).max())) > LARGEST_HELD:
        raise InvalidInput(
            f"model {name!r} ({file.name}) is {longest:.4g} m long, more than {LARGEST_HELD:g} m: expected "
            "metres, so scale it (millimetres: * 0.001)"
        )
    if faces is None:
        patches = points[PointTree(points).query(points, k=min(NEIGHBOURS, len(points)))[1]]
        return Model(name, points, patch_planes(patches)[1]), geometry
    spread, on = spread_over(vertices, faces)
    first, second, third = (vertices[faces[on, corner]] for corner in range(3))
    square = np.cross(second - first, third - first)
    return Model(name, spread, square / lengths(square)[:, None]), geometry


def _is_mesh(place: Path) -> bool:
    return place.suffix.lower() in SUFFIXES and place.suffix.lower() not in TEXTS[1:] and place.is_file()


def _mesh_below(place: Path) -> Path | None:
    """The mesh of a model that has a folder of its own; None where there is none, or nothing tells which."""
    if not place.is_dir():
        return None
    files = [file for depth in ("*", "*/*") for file in sorted(place.glob(depth)) if _is_mesh(file)]
    names = (*_MESHES, place.name)
    known = sorted((names.index(file.stem), k) for k, file in enumerate(files) if file.stem in names)
    return files[known[0][1]] if known else files[0] if len(files) == 1 else None
