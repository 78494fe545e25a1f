"""Convex bodies of clouds: their flat faces as planes through all points on them, round parts as they bulge.

A cloud says where a face is far better than where any of its points is. So where a body is convex, faces meet
at edges known to a tenth of a millimetre, and contacts are those of exact meshes.
"""

import numpy as np
from scipy.spatial import ConvexHull, HalfspaceIntersection, KDTree, QhullError

from topple.planner.stability.tolerances import (
    ALONG_FACE,
    BULGE,
    CONVEX_SHARE,
    COVERED,
    DIRECTIONS,
    FEWEST_OF_FACE,
    FLAT_FACE,
    INSIDE_HULL,
    MOST_FACES,
    OFF_FACE,
    ROUND_REST,
    STRAYS,
)
from topple.topology.base.arrays import BoolArray, FloatArray
from topple.topology.io.geometry import spread_over
from topple.topology.scene.mesh import Mesh


def solid_of(points: FloatArray, noise: float, spacing: float) -> Mesh | None:
    """The convex body that a cloud is of.

    Args:
        points: (N, 3) points all over its surface [m].
        noise: Standard deviation of these across the surface [m].
        spacing: Distance between neighbours [m].

    Returns:
        The body; None where it is not convex, or flat.
    """
    try:
        hull = ConvexHull(points)
        planes, rest = _faces(points, hull, noise)
        if rest.mean() > ROUND_REST:
            planes = np.concatenate([planes, _round_sides(points[rest], planes)])
        if len(planes) < 4 or not np.isfinite(planes).all():
            return None
        inside = (points @ planes[:, :3].T + planes[:, 3]).max(axis=1)
        middle = np.mean([points.max(axis=0), points.min(axis=0)], axis=0)
        if np.mean(inside > -INSIDE_HULL - 4 * noise) < CONVEX_SHARE:
            return None
        corners = HalfspaceIntersection(planes, middle).intersections
        made = ConvexHull(corners[np.isfinite(corners).all(axis=1)])
    except (QhullError, ValueError):
        return None
    if np.any(np.abs(np.ptp(made.points, axis=0) - np.ptp(points, axis=0)) > INSIDE_HULL + 8 * noise):
        return None  # faces that should end it were not seen
    faces = made.simplices.copy()
    sides = made.points[faces]
    out = np.cross(sides[:, 1] - sides[:, 0], sides[:, 2] - sides[:, 0])
    inward = np.einsum("ij,ij->i", out, made.equations[:, :3]) < 0
    faces[inward] = faces[inward][:, ::-1]
    apart = KDTree(points).query(spread_over(made.points, faces)[0])[0]
    if np.mean(apart < COVERED * spacing + 2 * noise) < CONVEX_SHARE:
        return None  # a hollow is open there
    return Mesh(made.points, faces)


def _faces(points: FloatArray, hull: ConvexHull, noise: float) -> tuple[FloatArray, BoolArray]:
    """Flat faces (F, 4) as outward planes, the largest first, and which points (N,) are of none."""
    normals = hull.equations[:, :3]
    corners = points[hull.simplices]
    areas = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
    left, rest, found = areas.copy(), np.ones(len(points), dtype=np.bool_), list[FloatArray]()
    for _ in range(MOST_FACES):
        gathered = (normals @ normals.T > ALONG_FACE) @ left
        best = int(gathered.argmax())
        if gathered[best] < FLAT_FACE * areas.sum() or rest.sum() < FEWEST_OF_FACE:
            break
        near = (normals @ normals[best] > ALONG_FACE) & (left > 0)
        normal = left[near] @ normals[near]
        normal /= np.linalg.norm(normal)
        left[near] = 0.0
        if any(plane[:3] @ normal > ALONG_FACE for plane in found):
            continue
        plane = _face(points[rest], normal, noise)  # those of larger faces would tilt it
        if plane is not None:
            found.append(plane)
            rest &= np.abs(points @ plane[:3] + plane[3]) > 3 * noise + OFF_FACE
    return np.array(found).reshape(-1, 4), rest


def _face(points: FloatArray, normal: FloatArray, noise: float) -> FloatArray | None:
    """The outward plane (4,) of the flat face that ends a body about along a normal, if there is one."""
    heights = points @ normal
    own = heights > heights.max() - 6 * noise - OFF_FACE
    middle = points[own].mean(axis=0)
    for _ in range(4):
        if own.sum() < FEWEST_OF_FACE:
            return None
        middle = points[own].mean(axis=0)
        axis = np.linalg.svd(points[own] - middle, full_matrices=False)[2][2]
        normal = axis * np.sign(axis @ normal)
        own = np.abs((points - middle) @ normal) < 3 * noise + OFF_FACE
    heights = (points - middle) @ normal
    even = float(np.std(heights[own])) < 1.3 * noise + OFF_FACE / 4
    ends = float(np.mean(heights > 4 * noise + OFF_FACE)) < STRAYS
    return np.append(normal, -float(normal @ middle)) if even and ends else None


def _round_sides(points: FloatArray, planes: FloatArray) -> FloatArray:
    """Planes (K, 4) that touch what is round, from all around but along flat faces."""
    count = np.arange(DIRECTIONS) + 0.5
    height, turn = 1 - 2 * count / DIRECTIONS, np.pi * (1 + 5**0.5) * count
    across = np.sqrt(1 - height**2)
    ways = np.stack([across * np.cos(turn), across * np.sin(turn), height], axis=1)
    if len(planes):
        ways = ways[(ways @ planes[:, :3].T).max(axis=1) < ALONG_FACE]
    farthest = (points @ ways.T).argmax(axis=0)
    near = KDTree(points).query_ball_point(points[farthest], BULGE)
    reach = [float((points[each] @ way).mean()) for each, way in zip(near, ways, strict=True)]
    return np.column_stack([ways, -np.array(reach)])
