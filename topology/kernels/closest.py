"""The closest places of two sampled surfaces."""

from typing import TYPE_CHECKING

import numpy as np

from topple.topology.kernels.compiled import address, kernels
from topple.topology.kernels.neighbours import PointTree
from topple.topology.kernels.planes import patch_planes

if TYPE_CHECKING:
    from topple.topology.base.arrays import FloatArray

    Samples = tuple[FloatArray, FloatArray]


def closest_places(
    a: "Samples", b: "Samples", most: int, patch: int
) -> "list[tuple[FloatArray, FloatArray]]":
    """Measure how far the points of two surfaces are from the other one that are nearest to it.

    The distance from a point to a sampled surface is that to the plane through the nearest samples, as far
    as they reach: sparse clouds of surfaces in contact do not seem apart by their spacing.

    Args:
        a: Of one surface (N, 3) points [m], N >= 1, and (N,) numbers, less where one is likely to be near.
        b: Of the other.
        most: How many points of each.
        patch: How many samples make a plane.

    Returns:
        For each surface (k,) distances [m] of its nearest points from the other, k <= most, in the order of
        its points, and (k,) from the nearest sample of the other. Kernel and twin differ by rounding, and in
        which of equally near points they take.
    """
    compiled = kernels()
    if compiled is None:
        pairs = ((a, PointTree(b[0])), (b, PointTree(a[0])))
        return [_to_surface(_nearest(*of, tree, most), tree, patch) for of, tree in pairs]
    given = [np.ascontiguousarray(one, dtype=np.float64) for one in (a[0], b[0], a[1], b[1])]
    counts = np.array([len(a[0]), len(b[0])], dtype=np.int64)
    distances, samples = np.empty((2, 2, most))
    compiled.closest_places(
        *map(address, given), address(counts), most, patch, address(distances), address(samples)
    )
    return [(distances[s, :k], samples[s, :k]) for s, k in enumerate(np.minimum(counts, most).tolist())]


def _nearest(points: "FloatArray", likely: "FloatArray", tree: PointTree, most: int) -> "FloatArray":
    """The points nearest to those of a tree: the likely ones bound how far the others may be."""
    if len(points) <= most:
        return points
    first = points[np.argpartition(likely, most)[:most]]
    bound = float(np.max(tree.query(first)[0]))
    distance = tree.query(points, distance_upper_bound=np.nextafter(bound, np.inf))[0]
    return points[np.sort(np.argpartition(distance, most)[:most])]


def _to_surface(points: "FloatArray", tree: PointTree, patch: int) -> "tuple[FloatArray, FloatArray]":
    """(N,) distances of points [m] to the surface that samples show, and to the nearest sample."""
    surface = tree.data
    count = min(patch, len(surface))
    distance, index = tree.query(points, k=count)
    distance, index = distance.reshape(len(points), count), index.reshape(len(points), count)
    nearest = surface[index[:, 0]]
    if count < 3:
        return distance[:, 0], distance[:, 0]
    near = surface[index]
    middle, normal, _ = patch_planes(near)
    height = np.abs(np.einsum("ni,ni->n", points - middle, normal))
    # Samples reach half their spacing beyond the last one.
    reach = 0.5 * np.linalg.norm(near[:, 1:4] - nearest[:, None], axis=2).mean(axis=1)
    beside = np.sqrt(
        np.maximum(distance[:, 0] ** 2 - np.einsum("ni,ni->n", points - nearest, normal) ** 2, 0)
    )
    away = np.minimum(distance[:, 0], np.hypot(height, np.maximum(beside - reach, 0.0)))
    return away, distance[:, 0]
