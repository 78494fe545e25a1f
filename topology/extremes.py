"""Points that cannot be corners of a hull, dropped before Qhull sees them.

Qhull reads every point several times; nearly all points of a dense, noisy cloud lie inside the hull of a
small sample of it.
"""

import numpy as np
from scipy.spatial import ConvexHull, QhullError

from topple.topology.arrays import FloatArray
from topple.topology.gauge import Gauge

SMALL = 8000
"""Clouds below this size go straight to Qhull, which takes about as long as the sample's hull would."""
SAMPLE = 4096
"""Points whose hull stands in for the whole: more of them make a tighter hull with more facets."""
MANY_FACETS = 800
"""A sample hull with more facets than this (a smooth, noiseless cloud) is made again from fewer points."""


def without_inner_points(points: FloatArray) -> FloatArray:
    """Drop points that lie inside the hull of the others.

    Args:
        points: (N, 3) points [m] whose hull is solid.

    Returns:
        (M, 3) points with the same hull up to rounding; not in the order given.
    """
    if len(points) < SMALL:
        return points
    try:
        inner = ConvexHull(_sample(points, SAMPLE))
        if len(inner.equations) > MANY_FACETS:
            inner = ConvexHull(_sample(points, MANY_FACETS // 2))
    except QhullError:  # a sample may be flat where the cloud is not; all points stay
        return points
    corners = inner.points[inner.vertices]
    gauge = Gauge.of(inner.equations[:, :3], inner.equations[:, 3], corners.mean(axis=0))
    if gauge is None:
        return points
    # Points on the sample's hull are no corners of the whole, or are the sample's own, put back here.
    return np.concatenate([corners, points[~gauge.surely_inside(points)]])


def _sample(points: FloatArray, size: int) -> FloatArray:
    """Evenly spread rows of the cloud and its extremes along the axes."""
    corners = np.concatenate([points.argmin(axis=0), points.argmax(axis=0)])
    return np.concatenate([points[:: -(-len(points) // size)], points[corners]])
