"""Points that cannot be corners of a hull, dropped before Qhull sees them.

Qhull reads every point several times; nearly all points of a dense, noisy cloud lie inside the hull of a
small sample of it.
"""

import numpy as np
from scipy.spatial import ConvexHull, QhullError

from topple.topology.base.arrays import FloatArray, IntArray
from topple.topology.geometry.gauge import Gauge

SMALL = 8000
"""Clouds below this size go straight to Qhull, which takes about as long as the sample's hull would."""
SAMPLE = 2048
"""Points whose hull stands in for the whole at first."""
MANY_FACETS = 800
"""A sample hull with more facets than this (a smooth, noiseless cloud) is made again from fewer points."""
OUTERMOST = 8
"""One in so many of the points left over, the outermost first, makes a second, tighter hull."""


def without_inner_points(columns: FloatArray) -> FloatArray:
    """Drop points that lie inside the hull of the others.

    Args:
        columns: (3, N) coordinates of points [m] whose hull is solid, each axis contiguous.

    Returns:
        (M, 3) points with the same hull up to rounding; not in the order given.
    """
    if columns.shape[1] < SMALL:
        return columns.T
    inner = _hull_of(columns, _spread(columns, SAMPLE))
    if inner is not None and len(inner.equations) > MANY_FACETS:
        inner = _hull_of(columns, _spread(columns, MANY_FACETS // 2))
    if inner is None:
        return columns.T
    left = columns
    for last in (False, True):
        corners = inner.points[inner.vertices]
        gauge = Gauge.of(inner.equations[:, :3], inner.equations[:, 3], corners.mean(axis=0))
        if gauge is None:
            break
        bound = gauge.bound(left)
        outside = np.flatnonzero(bound > 1 + 1e-12)
        # Points on the inner hull are no corners of the whole, or are its own, put back here.
        left = np.concatenate([corners.T, left[:, outside]], axis=1)
        if last or left.shape[1] < SMALL:
            break
        # A curved cloud: the points that stand out furthest are on nearly every side of it.
        reach = np.concatenate([np.full(len(corners), np.inf), bound[outside]])
        count = min(len(reach) // OUTERMOST, SAMPLE)
        inner = _hull_of(left, np.argpartition(-reach, count)[:count])
        if inner is None or len(inner.equations) > 4 * MANY_FACETS:
            break
    return left.T


def _spread(columns: FloatArray, size: int) -> IntArray:
    """Evenly spread positions in the cloud and those of its extremes along the axes."""
    extremes = np.concatenate([columns.argmin(axis=1), columns.argmax(axis=1)])
    return np.concatenate([np.arange(0, columns.shape[1], -(-columns.shape[1] // size)), extremes])


def _hull_of(columns: FloatArray, chosen: IntArray) -> ConvexHull | None:
    """Qhull of some points, None where they are flat although the cloud is not."""
    try:
        return ConvexHull(columns[:, chosen].T)
    except QhullError:
        return None
