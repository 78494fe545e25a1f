"""The corners of the convex outline of points in a plane."""

from typing import TYPE_CHECKING

import numpy as np

from topple.topology.kernels.compiled import address, kernels

if TYPE_CHECKING:
    from topple.topology.base.arrays import FloatArray, IntArray


def outline_corners(flat: "FloatArray") -> "IntArray":
    """Find the corners of the convex outline of points.

    Args:
        flat: (N, 2) points [m], N >= 1.

    Returns:
        (C,) their rows, around to the left from either end; none where the points lie in a line. Kernel and
        twin may differ in corners that stand out by less than rounding.
    """
    compiled = kernels()
    if compiled is None:
        from scipy.spatial import ConvexHull, QhullError

        try:
            return np.asarray(ConvexHull(flat).vertices, dtype=np.int64)
        except (QhullError, ValueError):
            return np.empty(0, dtype=np.int64)
    given, rows = np.ascontiguousarray(flat, dtype=np.float64), np.empty(len(flat), dtype=np.int64)
    return rows[: compiled.outline_corners(address(given), len(given), address(rows))]
