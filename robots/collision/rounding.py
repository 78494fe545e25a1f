"""Convex parts as Bullet wants them: cores that its collision margin inflates back to the true surface.

Bullet finds contacts fast and with steady normals while only the margins overlap, and slowly, with normals
that jump between the faces of thin parts, once the cores do. So every outer face of a body moves inwards by a
margin and Bullet moves it out again: faces stay where they are, outer edges are rounded by that radius. Faces
between two parts of one body do not move: nothing touches them, and a wall of many parts stays smooth.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from scipy.optimize import linprog
from scipy.spatial import ConvexHull, HalfspaceIntersection, QhullError

from topple.robots.tolerances import TOLERANCES
from topple.topology.base.arrays import BoolArray, FloatArray, freeze
from topple.topology.geometry.sides import beyond, sides_of

REMEMBERED = 256  # bodies: some kilobytes each


@dataclass(frozen=True, eq=False)
class Core:
    """What the margin is put around.

    Attributes:
        parts: Vertices (V, 3) of each part's core in [m].
        margin: In [m].
    """

    parts: tuple[FloatArray, ...]
    margin: float


def cores(parts: Sequence[FloatArray]) -> Core:
    """Shrink the outer faces of a body's parts by a margin.

    The last `REMEMBERED` bodies are kept: planning puts the same ones into one world after the other.

    Args:
        parts: Vertices (V, 3) in [m] of convex parts with a volume.

    Returns:
        The cores, and the margin: `TOLERANCES.margin`, or less where a part is thin.
    """
    return _cores(tuple(np.asarray(part, dtype=np.float64).tobytes() for part in parts))


@lru_cache(maxsize=REMEMBERED)
def _cores(known: tuple[bytes, ...]) -> Core:
    """The cores of parts given by the bytes of their vertices."""
    parts = [np.frombuffer(part).reshape(-1, 3) for part in known]
    planes = [_planes(part) for part in parts]
    thinnest = min(float(_widths(part, plane).min()) for part, plane in zip(parts, planes, strict=True))
    margin = min(TOLERANCES.margin, TOLERANCES.margin_share * thinnest)
    outer = _outer(parts, planes)
    while margin > 1e-6:
        try:
            shrunk = [
                _shrunk(part, plane, np.where(faces, margin, 0.0))
                for part, plane, faces in zip(parts, planes, outer, strict=True)
            ]
            return Core(tuple(freeze(part) for part in shrunk), margin)
        except QhullError:  # a part too thin in a direction that none of its faces shows
            margin /= 2
    return Core(tuple(parts), 0.0)


def _planes(part: FloatArray) -> FloatArray:
    """(F, 4) distinct facet planes n.x + d <= 0 of a convex part."""
    sides = sides_of(part)
    assert sides is not None, "parts have a volume"
    _, first = np.unique(np.round(sides, 6), axis=0, return_index=True)
    return sides[np.sort(first)]


def _widths(part: FloatArray, planes: FloatArray) -> FloatArray:
    """(F,) extent of a part across each of its planes."""
    return np.ptp(part @ planes[:, :3].T, axis=0)


def _outer(parts: Sequence[FloatArray], planes: Sequence[FloatArray]) -> list[BoolArray]:
    """Which planes of each part are not covered by other parts of the body.

    A plane is covered where a point just outside it, in the middle of its corners, is in another part.
    """
    flags: list[BoolArray] = []
    for own, (part, plane) in enumerate(zip(parts, planes, strict=True)):
        inside = np.abs(part @ plane[:, :3].T + plane[:, 3]) < 1e-6
        count = np.maximum(inside.sum(axis=0), 1)
        middle = (inside.T @ part) / count[:, None] + plane[:, :3] * TOLERANCES.seam
        covered = np.zeros(len(plane), dtype=bool)
        for other, walls in enumerate(planes):
            if other != own:
                covered |= beyond(walls, middle) < TOLERANCES.seam / 2
        flags.append(~covered)
    return flags


def _shrunk(part: FloatArray, planes: FloatArray, inwards: FloatArray) -> FloatArray:
    """Vertices of a part after its planes have moved."""
    moved = planes.copy()
    moved[:, 3] += inwards
    inside = part.mean(axis=0)
    if (moved[:, :3] @ inside + moved[:, 3]).max() > -1e-7:
        inside = _deepest(moved)
    corners = HalfspaceIntersection(moved, inside).intersections
    corners = corners[np.isfinite(corners).all(axis=1)]
    return corners[ConvexHull(corners).vertices]


def _deepest(planes: FloatArray) -> FloatArray:
    """The point farthest from all planes; raises QhullError where they leave no room."""
    rows = np.c_[planes[:, :3], np.ones(len(planes))]
    found = linprog([0, 0, 0, -1], A_ub=rows, b_ub=-planes[:, 3], bounds=[(None, None)] * 3 + [(0, None)])
    if not found.success or found.x[3] < 1e-7:
        raise QhullError("no room between the planes")
    return found.x[:3]
