"""Small motions of objects between two looks, told from what cameras saw of them each time."""

from collections.abc import Mapping

import numpy as np
from scipy.spatial import KDTree

from topple.planner.grasp.surface import fitted_normals
from topple.planner.samples import voxel_means
from topple.topology.arrays import FloatArray

GRAIN = 0.004  # [m] points are averaged over: takes depth noise of 2 mm below one
PATCH = 0.012  # [m] a normal is fitted over: less than the curvature of fruit
FAR = 0.02  # [m] nearest points further apart are of parts that only one of the looks saw
LEAST = 30  # points below which nothing is said: half a matchbox
TRUSTED = 0.004  # [m] pairs further off their plane than this pull no harder (Huber): some only one look saw
ROUNDS = 10  # of matching: a motion of a centimetre is found in five
FIRM = 0.01  # share of the pairs' pull with which a direction that no face shows is held still


def shift(before: FloatArray, after: FloatArray) -> float | None:
    """How far an object moved between two looks.

    The rigid motion between the clouds is found by matching nearest points along normals (Chen and Medioni,
    "Object modelling by registration of multiple range images", 1992). A motion that changes nothing of what
    is seen, as of a ball about itself, is not found.

    Args:
        before: (N, 3) points seen first [m].
        after: (M, 3) points seen later [m].

    Returns:
        The way of the points that moved most [m], the farthest tenth left out; None where too little is seen.
    """
    fixed, points = voxel_means(before, GRAIN), voxel_means(after, GRAIN)
    if min(len(fixed), len(points)) < LEAST:
        return None
    # what comes into sight, or out of it, pulls at the one of the two matches that has no partner for it
    return min(_way(fixed, points), _way(points, fixed))


def _way(fixed: FloatArray, points: FloatArray) -> float:
    """How far points (M, 3) have to be moved as one body to lie on fixed ones (N, 3) [m]."""
    normals, _ = fitted_normals(fixed, PATCH, np.array([0.0, 0.0, 1.0]))
    tree, centre = KDTree(fixed), points.mean(axis=0)
    size = float(np.linalg.norm(points - centre, axis=1).mean())
    moved = points
    for _ in range(ROUNDS):
        found = tree.query(moved, distance_upper_bound=FAR)
        distance, index = np.asarray(found[0]), np.asarray(found[1], dtype=np.int64)
        near = np.isfinite(distance)
        if np.count_nonzero(near) < LEAST:
            return FAR
        matched = index[near]
        normal = normals[matched]
        off = np.einsum("ni,ni->n", moved[near] - fixed[matched], normal)
        moved = _turned(moved, _twist(moved[near] - centre, normal, off, size), centre)
    return float(np.quantile(np.linalg.norm(moved - points, axis=1), 0.9))


def _twist(arms: FloatArray, normals: FloatArray, off: FloatArray, size: float) -> FloatArray:
    """(6,) turn [rad] and way [m] that brings points `arms` from the centre onto planes they are `off`."""
    rows = np.hstack([np.cross(arms, normals), normals])
    pulling = rows * np.minimum(1.0, TRUSTED / np.maximum(np.abs(off), 1e-9))[:, None]
    still = FIRM * len(rows) * np.array([size**2] * 3 + [1.0] * 3)
    twist = np.linalg.solve(pulling.T @ rows + np.diag(still), -pulling.T @ off)
    return np.asarray(twist, dtype=np.float64)


def _turned(points: FloatArray, twist: FloatArray, centre: FloatArray) -> FloatArray:
    """Points (N, 3) moved by a small twist (6,) about a centre (3,)."""
    from scipy.spatial.transform import Rotation

    turn = Rotation.from_rotvec(twist[:3]).as_matrix()
    return (points - centre) @ turn.T + centre + twist[3:]


def shifts(before: Mapping[str, FloatArray], after: Mapping[str, FloatArray]) -> dict[str, float]:
    """How far the objects moved that both looks show well enough, in [m] by name; see `shift`."""
    both = ((name, shift(before[name], after[name])) for name in before if name in after)
    return {name: way for name, way in both if way is not None}
