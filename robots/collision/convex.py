"""Convex vertex sets made ready for batches: fewer vertices within a stated error, bounding spheres."""

from functools import lru_cache

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import ConvexHull, QhullError

from topple.robots.collision.tolerances import REDUCTION
from topple.topology.base.arrays import FloatArray, IntArray, freeze, round_off
from topple.topology.geometry.axes import cross


def hull_of(points: FloatArray) -> tuple[FloatArray, IntArray]:
    """Hull vertices and outward triangles of points that may lie in a plane, on a line or in one place.

    Flat sets are thickened by a tenth of a millimetre on either side, so that every set has a volume.

    Args:
        points: (N, 3) in [m].

    Returns:
        (V, 3) vertices and (F, 3) indices, counterclockwise seen from outside.
    """
    points = round_off(points).reshape(-1, 3)
    try:
        hull = ConvexHull(points)
    except QhullError:
        hull = ConvexHull(_thicken(points))
    index = np.full(len(hull.points), -1)
    index[hull.vertices] = np.arange(len(hull.vertices))
    triangles: IntArray = index[hull.simplices]
    vertices: FloatArray = hull.points[hull.vertices]
    a, b, c = (vertices[triangles[:, k]] for k in range(3))
    inward = np.einsum("ij,ij->i", cross(b - a, c - a), hull.equations[:, :3]) < 0
    triangles[inward] = triangles[inward][:, ::-1]
    return vertices, triangles


def _thicken(points: FloatArray) -> FloatArray:
    corners = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]) * 1e-4
    return (points[:, None, :] + corners).reshape(-1, 3)


def reduce_hull(vertices: FloatArray, tolerance: float = REDUCTION) -> tuple[FloatArray, float]:
    """A subset of hull vertices whose hull comes within a tolerance of all of them.

    Args:
        vertices: (V, 3) hull vertices in [m].
        tolerance: Largest distance in [m] of a dropped vertex from the planes of the kept ones.

    Returns:
        (K, 3) kept vertices and the error in [m]: the whole hull lies within that distance of the kept ones'
        hull.
    """
    kept, error = _reduce(np.ascontiguousarray(vertices, dtype=float).tobytes(), float(tolerance))
    return kept, error


@lru_cache(maxsize=4096)
def _reduce(data: bytes, tolerance: float) -> tuple[FloatArray, float]:
    vertices = np.frombuffer(data).reshape(-1, 3)
    if len(vertices) <= 16:
        return freeze(vertices), 0.0
    directions = np.array(
        [[x, y, z] for x in (-1, 0, 1) for y in (-1, 0, 1) for z in (-1, 0, 1) if x or y or z]
    )
    kept = sorted(set(np.argmax(vertices @ directions.T, axis=0).tolist()))
    while True:
        try:
            hull = ConvexHull(vertices[kept])
        except QhullError:
            return freeze(vertices), 0.0
        planes: FloatArray = hull.equations
        beyond = (vertices @ planes[:, :3].T + planes[:, 3]).max(axis=1)
        worst = int(np.argmax(beyond))
        if beyond[worst] <= tolerance or len(kept) >= len(vertices):
            break
        kept.append(worst)
    outside = np.flatnonzero(beyond > 1e-9)
    error = _largest_distance(vertices[outside], hull.points[hull.simplices])
    return freeze(vertices[kept]), error


def _largest_distance(points: FloatArray, triangles: FloatArray) -> float:
    import trimesh

    if not len(points):
        return 0.0
    pairs = np.repeat(triangles[None], len(points), axis=0).reshape(-1, 3, 3)
    repeated = np.repeat(points, len(triangles), axis=0)
    nearest = trimesh.triangles.closest_point(pairs, repeated)
    distances = np.linalg.norm(nearest - repeated, axis=1).reshape(len(points), -1)
    return float(distances.min(axis=1).max())


def bounding_sphere(points: FloatArray) -> tuple[FloatArray, float]:
    """Centre and radius of a sphere around points, within about a percent of the smallest.

    Args:
        points: (N, 3) in [m].

    Returns:
        (3,) centre and the radius in [m].
    """
    return _sphere(np.ascontiguousarray(points, dtype=float).tobytes())


@lru_cache(maxsize=4096)
def _sphere(data: bytes) -> tuple[FloatArray, float]:
    points = np.frombuffer(data).reshape(-1, 3)
    centre = points.mean(axis=0)  # stays within the hull, as every step goes towards a point
    for k in range(2, 100):  # Badoiu and Clarkson: walk towards the farthest point in shrinking steps
        away = points - centre
        centre = centre + away[np.einsum("ij,ij->i", away, away).argmax()] / k
    return freeze(centre), float(np.linalg.norm(points - centre, axis=1).max())


def pad_sets(sets: list[FloatArray]) -> NDArray[np.float32]:
    """Vertex sets of different sizes as one array, short ones filled with their first vertex.

    Args:
        sets: P arrays (V_i, 3), none empty.

    Returns:
        (P, max V_i, 3) float32.
    """
    size = max((len(vertices) for vertices in sets), default=1)
    result = np.zeros((len(sets), size, 3), dtype=np.float32)
    for i, vertices in enumerate(sets):
        result[i] = vertices[0]
        result[i, : len(vertices)] = vertices
    return result


def section(points: FloatArray, z: float) -> FloatArray:
    """Points (M, 3) that span the cut of a convex body, by its vertices (V, 3), at a height [m]."""
    above, below = points[points[:, 2] > z], points[points[:, 2] <= z]
    a, b = np.repeat(below, len(above), axis=0), np.tile(above, (len(below), 1))
    share = (z - a[:, 2]) / (b[:, 2] - a[:, 2])
    return a + share[:, None] * (b - a)
