"""Noise averaged away: a place per cell, drawn onto the curved patch that the points around it lie on.

The hull of a noisy cloud is larger than what was seen: the points that are furthest off hold it up, and a
camera's noise makes half as much again of a thing of 5 cm. Patches are of second order, as planes cut off
what bends.
"""

import numpy as np
from scipy.spatial import KDTree

from topple.topology.arrays import FloatArray
from topple.topology.geometry.thin import voxel_means
from topple.topology.geometry.tolerances import (
    KEPT_CLOUDS,
    PATCH_CELL,
    PATCH_FEWEST,
    PATCH_MOST,
    PATCH_RADIUS,
    STRAIGHT,
)
from topple.topology.remembered import remembered


@remembered(KEPT_CLOUDS)
def smoothed(points: FloatArray) -> FloatArray:
    """Average the noise of a cloud away.

    Args:
        points: (N, 3) points [m].

    Returns:
        (M, 3) places on the surface that they show [m], M <= N, none where too few points are near; the
        points as they are where there are too few for a surface.
    """
    if len(points) < PATCH_FEWEST:
        return points
    places = voxel_means(points, PATCH_CELL)
    found = KDTree(points).query(places, k=min(PATCH_MOST, len(points)))
    distance, near = np.asarray(found[0]), np.asarray(found[1])
    kept = np.count_nonzero(distance <= PATCH_RADIUS, axis=1) >= PATCH_FEWEST
    if np.count_nonzero(kept) < PATCH_FEWEST:
        return points
    distance, near, own = distance[kept], near[kept], places[kept]
    weights = np.where(distance <= PATCH_RADIUS, np.exp(-((distance / (0.6 * PATCH_RADIUS)) ** 2)), 0.0)
    return own + _to_patches(points[near] - own[:, None], weights)


def _to_patches(around: FloatArray, weights: FloatArray) -> FloatArray:
    """(N, 3) ways from the origin, along the normal there, to the patches of points (N, k, 3) about it [m].

    Args:
        around: The points of each patch [m].
        weights: (N, k) their weights.
    """
    total = weights.sum(axis=1)
    weighted = weights[..., None] * around
    middle = weighted.sum(axis=1) / total[:, None]
    spread = weighted.transpose(0, 2, 1) @ around / total[:, None, None]
    axes = np.linalg.eigh(spread - middle[:, :, None] * middle[:, None])[1]
    height, u, v = np.moveaxis(around @ axes / PATCH_RADIUS, 2, 0)
    terms = np.stack([np.ones_like(u), u, v, u * u, u * v, v * v], axis=2)
    scaled = (weights[..., None] * terms).transpose(0, 2, 1)
    stiff = STRAIGHT * total[:, None, None] * np.diag([0.0, 1.0, 1.0, 1.0, 1.0, 1.0])
    fitted = np.linalg.solve(scaled @ terms + stiff, scaled @ height[..., None])
    return np.asarray(PATCH_RADIUS * fitted[:, 0] * axes[:, :, 0])
