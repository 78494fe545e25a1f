"""The plane of a flat thing, and the upward direction it gives."""

from collections.abc import Iterable, Mapping

import numpy as np

from topple.topology.base.arrays import FloatArray
from topple.topology.base.tolerances import DEPTH_NOISE
from topple.topology.geometry.tolerances import DRAWS, ENOUGH, FLAT_SHARE, LEVEL, LEVEL_DRAWS
from topple.topology.kernels.planes import patch_planes

TABLE = "table"
"""Name of a table that was not given as an object."""

_TABLE_NAMES = (TABLE, "ground", "floor", "shelf")


def fit_plane(
    points: FloatArray, *, inlier: float = DEPTH_NOISE, seed: int = 0, up: FloatArray | None = None
) -> tuple[FloatArray, float]:
    """Find the plane that holds most points, whatever the others do (RANSAC, then least squares).

    Args:
        points: Cloud (N, 3) in [m].
        inlier: Largest distance of a point of the plane in [m].
        seed: Seed of the draws.
        up: Unit vector (3,): only level planes are drawn; None draws any.

    Returns:
        The plane (4,) as (n, d) with a unit normal of either sign, and the share of points within
        `inlier` of it, in 0..1; the share is 0 where the points span no plane.
    """
    rng = np.random.default_rng(seed)
    some = points if len(points) <= ENOUGH else points[rng.choice(len(points), ENOUGH, replace=False)]
    none = np.array([0.0, 0.0, 1.0, 0.0])
    if len(some) < 3:
        return none, 0.0
    first, second, third = some[rng.integers(len(some), size=(3, DRAWS if up is None else LEVEL_DRAWS))]
    normals = np.cross(second - first, third - first)
    lengths = np.linalg.norm(normals, axis=1)
    usable = lengths > 1e-12
    if up is not None:
        usable &= np.abs(normals @ up) > LEVEL * lengths
    usable = np.flatnonzero(usable)[:DRAWS]
    if len(usable) == 0:
        return none, 0.0
    normals = normals[usable] / lengths[usable, None]
    offsets = -(normals * first[usable]).sum(axis=1)
    votes = (np.abs(some @ normals.T + offsets) <= inlier).sum(axis=0)
    best = int(votes.argmax())
    plane = np.append(normals[best], offsets[best])
    for _ in range(2):  # the second round lets the refined plane choose its points again
        plane = _least_squares(some[np.abs(some @ plane[:3] + plane[3]) <= inlier], plane)
    share = float((np.abs(some @ plane[:3] + plane[3]) <= inlier).mean())
    return plane, share


def tilted_share(points: FloatArray) -> float:
    """How much of a body lies in one face that is neither level nor upright, as of what leans on another.

    Args:
        points: Cloud (N, 3) in [m], z up.

    Returns:
        The face's share of the points times how far its slope is from both, 1 at 45 degrees: 0..1.
    """
    plane, share = fit_plane(points[:: max(len(points) // (2 * DRAWS), 1)])  # which tell a share to 3 %
    slope = float(np.arccos(min(abs(plane[2]), 1.0))) / (np.pi / 4)
    return share * (1.0 - abs(slope - 1.0))


def plane_through(points: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Middle (3,) [m] and unit normal (3,) of either sign of the plane nearest to points (N, 3)."""
    middles, normals, _ = patch_planes(points[None])
    return middles[0], normals[0]


def _least_squares(points: FloatArray, otherwise: FloatArray) -> FloatArray:
    if len(points) < 3:
        return otherwise
    middles, normals, squares = patch_planes(points[None])
    if squares[0, 1] <= 1e-14 * len(points):  # collinear: any plane through the line fits as well
        return otherwise
    return np.append(normals[0], -normals[0] @ middles[0])


def up_from_fixed(
    clouds: Mapping[str, FloatArray], fixed: Iterable[str], viewpoints: FloatArray
) -> tuple[FloatArray, str] | None:
    """Take the upward direction from the plane of a fixed object.

    The normal points to the side on which the other objects are; where there are none, to the cameras.

    Args:
        clouds: Points (N, 3) per object in [m].
        fixed: Names of the objects that never move; one named like a table goes first.
        viewpoints: Camera centres (k, 3), k >= 0, in [m].

    Returns:
        The unit vector (3,) and the sentence that says where it comes from, or None where no fixed
        object is flat or nothing tells its two sides apart.
    """
    names = list(fixed)
    for name in sorted(names, key=lambda name: (name.lower() not in _TABLE_NAMES, names.index(name))):
        plane, share = fit_plane(clouds[name])
        if share < FLAT_SHARE:
            continue
        others = [cloud for other, cloud in clouds.items() if other not in names]
        witnesses = np.concatenate([cloud.mean(axis=0)[None] for cloud in others] or [viewpoints])
        heights = witnesses @ plane[:3] + plane[3]
        if not len(heights) or float(np.median(heights)) == 0.0:
            continue
        up = plane[:3] * np.sign(np.median(heights))
        return (
            up,
            f"up is the normal of the plane of fixed object {name!r} ({share:.0%} of its points lie in it)",
        )
    return None


def table_by_name(names: Iterable[str]) -> str | None:
    """Find the one object that is named like a table.

    Args:
        names: Names of the objects.

    Returns:
        The name that is table, ground, floor or shelf, in this order, or None.
    """
    found = {name.lower(): name for name in names}
    return next((found[name] for name in _TABLE_NAMES if name in found), None)
