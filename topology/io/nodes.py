"""Scenes as one GLB or OBJ file, a node or group an object: what modelling programs and generators write."""

from collections.abc import Callable
from itertools import pairwise
from pathlib import Path
from typing import Any, TypeVar

import numpy as np

from topple.topology.base.arrays import FloatArray, IntArray
from topple.topology.base.checks import as_name, as_points
from topple.topology.base.errors import InvalidInput
from topple.topology.geometry.rigid import move_points
from topple.topology.io.assemble import Parts
from topple.topology.io.geometry import as_read, check_obj, load_with_trimesh, sampled_mesh
from topple.topology.io.tolerances import MOST_PIECES
from topple.topology.scene.mesh import Mesh

_SUFFIXES = (".glb", ".obj")
_Piece = tuple[FloatArray, IntArray]
_Number = TypeVar("_Number", int, float)


def reads(path: Path) -> bool:
    """Whether it is called as one."""
    return path.suffix.lower() in _SUFFIXES and path.is_file()


def read(path: Path) -> Parts:
    """Read the objects of a scene file, in [m].

    Args:
        path: A `.glb`, whose y axis is up, as glTF has it; or an `.obj`, which does not say where up is.

    Returns:
        A mesh for every object: of a GLB each child of the root, or of the first node below it that has more
        than one child or a mesh, with all that is below it at its poses; of an OBJ each object or group.

    Raises:
        InvalidInput: It cannot be read, or holds no mesh.
        OSError: The file cannot be read.
    """
    glb = path.suffix.lower() == ".glb"
    found = _nodes(path) if glb else _groups(path)
    if not found:
        raise InvalidInput("it holds no mesh: expected a node or group of triangles an object")
    meshes = {as_name(name): _join(name, pieces) for name, pieces in found.items()}
    return Parts(
        {name: sampled_mesh(mesh.vertices, mesh.faces) for name, mesh in meshes.items()},
        up=np.array([0.0, 1.0, 0.0]) if glb else None,
        meshes=meshes,
        notes=["y is up, as glTF has it"] if glb else [],
    )


def _nodes(path: Path) -> dict[str, list[_Piece]]:
    """The meshes of each object of a GLB, in the file's frame."""
    graph = load_with_trimesh(path, path.name, force="scene")
    if len(graph.graph.nodes_geometry) > MOST_PIECES:
        raise InvalidInput(f"it has more than {MOST_PIECES} meshes: expected those of one scene")
    found: dict[str, list[_Piece]] = {}
    owners = _owners(graph)
    for node in graph.graph.nodes_geometry:
        pose, geometry = graph.graph.get(node)
        faces = np.asarray(getattr(graph.geometry[geometry], "faces", ()), dtype=np.int64)
        if len(faces):
            corners = np.asarray(graph.geometry[geometry].vertices, dtype=np.float64)
            placed = move_points(corners, np.asarray(pose, dtype=np.float64))  # scales, too
            found.setdefault(owners[node], []).append((placed, faces.reshape(-1, 3)))
    return found


def _groups(path: Path) -> dict[str, list[_Piece]]:
    """The triangles of each object of an OBJ, of each group where it names no objects."""
    text = as_read(path, path.name).getvalue()
    check_obj(text, path.name)
    lines = [line.split("#", 1)[0].split() for line in text.decode("utf-8", "replace").splitlines()]
    divides = "o" if any(words[:1] == ["o"] for words in lines) else "g"
    corners: list[list[float]] = []
    faces: dict[str, list[tuple[int, int, int]]] = {}
    name = path.stem
    for number, words in enumerate(lines, start=1):
        if words[:1] == ["v"]:
            corners.append(_numbers(words[1:4], float, number, "three numbers"))
        elif words[:1] == [divides]:
            name = "_".join(words[1:]) or f"{path.stem}_{number}"
        elif words[:1] == ["f"]:
            ways = [word.split("/")[0] for word in words[1:]]
            around = _numbers(ways, int, number, "at least three numbers of vertices")
            around = [k - 1 if k > 0 else len(corners) + k for k in around]
            if not all(0 <= k < len(corners) for k in around):
                raise InvalidInput(f"line {number} names a vertex that is not there: it has {len(corners)}")
            faces.setdefault(name, []).extend((around[0], *pair) for pair in pairwise(around[1:]))
    points = np.array(corners, dtype=np.float64).reshape(-1, 3)
    return {name: [_own_corners(points, np.array(some))] for name, some in faces.items()}


def _numbers(words: list[str], kind: Callable[[str], _Number], line: int, expected: str) -> list[_Number]:
    """The numbers of a vertex or a face."""
    try:
        found = [kind(word) for word in words]
    except ValueError:
        found = []
    if len(found) < 3:
        raise InvalidInput(f"line {line} has {' '.join(words)[:40]!r}: expected {expected}")
    return found


def _own_corners(points: FloatArray, faces: IntArray) -> _Piece:
    """Triangles with their own corners alone."""
    kept, renamed = np.unique(faces, return_inverse=True)
    return points[kept], renamed.reshape(-1, 3)


def _owners(graph: Any) -> dict[str, str]:
    """Node -> the object that it is part of."""
    children: dict[str, list[str]] = {}
    for parent, child in graph.graph.transforms.edge_data:
        children.setdefault(parent, []).append(child)
    solid, root = set(graph.graph.nodes_geometry), graph.graph.base_frame
    passed: set[str] = set()
    while root not in solid | passed and len(below := children.get(root, [])) == 1 and below[0] not in solid:
        passed.add(root)  # nodes may go round in circles
        root = below[0]
    found: dict[str, str] = dict.fromkeys(solid, root)
    for top in children.get(root, []):
        border, seen = [top], {top}
        while border:
            node = border.pop()
            found[node] = top
            more = set(children.get(node, [])) - seen
            seen |= more
            border += more
    return found


def _join(name: str, pieces: list[_Piece]) -> Mesh:
    starts = np.cumsum([0, *(len(corners) for corners, _ in pieces)])
    corners = as_points(np.concatenate([corners for corners, _ in pieces]), f"object {name!r}")
    faces = [part + start for (_, part), start in zip(pieces, starts, strict=False)]
    return Mesh(corners, np.concatenate(faces))
