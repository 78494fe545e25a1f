"""What cannot be: answers held against another reading of the same file."""

import math
import re
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import msgspec
import numpy as np

from topple.topology.scene.scene import Scene

LARGEST = 20.0  # [m] of one object: what is longer is in another unit
FARTHEST = 1e8  # [m]

_DECLARED = {
    ".pcd": re.compile(rb"^POINTS\s+(\d+)\s*$", re.MULTILINE),
    ".ply": re.compile(rb"^element vertex (\d+)\s*$", re.MULTILINE),
}


def wrong_scene(answer: object, path: Path) -> str | None:
    """Whether a scene cannot be: shapes, numbers, lengths, and numbers of points that the file declares.

    Args:
        answer: The scene.
        path: The file or folder it was read from.
    """
    if not isinstance(answer, Scene):
        return f"no scene: {type(answer).__name__}"
    for name, points in answer.clouds.items():
        if points.ndim != 2 or points.shape[1] != 3 or len(points) == 0:
            return f"cloud {name!r} has shape {points.shape}"
        if not np.isfinite(points).all() or np.abs(points).max() > FARTHEST:
            return f"cloud {name!r} is not finite"
        if np.ptp(points, axis=0).max() > 2 * LARGEST:  # a pose may turn its box
            return f"cloud {name!r} is {np.ptp(points, axis=0).max():g} m long"
    if answer.up is not None and not math.isclose(float(np.linalg.norm(answer.up)), 1.0, rel_tol=1e-6):
        return f"up is {answer.up}"
    if not np.isfinite(answer.viewpoints).all():
        return "a viewpoint is not finite"
    return wrong_numbers({**answer.masses, **answer.friction}) or _of_folder(answer, path)


def _of_folder(scene: Scene, path: Path) -> str | None:
    """Whether clouds of files with one declaration have another number of points than it says."""
    for file in sorted(path.iterdir()) if path.is_dir() else ():
        name, suffix = file.stem, file.suffix
        content = file.read_bytes()
        if name not in scene.clouds:
            continue
        counted: int | None = None
        if suffix in _DECLARED:
            declared = _DECLARED[suffix].findall(content)
            counted = int(declared[0]) if len(declared) == 1 else None
        elif suffix == ".xyz":
            text = content.decode("utf-8")
            counted = sum(bool(re.split("#", line)[0].strip(" ,;\t\r\x0b\x0c")) for line in text.splitlines())
        elif suffix == ".obj" and name not in scene.meshes:
            counted = len(re.findall(rb"^v\s", content, re.MULTILINE))
        mesh = scene.meshes.get(name)
        if suffix == ".stl" and mesh is not None and not content.lstrip().startswith(b"solid"):
            faces = int.from_bytes(content[80:84], "little")
            if faces != len(mesh.faces) and len(content) == 84 + 50 * faces:  # else it was read as text
                return f"{file.name} declares {faces} faces, and {len(mesh.faces)} came"
        if suffix == ".obj" and mesh is not None:  # of which vertices without a face are left out
            faces = sum(len(line.split()) - 3 for line in content.splitlines() if line.split()[:1] == [b"f"])
            if faces != len(mesh.faces):
                return f"{file.name} has {faces} triangles, and {len(mesh.faces)} came"
        given = len(scene.clouds[name]) if mesh is None else len(mesh.vertices)
        if counted is not None and counted != given:
            return f"{file.name} declares {counted} points, and {given} came"
    return None


def wrong_arrays(answer: object, path: Path) -> str | None:
    """Whether clouds are other numbers than numpy reads in the file.

    Args:
        answer: The scene.
        path: The archive.
    """
    said = wrong_scene(answer, path)
    if said is not None or not isinstance(answer, Scene):
        return said
    try:
        with np.load(path, allow_pickle=False) as archive:
            arrays = {name: archive[name] for name in archive.files if name in answer.clouds}
    except Exception as error:  # any of it says that topple read what numpy does not
        return f"numpy does not read it: {type(error).__name__}: {error}"
    for name, array in arrays.items():
        if array.shape != answer.clouds[name].shape or not np.array_equal(array, answer.clouds[name]):
            return f"cloud {name!r} has other points than the file"
    return None


def wrong_pixels(answer: object, path: Path) -> str | None:
    """Whether clouds have more points than there are pixels of their label or beside them.

    Args:
        answer: The scene.
        path: The frame.
    """
    said = wrong_scene(answer, path)
    if said is not None or not isinstance(answer, Scene):
        return said
    for image in answer.images:
        pixels = image.pixels()
        for name, points in answer.clouds.items():
            if name in pixels and len(points) > pixels[name] + np.count_nonzero(image.borders.owner):
                return f"{name!r} has {len(points)} points of {pixels[name]} pixels"
    return None


def wrong_numbers(answer: object, path: Path | None = None) -> str | None:
    """Whether a number somewhere in an answer is not finite.

    Args:
        answer: Arrays, structs, mappings and sequences of numbers and text, one in the other.
        path: Where it was read.
    """
    for where, value in _numbers(answer, ""):
        if not math.isfinite(value):
            return f"{value} at {where or 'the top'}"
    return None


def _numbers(value: object, where: str) -> Iterator[tuple[str, float]]:
    """All numbers, with where they are."""
    entry: Any = value
    if isinstance(entry, (bool, str, bytes)) or entry is None:
        return
    if isinstance(entry, (int, float)):
        yield where, float(entry)
    elif isinstance(entry, np.ndarray):
        yield where, float(np.sum(np.where(np.isfinite(entry), 0.0, entry)))
    elif isinstance(entry, msgspec.Struct):
        yield from _numbers(msgspec.structs.asdict(entry), where)
    elif isinstance(entry, Mapping):
        for key, one in entry.items():
            yield from _numbers(one, f"{where}.{key}")
    elif isinstance(entry, (list, tuple, set, frozenset)):
        for number, one in enumerate(entry):
            yield from _numbers(one, f"{where}[{number}]")
    elif hasattr(entry, "__dataclass_fields__"):
        for key in entry.__dataclass_fields__:
            yield from _numbers(getattr(entry, key), f"{where}.{key}")
