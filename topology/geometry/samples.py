"""Points standing for bodies: clouds thinned evenly, convex parts sampled, and where their mass is."""

from collections.abc import Sequence
from functools import cache

import numpy as np
from scipy.spatial import ConvexHull, QhullError

from topple.topology.base.arrays import FloatArray, freeze


def sample(solid: Sequence[FloatArray], spacing: float) -> FloatArray:
    """Points (N, 3) spread over the surfaces of convex parts, about `spacing` [m] apart."""
    return sampled_with_normals(solid, spacing)[0]


def sampled_with_normals(solid: Sequence[FloatArray], spacing: float) -> tuple[FloatArray, FloatArray]:
    """Points spread over the surfaces of convex parts.

    Args:
        solid: (V, 3) vertices of each part [m].
        spacing: About how far apart [m].

    Returns:
        (N, 3) points and their (N, 3) outward unit normals; none of parts without volume.
    """
    points, normals = [np.empty((0, 3))], [np.empty((0, 3))]
    for part in solid:
        try:
            hull = ConvexHull(part, qhull_options="QJ Pp")
        except (QhullError, ValueError):
            continue
        corners = part[hull.simplices]
        edges = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2).max(axis=1)
        steps = np.maximum(1, np.ceil(edges / spacing)).astype(int).tolist()
        u, v = (np.concatenate(shares) for shares in zip(*map(_triangle_grid, steps), strict=True))
        each = np.repeat(np.arange(len(steps)), [len(_triangle_grid(count)[0]) for count in steps])
        first, second, third = corners[each].swapaxes(0, 1)
        points.append(first + u * (second - first) + v * (third - first))
        normals.append(hull.equations[each, :3])
    return np.vstack(points), np.vstack(normals)


@cache
def _triangle_grid(steps: int) -> tuple[FloatArray, FloatArray]:
    """Shares (N, 1) of two edges of a triangle, spread evenly over it and near its corners."""
    i, j = np.meshgrid(np.arange(steps), np.arange(steps), indexing="ij")
    u, v = (i + 1.0 / 3.0) / steps, (j + 1.0 / 3.0) / steps
    inside = u + v < 1.0
    return freeze(u[inside][:, None]), freeze(v[inside][:, None])


def centre_of_mass(points: FloatArray, solid: Sequence[FloatArray] = ()) -> FloatArray:
    """Estimate where an object's mass is, its density taken as even.

    Args:
        points: (N, 3) points of its surface [m].
        solid: Its convex parts, weighed by their volume; empty for none.

    Returns:
        (3,) the parts' common centre of volume, or the mean of the points where there is no volume.
    """
    return volume_and_centre(points, solid)[1]


def volume_and_centre(points: FloatArray, solid: Sequence[FloatArray] = ()) -> tuple[float, FloatArray]:
    """Estimate how much room an object fills and where the middle of that is.

    Args:
        points: (N, 3) points of its surface [m].
        solid: Its convex parts; empty for none.

    Returns:
        The parts' volumes in sum [m3] and (3,) their common centre; 0 and the mean of the points where there
        is no volume.
    """
    volumes, centres = [], []
    for part in solid:
        try:
            hull = ConvexHull(part, qhull_options="QJ Pp")
        except (QhullError, ValueError):
            continue
        inner = part.mean(axis=0)
        corners = part[hull.simplices]
        pieces = np.abs(np.linalg.det(corners - inner)) / 6.0
        if pieces.sum() > 0:
            volumes.append(float(pieces.sum()))
            centres.append((pieces[:, None] * (corners.sum(axis=1) + inner) / 4.0).sum(axis=0) / pieces.sum())
    if not volumes:
        return 0.0, points.mean(axis=0)
    return float(sum(volumes)), np.average(np.array(centres), axis=0, weights=volumes)
