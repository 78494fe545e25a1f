"""Plan views: the highest or lowest point over each cell of a grid."""

from typing import TYPE_CHECKING

import numpy as np

from topple.topology.kernels.compiled import address, kernels

if TYPE_CHECKING:
    from topple.topology.base.arrays import FloatArray, IntArray


def heights_over(
    points: "FloatArray",
    corner: "FloatArray",
    cell: float,
    size: "IntArray",
    highest: bool,
    first: "IntArray | None" = None,
) -> "FloatArray":
    """Find the highest or lowest point over each cell of a grid.

    Args:
        points: (N, 3) upright points [m], finite; those beside the grid count for no cell.
        corner: (2,) where cells are counted from [m].
        cell: Edge of a cell [m], > 0.
        size: (2,) how many cells there are.
        highest: Whether of the highest, or of the lowest.
        first: (2,) number of the first cell; 0 and 0 where None.

    Returns:
        `size` heights [m], -inf or inf over cells without a point; kernel and twin give the same.
    """
    shape, sign = (int(size[0]), int(size[1])), 1.0 if highest else -1.0
    start = np.zeros(2, dtype=np.int64) if first is None else np.ascontiguousarray(first, dtype=np.int64)
    plan, compiled = np.full(shape, -np.inf), kernels()
    if compiled is None:
        cells = np.floor((points[:, :2] - corner) / cell).astype(np.int64) - start
        inside = np.all((cells >= 0) & (cells < shape), axis=1)
        np.maximum.at(plan, tuple(cells[inside].T), sign * points[inside, 2])
        return sign * plan
    given, origin = np.ascontiguousarray(points, dtype=np.float64), np.ascontiguousarray(corner)
    extent = np.array(shape, dtype=np.int64)
    compiled.heights_over(
        address(given), len(given), address(origin), cell, address(start), address(extent), sign,
        address(plan),
    )  # fmt: skip
    return sign * plan
