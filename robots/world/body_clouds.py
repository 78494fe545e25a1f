"""Convex pieces of bodies from points of their surfaces: one hull for a solid, thin pieces for a shell."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.spatial import ConvexHull, QhullError

from topple.robots.collision.convex import hull_of, reduce_hull
from topple.robots.world.tolerances import (
    AGREED,
    BENT,
    DEEP,
    DETAIL,
    ONE_PLANE,
    ONE_SHEET,
    PIECE,
    SHARED,
    SHEET,
    SMOOTHED,
    STRAYS,
    WALL,
)
from topple.topology.base.arrays import BoolArray, FloatArray, IntArray
from topple.topology.geometry.sides import beyond, sides_of
from topple.topology.kernels.neighbours import PointTree
from topple.topology.kernels.planes import patch_planes


@dataclass(frozen=True, eq=False)
class Piece:
    """A convex part and what was seen of it.

    Attributes:
        corners: (V, 3) corners of its hull [m].
        seen: (N, 3) points of it that a camera saw [m]; the rest of it was invented.
    """

    corners: FloatArray
    seen: FloatArray

    @cached_property
    def planes(self) -> FloatArray:
        """(F, 4) facet planes, n · p + d <= 0 inside [m]."""
        sides = sides_of(self.corners)
        assert sides is not None, "a piece has a volume"
        return sides

    def with_points(self, points: FloatArray) -> "Piece":
        """The hull of the piece and of further (N, 3) points [m], which nobody saw."""
        return Piece(hull_of(np.concatenate([self.corners, points]))[0], self.seen)


def solid(points: FloatArray, seen: FloatArray) -> list[Piece]:
    """One convex piece.

    Args:
        points: (N, 3) points on the whole surface [m].
        seen: (M, 3) those of them that were seen.

    Returns:
        The hull of the smoothed points: noise would make it too large on every side.
    """
    return [Piece(_corners(smooth(points)), seen)]


def shell(points: FloatArray, seen: FloatArray, viewpoints: FloatArray | None) -> list[Piece]:
    """Thin pieces along a wall, which leave the hollow free.

    Args:
        points: (N, 3) points on the whole surface [m].
        seen: (M, 3) those of them that were seen.
        viewpoints: (k, 3) camera centres [m], from which a wall grows away; None where both its sides are
            among the points.

    Returns:
        Pieces of about `PIECE`, at least `WALL` thick where one side was seen.
    """
    own = PointTree(seen).query(points)[0] == 0.0 if len(seen) else np.zeros(len(points), dtype=np.bool_)
    points = smooth(points) if viewpoints is None else _smoothed_sheet(points, own, viewpoints)
    tree = PointTree(points)
    pieces: list[Piece] = []
    for split in _split(points, own, viewpoints):
        around = np.unique(np.concatenate(tree.query_ball_point(points[split], SHARED)))
        mine = points[around[own[around]]]
        pieces.append(Piece(_corners(_thicken_wall(points[around], mine, viewpoints)), mine))
    return pieces


def _split(points: FloatArray, seen: BoolArray, viewpoints: FloatArray | None) -> list[IntArray]:
    """Halve a cloud across its length until the hull of no piece fills much of the hollow before it."""
    done: list[IntArray] = []
    waiting: list[IntArray] = [np.arange(len(points))]
    while waiting:
        index = waiting.pop()
        piece = points[index]
        axis = np.linalg.svd(piece - piece.mean(axis=0), full_matrices=False)[2][0]
        along = piece @ axis
        if np.ptp(along) <= PIECE or _depth_in_hull(piece, seen[index], viewpoints) <= BENT:
            done.append(index)
            continue
        middle = (along.min() + along.max()) / 2
        waiting += [index[along <= middle], index[along > middle]]
    return done


def _depth_in_hull(points: FloatArray, seen: BoolArray, viewpoints: FloatArray | None) -> float:
    """How deep the deeper ones of the seen points lie [m] below those sides of the hull that cameras face."""
    sides = sides_of(points)
    if sides is None or not seen.any():
        return 0.0
    if viewpoints is not None:
        sides = sides[(sides[:, :3] @ viewpoints.T + sides[:, 3:] > 0.0).any(axis=1)]
    return float(np.quantile(-beyond(sides, points[seen]), DEEP)) if len(sides) else 0.0


def _smoothed_sheet(points: FloatArray, seen: BoolArray, viewpoints: FloatArray) -> FloatArray:
    """The points of one side without its noise: strays go onto it, and no guess stands out before it.

    What is much smaller than such a patch goes with the strays: a bump of a square centimetre does.
    """
    sheet = points[seen]
    if len(sheet) < SHEET:
        return points
    patches = sheet[PointTree(sheet).query(points, k=SHEET)[1]]
    middles, normals, _ = patch_planes(patches)
    away = np.abs(np.einsum("pki,pi->pk", patches - middles[:, None], normals))
    nearest = np.argsort(away, axis=1)[:, : round(STRAYS * SHEET), None]
    middles, normals, squares = patch_planes(np.take_along_axis(patches, nearest, axis=1))
    normals *= np.sign(np.einsum("pi,pi->p", viewpoints.mean(axis=0) - middles, normals))[:, None]
    off = np.einsum("pi,pi->p", points - middles, normals)
    off = np.where(seen, off, np.maximum(off, 0.0)) * (squares[:, 0] < ONE_SHEET * squares[:, 1])
    return points - off[:, None] * normals


def smooth(points: FloatArray) -> FloatArray:
    """Points (N, 3) [m], each one moved onto the plane through its neighbours: noise goes, faces stay."""
    if len(points) < SMOOTHED:
        return points
    middles, normals, squares = patch_planes(points[PointTree(points).query(points, k=SMOOTHED)[1]])
    off = np.einsum("pi,pi->p", points - middles, normals) * (squares[:, 0] < ONE_PLANE * squares[:, 1])
    return points - off[:, None] * normals


def _thicken_wall(points: FloatArray, seen: FloatArray, viewpoints: FloatArray | None) -> FloatArray:
    """Points of a piece of wall and of its other side, where that was not seen."""
    middle = points.mean(axis=0)
    axes = np.linalg.eigh(np.cov((points - middle).T))[1] if len(points) > 3 else np.eye(3)
    normal = axes[:, 0]
    thick = float(np.ptp(points @ normal))
    if viewpoints is not None and len(seen):
        side = float(np.sign((viewpoints - middle) @ normal).mean())
        if abs(side) > AGREED:
            return np.concatenate([points, points - np.sign(side) * WALL * normal])
    lacking = max(WALL - thick, 0.0) / 2
    return points if lacking <= 0 else np.concatenate([points - lacking * normal, points + lacking * normal])


def _corners(points: FloatArray) -> FloatArray:
    """(V, 3) corners of the hull of points, those that matter; flat and tiny sets get a thickness."""
    try:
        return np.array(reduce_hull(points[ConvexHull(points).vertices], DETAIL)[0])
    except (QhullError, ValueError):
        return hull_of(points)[0]
