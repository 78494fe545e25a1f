"""Clouds thinned to one point per voxel: the first that lies in it, or the mean of all that do."""

import numpy as np

from topple.topology.base.arguments import checked_arguments
from topple.topology.base.arrays import FloatArray, IntArray, bounds
from topple.topology.base.errors import InvalidInput
from topple.topology.geometry.tolerances import BEFORE, ENOUGH, MANY
from topple.topology.kernels.cells import cells_of
from topple.topology.kernels.neighbours import PointTree


def cell_keys(
    points: FloatArray, lower: FloatArray, upper: FloatArray, edge: float, ahead: float = BEFORE
) -> IntArray:
    """Number of the cubic cell each point lies in.

    Args:
        points: (N, d) points [m], d = 2 or 3.
        lower: (d,) least coordinates of any point [m].
        upper: (d,) greatest coordinates of any point [m].
        edge: Edge of the cells [m], > 0.
        ahead: How far before `lower` the cells begin [m].

    Returns:
        (N,) numbers; they rise along the last axis first.
    """
    first = lower - ahead
    cells = ((points - first) / edge).astype(np.int64)
    counts = ((upper - first) / edge).astype(np.int64) + 1
    keys = cells[:, 0]
    for axis in range(1, points.shape[1]):
        keys = keys * counts[axis] + cells[:, axis]
    return keys


@checked_arguments
def thinned(points: FloatArray, spacing: float) -> FloatArray:
    """Keep one point per cubic cell, the one that comes first.

    Args:
        points: (N, 3) points [m].
        spacing: Edge of the cells [m], > 0.

    Returns:
        (M, 3) points of the cloud, M <= N, at most `spacing` * √3 from every dropped one.

    Raises:
        InvalidInput: They are no finite points, or there is no spacing.

    Examples:
        >>> len(thinned(np.random.default_rng(0).random((999, 3)), 0.5))
        8
    """
    if points.ndim != 2 or points.shape[1] != 3 or not np.isfinite(points).all() or not spacing > 0:
        raise InvalidInput(
            f"points of shape {points.shape}, {spacing:g} m apart: expected finite points (N, 3), above 0"
        )
    if len(points) == 0:
        return points
    lower, upper = bounds(points)
    cells = cells_of(points, lower - BEFORE, upper, spacing)
    return points[np.sort(cells.order[cells.starts[:-1]])]


def voxel_means(points: FloatArray, spacing: float, ahead: float = BEFORE, fewest: int = 1) -> FloatArray:
    """Keep the mean of the points in each cubic cell, which also averages their noise.

    Args:
        points: (N, 3) points [m].
        spacing: Edge of the cells [m], > 0.
        ahead: How far before the least coordinates the cells begin [m].
        fewest: Points of a cell at least; others are left out.

    Returns:
        (M, 3) points, M <= N, ordered by cell.
    """
    if len(points) == 0:
        return points
    lower, upper = bounds(points)
    cells = cells_of(points, lower - ahead, upper, spacing)
    return cells.means()[cells.sizes >= fewest]


def spacing_of(points: FloatArray) -> float:
    """Typical distance of neighbouring points: to the fourth-nearest one.

    Args:
        points: (N, d) points [m], d = 2 or 3; of more than `MANY`, some.

    Returns:
        The median [m], 0 for a single point.
    """
    some = points[:: max(1, len(points) // MANY)]
    asked = some[:: max(1, len(some) // ENOUGH)]
    near = PointTree(some).query(asked, k=min(5, len(some)))[0]
    return float(np.median(near.reshape(len(asked), -1)[:, -1]))
