"""Sides of convex outlines and parts, as half-planes and half-spaces, and how far beyond them points lie."""

import numpy as np
from scipy.spatial import ConvexHull, QhullError

from topple.topology.base.arrays import FloatArray


def sides_of(points: FloatArray) -> FloatArray | None:
    """Find the sides of the convex hull of points.

    Args:
        points: (N, d) points [m], d = 2 or 3.

    Returns:
        (F, d + 1) outward unit normals and offsets, normal · p + offset <= 0 inside [m]; a flat face of
        many corners comes as many equal sides. None for points without area or volume.
    """
    try:
        return np.asarray(ConvexHull(points).equations)
    except (QhullError, ValueError):
        return None


def joggled_sides(points: FloatArray) -> FloatArray:
    """Find the sides of the convex hull of points (N, 3) [m], flat ones shifted by rounding errors first.

    Returns:
        (F, 4) as `sides_of`; of a line or a single point those of a thread or a grain of a micrometre.
    """
    if len(points) < 4:
        points = np.concatenate([points, *(points + 1e-6 * axis for axis in np.eye(3))])
    return np.asarray(ConvexHull(points, qhull_options="QJ").equations, dtype=np.float64)


def beyond(sides: FloatArray, points: FloatArray) -> FloatArray:
    """Measure how far points are beyond the nearest side.

    Args:
        sides: (F, d + 1) sides from `sides_of`.
        points: (..., d) points [m].

    Returns:
        (...) largest directed distance to a side [m], negative inside.
    """
    return np.asarray((points @ sides[:, :-1].T + sides[:, -1]).max(axis=-1))


def inset(outline: FloatArray, points: FloatArray) -> FloatArray:
    """Measure how far points are inside the convex outline of others.

    Args:
        outline: (K, 2) level points [m].
        points: (N, 2) [m].

    Returns:
        (N,) distances to the outline [m], negative outside; -1 where it has no area.
    """
    sides = sides_of(outline)
    return np.full(len(points), -1.0) if sides is None else -beyond(sides, points)


def hull_volume(points: FloatArray) -> float:
    """Volume [m³] of the convex hull of points (N, 3); 0 of flat ones."""
    try:
        return float(ConvexHull(points).volume)
    except (QhullError, ValueError):
        return 0.0
