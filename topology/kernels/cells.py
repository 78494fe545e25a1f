"""Points sorted into the cubic cells of a grid."""

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from topple.topology.kernels.compiled import address, kernels

if TYPE_CHECKING:
    from topple.topology.base.arrays import BoolArray, FloatArray, IntArray


@dataclass(frozen=True, eq=False)
class Cells:
    """Which points lie in one cell of a grid.

    Attributes:
        points: (N, 3) points [m].
        order: (N,) rows of the points, cell after cell and rising in each.
        starts: (C + 1,) places in `order` at which the cells begin, and the end of the last one.
    """

    points: "FloatArray"
    order: "IntArray"
    starts: "IntArray"

    @property
    def sizes(self) -> "IntArray":
        """(C,) number of points of each cell."""
        return np.diff(self.starts)

    def means(self) -> "FloatArray":
        """(C, 3) mean point of each cell [m], the same to the last bit by kernel and twin."""
        compiled = kernels()
        if compiled is None:
            sizes = self.sizes
            cell, ordered = np.repeat(np.arange(len(sizes)), sizes), self.points[self.order]
            sums = [np.bincount(cell, weights=ordered[:, k]) for k in range(3)]
            return np.stack(sums, axis=1) / sizes[:, None]
        given = np.ascontiguousarray(self.points, dtype=np.float64)
        found = np.empty((len(self.starts) - 1, 3))
        compiled.cells_means(
            address(given), address(self.order), address(self.starts), len(found), address(found)
        )
        return found


def turned_bounds(points: "FloatArray", turn: "FloatArray | None" = None) -> "tuple[FloatArray, FloatArray]":
    """Least and greatest coordinates, (3,) each [m], of points (N, 3) along axes, the rows of `turn` (3, 3).

    N >= 1. They count from the first point, which turns with the others; along the frame's where None.
    """
    compiled = kernels()
    if compiled is None:
        local = points if turn is None else (points - points[0]) @ turn.T
        return local.min(axis=0), local.max(axis=0)
    given, found = np.ascontiguousarray(points, dtype=np.float64), np.empty((2, 3))
    axes = None if turn is None else np.ascontiguousarray(turn)
    compiled.cells_bounds(address(given), len(given), None if axes is None else address(axes), address(found))
    return found[0], found[1]


def within_reach(points: "FloatArray", place: "FloatArray", reach: float) -> "BoolArray":
    """Tell which points (N, 3) are at most so far from a place (3,) [m]: (N,)."""
    compiled = kernels()
    if compiled is None:
        away = points - place
        return np.einsum("ni,ni->n", away, away) <= reach**2
    given, found = np.ascontiguousarray(points, dtype=np.float64), np.empty(len(points), dtype=np.bool_)
    at = np.ascontiguousarray(place)
    compiled.cells_within(address(given), len(given), address(at), reach**2, address(found))
    return found


def cells_of(
    points: "FloatArray",
    lower: "FloatArray",
    upper: "FloatArray",
    edge: float,
    turn: "FloatArray | None" = None,
) -> Cells:
    """Sort points into cells.

    Args:
        points: (N, 3) points [m], finite, N >= 1.
        lower: (3,) where the grid begins [m], at or before the least coordinates of the points.
        upper: (3,) greatest coordinates of the points [m].
        edge: Edge of the cells [m], > 0.
        turn: (3, 3) axes of the grid, its rows; points, `lower` and `upper` then count along them from the
            first point. Along those of the frame where None.
    """
    along = ((upper - lower) * (1.0 / edge)).astype(np.int64) + 1
    compiled = kernels()
    if compiled is None:
        local = points if turn is None else (points - points[0]) @ turn.T
        x, y, z = ((local - lower) * (1.0 / edge)).astype(np.int64).T
        keys = (x * along[1] + y) * along[2] + z
        order = np.argsort(keys, kind="stable")
        ordered = keys[order]
        new = np.concatenate([[True], ordered[1:] != ordered[:-1], [True]])
        return Cells(points, order, np.flatnonzero(new))
    given, first = np.ascontiguousarray(points, dtype=np.float64), np.ascontiguousarray(lower)
    order, starts = np.empty(len(given), dtype=np.int64), np.empty(len(given) + 1, dtype=np.int64)
    axes = None if turn is None else np.ascontiguousarray(turn)
    cells = compiled.cells_sort(
        address(given), len(given), None if axes is None else address(axes), address(first), address(along),
        edge, address(order), address(starts),
    )  # fmt: skip
    return Cells(points, order, starts[: cells + 1])
