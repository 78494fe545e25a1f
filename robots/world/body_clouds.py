"""Convex pieces of bodies from points of their surfaces: one hull for a solid, thin pieces for a shell."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.spatial import ConvexHull, KDTree, QhullError

from topple.robots.collision.convex import hull_of, reduced
from topple.robots.world.tolerances import (
    AGREED,
    BENT,
    DEEP,
    DETAIL,
    ONE_PLANE,
    PIECE,
    SHARED,
    SMOOTHED,
    WALL,
)
from topple.topology.arrays import FloatArray, IntArray
from topple.topology.geometry.sides import beyond, sides_of


@dataclass(frozen=True, eq=False)
class Piece:
    """A convex part and what was seen of it.

    Attributes:
        corners: (V, 3) corners of its hull [m].
        seen: (N, 3) points of it that a camera saw [m]; the rest of it was invented.
        post: It only holds up what nobody saw the underside of: no part of the thing.
    """

    corners: FloatArray
    seen: FloatArray
    post: bool = False

    @cached_property
    def planes(self) -> FloatArray:
        """(F, 4) facet planes, n · p + d <= 0 inside [m]."""
        sides = sides_of(self.corners)
        assert sides is not None, "a piece has a volume"
        return sides

    def having(self, points: FloatArray) -> "Piece":
        """The hull of the piece and of further (N, 3) points [m], which nobody saw."""
        return Piece(hull_of(np.concatenate([self.corners, points]))[0], self.seen, self.post)


def solid(points: FloatArray, seen: FloatArray) -> list[Piece]:
    """One convex piece.

    Args:
        points: (N, 3) points on the whole surface [m].
        seen: (M, 3) those of them that were seen.

    Returns:
        The hull of the smoothed points: noise would make it too large on every side.
    """
    return [Piece(_corners(smoothed(points)), seen)]


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
    points = smoothed(points)
    tree = KDTree(points)
    home = tree.query(seen)[1] if len(seen) else np.zeros(0, dtype=np.int64)
    pieces: list[Piece] = []
    for own in _split(points):
        around = np.unique(np.concatenate(tree.query_ball_point(points[own], SHARED)).astype(np.int64))
        mine = seen[np.isin(home, around)]
        pieces.append(Piece(_corners(_thickened(points[around], mine, viewpoints)), mine))
    return pieces


def _split(points: FloatArray) -> list[IntArray]:
    """Halve a cloud across its length until none of its points lies deep in the hull of its piece."""
    done: list[IntArray] = []
    waiting: list[IntArray] = [np.arange(len(points))]
    while waiting:
        index = waiting.pop()
        piece = points[index]
        axis = np.linalg.svd(piece - piece.mean(axis=0), full_matrices=False)[2][0]
        along = piece @ axis
        if np.ptp(along) <= PIECE or _depth(piece) <= BENT:
            done.append(index)
            continue
        middle = (along.min() + along.max()) / 2
        waiting += [index[along <= middle], index[along > middle]]
    return done


def _depth(points: FloatArray) -> float:
    """How deep the deeper ones of some points lie in their hull [m]."""
    sides = sides_of(points)
    return 0.0 if sides is None else float(np.quantile(-beyond(sides, points), DEEP))


def smoothed(points: FloatArray) -> FloatArray:
    """Points (N, 3) [m], each one moved onto the plane through its neighbours: noise goes, faces stay."""
    if len(points) < SMOOTHED:
        return points
    patches = points[KDTree(points).query(points, k=SMOOTHED)[1]]
    middle = patches.mean(axis=1)
    centred = patches - middle[:, None]
    values, axes = np.linalg.eigh(np.einsum("nki,nkj->nij", centred, centred))
    normal = axes[:, :, 0]
    flat = values[:, 0] < ONE_PLANE * values[:, 1]
    off = np.einsum("ni,ni->n", points - middle, normal) * flat
    return points - off[:, None] * normal


def _thickened(points: FloatArray, seen: FloatArray, viewpoints: FloatArray | None) -> FloatArray:
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
        return np.array(reduced(points[ConvexHull(points).vertices], DETAIL)[0])
    except (QhullError, ValueError):
        return hull_of(points)[0]
