"""One object's file: a cloud as it is, a mesh sampled over its surface."""

import logging
import re
from collections.abc import Callable
from io import StringIO
from pathlib import Path
from typing import Any, cast

import numpy as np

from topple.topology.arrays import FloatArray, IntArray
from topple.topology.checks import as_points
from topple.topology.errors import InvalidInput
from topple.topology.io.limits import check_size
from topple.topology.io.pcd import read_pcd
from topple.topology.io.tolerances import MOST_PIECES, SAMPLE_SPACING

SUFFIXES = (".ply", ".pcd", ".xyz", ".txt", ".obj", ".stl", ".glb")

_CORNERS = re.compile(r"[fv]([^A-Za-z].*)?")
_WHOLE = re.compile(r"[-+]?[0-9]{1,18}")
_SOUND = re.compile(r"(?:v(?: [-+.0-9eE]{1,30}){3,7}|f(?: [1-9][0-9]{0,17}(?:/[0-9]*){0,2}){3,9}) ?\r?\n?")
"""Lines of an OBJ as programs write them: most of a large file, told at a glance."""
_FEWEST_SAMPLES, _MOST_SAMPLES = 2_000, 20_000

Geometry = tuple[FloatArray, IntArray | None, FloatArray]


def read_geometry(path: Path, what: str, unit: float = 1.0) -> Geometry:
    """Read one object.

    A mesh is sampled evenly over its surface, always the same way; its vertices are among the samples,
    so that its extent is exact.

    Args:
        path: A `.ply`, `.pcd`, `.xyz`, `.txt` (read as `.xyz`), `.obj`, `.stl` or `.glb` file.
        what: What it is, for the message.
        unit: Length of the file's unit in [m].

    Returns:
        The cloud (N, 3) in [m] in the file's own frame, the mesh's faces (F, 3) or None for a cloud, and the
        mesh's vertices (V, 3); for a cloud its points again.

    Raises:
        InvalidInput: If the file is broken, empty, or not what its name says.
        OSError: If the file cannot be read.
    """
    if path.stat().st_size == 0:
        raise InvalidInput(f"{what} is an empty file: expected points or a mesh")
    suffix = path.suffix.lower()
    if suffix in (".pcd", ".xyz", ".txt"):
        points = read_pcd(path, what) if suffix == ".pcd" else _read_xyz(path, what)
        points = as_points(unit * points, what)
        return points, None, points
    vertices, faces = _read_with_trimesh(path, what)
    vertices = as_points(unit * vertices, what)
    if len(faces) == 0:
        return vertices, None, vertices
    return sampled_mesh(vertices, faces), faces, vertices


def is_cloud_text(path: Path) -> bool:
    """Tell a `.txt` that holds a cloud from notes: its first line with anything in it begins with x y z."""
    with path.open(encoding="utf-8-sig", errors="replace") as file:
        for line in file:
            if values := _columns(line):
                try:
                    return len([float(value) for value in values[:3]]) == 3
                except ValueError:
                    return False
    return False


def _columns(line: str) -> list[str]:
    """The words of a line, apart by blanks, commas or semicolons, without its comment."""
    return line.split("#", 1)[0].replace(",", " ").replace(";", " ").split()


def _read_xyz(path: Path, what: str) -> FloatArray:
    """Read x y z from the first three columns, apart by blanks, commas or semicolons; # starts a comment."""
    try:
        text = path.read_text(encoding="utf-8-sig")
    except UnicodeDecodeError as error:
        raise InvalidInput(f"{what} is no text: expected one point x y z per line") from error
    lines = text.splitlines()
    try:
        if any(map(_columns, lines)):  # without any row the reader warns
            plain = "\n".join(lines).replace(",", " ").replace(";", " ")
            return np.loadtxt(StringIO(plain), dtype=np.float64, usecols=(0, 1, 2), ndmin=2)
    except ValueError:
        pass  # the line is looked for below, and what Python alone reads is read there
    rows: list[list[float]] = []
    for number, line in enumerate(lines, start=1):
        values = _columns(line)
        if not values:
            continue
        try:
            x, y, z = (float(value) for value in values[:3])
        except ValueError as error:
            raise InvalidInput(
                f"{what} reads {line.strip()[:40]!r} in line {number}: expected x y z"
            ) from error
        rows.append([x, y, z])
    return np.array(rows, dtype=np.float64)


def _read_with_trimesh(path: Path, what: str) -> tuple[FloatArray, IntArray]:
    import trimesh

    check_size(path.stat().st_size, what)
    if path.suffix.lower() in _DECLARED:
        _DECLARED[path.suffix.lower()](path, what)
    log: logging.Logger = trimesh.util.log
    silent, log.disabled = log.disabled, True  # what it says of a broken file, a trace even, is said below
    try:
        loaded: Any = trimesh.load(path, process=False)
        if isinstance(loaded, trimesh.Scene):
            loaded = cast(Any, loaded).to_geometry()
        vertices = np.asarray(loaded.vertices, dtype=np.float64)
        faces = np.asarray(getattr(loaded, "faces", np.empty((0, 3))), dtype=np.int64).reshape(-1, 3)
    except OSError:
        raise
    except ImportError as error:  # trimesh guesses the encoding of what is neither kind of STL
        raise InvalidInput(
            f"{what} is no readable {path.suffix[1:].upper()} file: it is cut short, or another kind of file"
        ) from error
    except Exception as error:  # each of trimesh's readers fails on a broken file in its own way
        reason = " ".join(str(error).split())[:120] or type(error).__name__
        raise InvalidInput(f"{what} is no readable {path.suffix[1:].upper()} file: {reason}") from error
    finally:
        log.disabled = silent
    if faces.size and (faces.min() < 0 or faces.max() >= len(vertices)):
        raise InvalidInput(
            f"{what} has a face naming vertex {faces.max()}, but only {len(vertices)} vertices"
        )
    return vertices, faces


def _check_ply(path: Path, what: str) -> None:
    """Refuse a PLY text that has other lines than it declares; in the binary kind trimesh notices."""
    counts: dict[str, int] = {}
    with path.open("rb") as file:
        for line in file:
            words = line.split()
            if words[:1] == [b"format"] and words[1:2] != [b"ascii"]:
                return
            if words[:1] == [b"element"] and len(words) == 3 and words[2].isdigit():
                counts[words[1].decode("ascii", "replace")] = int(words[2])
            if words == [b"end_header"]:
                break
        lines = sum(bool(line.strip()) for line in file)
    if lines != sum(counts.values()):
        said = " and ".join(f"{count} of {name}" for name, count in counts.items())
        raise InvalidInput(f"{what} declares {said}, and has {lines} lines of them: write it again")


def _check_obj(path: Path, what: str) -> None:
    """Refuse lines that readers pass over: vertices and faces cut short, and faces of vertex 0."""
    materials: set[str] = set()
    with path.open(encoding="utf-8", errors="replace") as file:
        for number, line in enumerate(file, start=1):
            if _SOUND.fullmatch(line):
                continue
            if "usemtl" in line:  # where the reader begins another piece, in a comment too
                materials.add(line)
                _check_pieces(len(materials), what, "materials")
            words = line.split("#", 1)[0].split()
            if not words or not _CORNERS.fullmatch(words[0]):
                continue
            if len(words[0]) > 1 or line[0].isspace():  # passed over by the reader, or taken for two words
                raise InvalidInput(
                    f"{what} reads {line.rstrip()[:40]!r} in line {number}: v or f alone begins a line"
                )
            corners = [word.split("/")[0] for word in words[1:]]
            if len(corners) < 3 or (words[0] == "f" and not all(_WHOLE.fullmatch(word) for word in corners)):
                raise InvalidInput(
                    f"{what} reads {line.strip()[:40]!r} in line {number}: expected three numbers or more"
                )
            if words[0] == "f" and any(int(word) == 0 for word in corners):  # taken for the last one
                raise InvalidInput(f"{what} names vertex 0 in line {number}: expected counts from 1")


def _check_stl(path: Path, what: str) -> None:
    """Refuse an STL text of more solids than an object has."""
    _check_pieces(path.read_bytes().lower().count(b"endsolid"), what, "solids")


def _check_pieces(count: int, what: str, of: str) -> None:
    if count > MOST_PIECES:
        raise InvalidInput(f"{what} has more than {MOST_PIECES} {of}: expected those of one object")


_DECLARED: dict[str, Callable[[Path, str], None]] = {
    ".ply": _check_ply,
    ".obj": _check_obj,
    ".stl": _check_stl,
}


def sampled_mesh(vertices: FloatArray, faces: IntArray) -> FloatArray:
    """Points (N, 3) spread evenly over a mesh, always the same, its corners among them [m]."""
    return np.concatenate([vertices[np.unique(faces)], spread_over(vertices, faces)[0]])


def spread_over(vertices: FloatArray, faces: IntArray) -> tuple[FloatArray, IntArray]:
    """Points (N, 3) spread evenly over a mesh [m], always the same, and (N,) the faces that they lie on."""
    first, second, third = (vertices[faces[:, corner]] for corner in range(3))
    areas = np.linalg.norm(np.cross(second - first, third - first), axis=1) / 2
    area = float(areas.sum())
    if area <= 0.0:
        return vertices[:0], np.empty(0, dtype=np.int64)
    count = int(np.clip(area / SAMPLE_SPACING**2, _FEWEST_SAMPLES, _MOST_SAMPLES))
    # Systematic draws along the cumulated area: as many on each face as its area asks for, within one.
    rng = np.random.default_rng(0)
    chosen = np.searchsorted(np.cumsum(areas), (np.arange(count) + rng.random()) / count * area)
    chosen = np.minimum(chosen, len(faces) - 1)
    u, v = rng.random((2, count, 1))
    flipped = u + v > 1
    u, v = np.where(flipped, 1 - u, u), np.where(flipped, 1 - v, v)
    return first[chosen] + u * (second - first)[chosen] + v * (third - first)[chosen], chosen
