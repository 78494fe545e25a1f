"""One object's file: a cloud as it is, a mesh sampled over its surface."""

import logging
import re
from collections.abc import Callable
from io import BytesIO, TextIOWrapper
from pathlib import Path
from typing import Any, cast

import numpy as np

from topple.topology.base.arrays import FloatArray, IntArray
from topple.topology.base.checks import as_points
from topple.topology.base.errors import InvalidInput
from topple.topology.io.limits import check_place, read_bytes
from topple.topology.io.pcd import read_pcd
from topple.topology.io.text import TEXTS, read_points
from topple.topology.io.tolerances import MOST_PIECES, SAMPLE_SPACING

SUFFIXES = (".ply", ".pcd", *TEXTS, ".obj", ".stl", ".glb")

_CORNERS = re.compile(r"[fv]([^A-Za-z].*)?")
_WHOLE = re.compile(r"[-+]?[0-9]{1,18}")
_SOUND = re.compile(r"(?:v(?: [-+.0-9eE]{1,30}){3,7}|f(?: [1-9][0-9]{0,17}(?:/[0-9]*){0,2}){3,9}) ?\r?\n?")
"""Lines of an OBJ as programs write them: most of a large file, told at a glance."""
_ELEMENTS = re.compile(rb"^element\s+(\S+)\s+([-+]?\d+)\s*?\n((?:(?!element).*\n)*)", re.MULTILINE)
_SOLID = re.compile(rb"^[ \t]*(end)?[ \t]*solid\b[^\r\n]*", re.IGNORECASE | re.MULTILINE)
_KINDS = {
    1: b"char int8 uchar uint8",
    2: b"short int16 ushort uint16",
    4: b"int int32 uint uint32 float float32",
}
_BYTES = {kind: size for size, some in {**_KINDS, 8: b"double float64"}.items() for kind in some.split()}
"""Sizes of the numbers of a PLY."""
_FEWEST_SAMPLES, _MOST_SAMPLES = 2_000, 20_000

Geometry = tuple[FloatArray, IntArray | None, FloatArray]


def read_geometry(path: Path, what: str, unit: float = 1.0) -> Geometry:
    """Read one object.

    A mesh is sampled evenly over its surface, always the same way; its vertices are among the samples,
    so that its extent is exact.

    Args:
        path: A `.ply`, `.pcd`, `.obj`, `.stl` or `.glb` file, or a text: `.xyz`, `.txt`, `.csv`, `.pts`,
            `.asc`.
        what: What it is, for the message.
        unit: Length of the file's unit in [m].

    Returns:
        The cloud (N, 3) in [m] in the file's own frame, the mesh's faces (F, 3) or None for a cloud, and the
        mesh's vertices (V, 3); for a cloud its points again.

    Raises:
        InvalidInput: If the file is broken, empty, or not what its name says.
        OSError: If the file cannot be read.
    """
    check_place(path, what)
    if path.stat().st_size == 0:
        raise InvalidInput(f"{what} is an empty file: expected points or a mesh")
    suffix = path.suffix.lower()
    if suffix in (".pcd", *TEXTS):
        points = read_pcd(path, what) if suffix == ".pcd" else read_points(path, what)
        points = as_points(unit * points, what)
        return points, None, points
    vertices, faces = _read_with_trimesh(path, what)
    vertices = as_points(unit * vertices, what)
    if len(faces) == 0:
        return vertices, None, vertices
    return sampled_mesh(vertices, faces), faces, vertices


def as_read(path: Path, what: str) -> BytesIO:
    """Read a file for trimesh, without the parts it stumbles over and the names of other files.

    Raises:
        InvalidInput: If it is a PLY or STL that is cut short, or no file, or too large.
        OSError: If the file cannot be read.
    """
    plain, content = _PLAIN.get(path.suffix.lower()), read_bytes(path, what)
    return BytesIO(content if plain is None else plain(content, what))


def load_with_trimesh(path: Path, what: str, **options: Any) -> Any:
    """Load a file, which names no other one, with trimesh; its errors in one line.

    Args:
        path: The file.
        what: What it is, for the message.
        **options: Of `trimesh.load`.

    Raises:
        InvalidInput: If it cannot be read.
        OSError: If the file cannot be read.
    """
    import trimesh

    suffix = path.suffix.lower()
    source: Any = as_read(path, what)
    if suffix == ".obj":
        check_obj(source.getvalue(), what)
    log: logging.Logger = trimesh.util.log
    silent, log.disabled = log.disabled, True  # what it says of a broken file, a trace even, is said below
    try:
        loaded: Any = trimesh.load(source, suffix[1:], process=False, skip_materials=True, **options)
        if isinstance(loaded, trimesh.Scene) and "force" not in options:
            loaded = cast(Any, loaded).to_geometry()
            np.asarray(loaded.vertices)  # a scene of nothing has none
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
    return loaded


def _read_with_trimesh(path: Path, what: str) -> tuple[FloatArray, IntArray]:
    loaded = load_with_trimesh(path, what)
    vertices = np.asarray(loaded.vertices, dtype=np.float64)
    faces = np.asarray(getattr(loaded, "faces", np.empty((0, 3))), dtype=np.int64).reshape(-1, 3)
    if faces.size and (faces.min() < 0 or faces.max() >= len(vertices)):
        raise InvalidInput(
            f"{what} has a face naming vertex {faces.max()}, but only {len(vertices)} vertices"
        )
    return vertices, faces


def _plain_ply(content: bytes, what: str) -> bytes:
    """A PLY without elements that hold nothing, of which the reader stumbles; of a cloud its points alone.

    Raises:
        InvalidInput: If a text has other lines than it declares; in the binary kind trimesh notices.
    """
    end = re.search(rb"^end_header[ \t]*\r?\n", content, re.MULTILINE)
    if end is None:
        return content
    found = _ELEMENTS.findall(content[: end.start()])
    told = [(name, int(count), re.findall(rb"property.*\n", rest)) for name, count, rest in found]
    elements = [each for each in told if each[1] and each[2]]
    form = re.search(rb"^format.*", content, re.MULTILINE)
    text = form is not None and b"ascii" in form[0]
    rows, body = [], content[end.end() :]
    if text:
        rows = [row for row in body.splitlines() if row.strip()]
        if len(rows) != sum(count for _, count, _ in elements):
            said = " and ".join(f"{count} of {name.decode('ascii', 'replace')}" for name, count, _ in told)
            raise InvalidInput(f"{what} declares {said}, and has {len(rows)} lines of them: write it again")
    (name, count, properties), *others = elements or [(b"", 0, [])]
    sizes = [_BYTES.get(b"".join(line.split()[1:2]), 0) for line in properties]
    if name == b"vertex" and all(sizes) and b"face" not in (each[0] for each in others):
        elements, rows, body = elements[:1], rows[:count], body[: count * sum(sizes)]
    head = b"".join(b"element %s %d\n%s" % (name, n, b"".join(kept)) for name, n, kept in elements)
    form = b"" if form is None else form[0]
    return b"ply\n%s\n%send_header\n%s" % (form, head, b"\n".join(rows) if text else body)


def check_obj(content: bytes, what: str) -> None:
    """Refuse lines that readers pass over: vertices and faces cut short, and faces of vertex 0."""
    materials: set[str] = set()
    with TextIOWrapper(BytesIO(content), encoding="utf-8", errors="replace") as file:
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


def _plain_stl(content: bytes, what: str) -> bytes:
    """An STL text whose first and last lines say no more than that, in words that the reader knows.

    Raises:
        InvalidInput: If it has no last line, or more solids than an object has.
    """
    if not content.lstrip()[:5].lower() == b"solid" or b"\0" in content:
        return content
    content = _SOLID.sub(lambda line: (line[1] or b"") + b"solid", content)
    count = content.lower().count(b"endsolid")
    _check_pieces(count, what, "solids")
    if not count and b"vertex" in content.lower():
        raise InvalidInput(
            f"{what} is an STL text without the line 'endsolid': it is cut short, write it again"
        )
    return content


def _check_pieces(count: int, what: str, of: str) -> None:
    if count > MOST_PIECES:
        raise InvalidInput(f"{what} has more than {MOST_PIECES} {of}: expected those of one object")


_PLAIN: dict[str, Callable[[bytes, str], bytes]] = {".ply": _plain_ply, ".stl": _plain_stl}


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
