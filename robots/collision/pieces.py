"""Concave surfaces cut into a few convex pieces which together hold all that the surface encloses.

A surface is cut by planes across two axes at most, and each piece is the hull of the surface between its
planes. What a solid has between such planes is in that hull: its outermost points there lie on the surface,
or where the surface meets a plane or the line of two planes. (A third axis would give the cells corners,
which can lie deep inside the solid, where there is no surface.)
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from topple.robots.collision.convex import hull_of
from topple.robots.collision.tolerances import GAIN, IN_PLANE, MOST, PLACES, SAMPLE
from topple.topology.base.arrays import FloatArray
from topple.topology.geometry.sides import hull_volume


@dataclass(frozen=True, eq=False)
class _Piece:
    """Part of a surface between planes across some axes."""

    triangles: FloatArray
    axes: frozenset[int]

    @cached_property
    def volume(self) -> float:
        return _volume(self.triangles)

    @cached_property
    def cut(self) -> tuple[float, int, float]:
        """The volume saved by the best cut, its axis, and where it is on that axis."""
        sample = self.triangles[:: max(1, len(self.triangles) // SAMPLE)]
        best, whole = (0.0, 0, 0.0), _volume(sample)
        for axis in range(3) if len(self.axes) < 2 else self.axes:
            values = np.unique(np.round(sample[:, :, axis], 5))
            wanted = np.linspace(values[0], values[-1], PLACES + 2)[1:-1]
            nearest = values[np.abs(values[:, None] - wanted).argmin(axis=0)]
            for at in np.unique(nearest[(nearest > values[0]) & (nearest < values[-1])]).tolist():
                saved = whole - sum(_volume(_beyond(sample, axis, at, side)) for side in (-1.0, 1.0))
                best = max(best, (saved, axis, at))
        return best

    def parts(self) -> list["_Piece"]:
        """Split the piece by its best cut."""
        _, axis, at = self.cut
        return [_Piece(_beyond(self.triangles, axis, at, side), self.axes | {axis}) for side in (-1.0, 1.0)]


def convex_pieces(triangles: FloatArray, gain: float = GAIN) -> list[FloatArray]:
    """Cut a surface into convex pieces as long as a cut saves much of the hull's volume.

    Args:
        triangles: (T, 3, 3) corners of its triangles in [m].
        gain: Share of the whole volume that a cut has to save.

    Returns:
        The (V, 3) hull vertices of each piece in [m]; one piece where the surface is nearly convex.
    """
    pieces = [_Piece(triangles, frozenset())]
    least = gain * pieces[0].volume
    while len(pieces) < MOST:
        worst = max(range(len(pieces)), key=lambda k: pieces[k].cut[0])
        if pieces[worst].cut[0] <= least:
            break
        pieces += pieces.pop(worst).parts()
    return [hull_of(piece.triangles.reshape(-1, 3))[0] for piece in pieces]


def _volume(triangles: FloatArray) -> float:
    """Of the hull in [m3]; 0 of what is flat."""
    points = triangles.reshape(-1, 3)
    return hull_volume(points)


def _beyond(triangles: FloatArray, axis: int, at: float, side: float) -> FloatArray:
    """Clip (T, 3, 3) triangles to one side of a plane across an axis; those in the plane are left out."""
    depth = side * (triangles[:, :, axis] - at)
    beyond = depth.max(axis=1) > IN_PLANE
    triangles, depth = triangles[beyond], depth[beyond]
    count = (depth >= 0.0).sum(axis=1)
    found = [triangles[count == 3]]
    for corners in (1, 2):
        some, deep = triangles[count == corners], depth[count == corners]
        odd = ((deep >= 0.0) == (corners == 1)).argmax(axis=1)  # the corner alone on its side comes first
        turned = (odd[:, None] + np.arange(3)) % 3
        a, b, c = np.take_along_axis(some, turned[:, :, None], axis=1).transpose(1, 0, 2)
        da, db, dc = np.take_along_axis(deep, turned, axis=1).T[:, :, None]
        ab, ac = a + da / (da - db) * (b - a), a + da / (da - dc) * (c - a)
        corner, rest = [a, ab, ac], [[ab, b, c], [ab, c, ac]]
        found += [np.stack(face, axis=1) for face in ([corner] if corners == 1 else rest)]
    return np.concatenate(found)
