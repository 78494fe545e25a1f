"""Which convex parts are provably apart: separating directions for many part pairs of many states at once.

For a unit direction d the gap min_{a in A} d.a - max_{b in B} d.b is a lower bound on the distance of A and
B, so a positive gap is a proof that they do not touch. Directions are improved by Gilbert's algorithm (1966):
from a point of A - B move towards the support point of A - B that lies farthest back, as near to the origin
as that segment comes; the next direction points there.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from topple.robots.collision.convex import bounding_sphere, pad_sets, reduce_hull
from topple.robots.collision.tolerances import ROUNDING
from topple.topology.base.arrays import FloatArray, IntArray
from topple.topology.kernels.compiled import address, kernels

Float32Array = NDArray[np.float32]


@dataclass(frozen=True, eq=False)
class ConvexSets:
    """P convex parts, each carried by one frame of a chain (frame 0 stands still).

    Attributes:
        frame: (P,) the frame that carries the part.
        vertices: (P, 3, V) reduced vertices in that frame, padded.
        corners: (P * V, 3) the same vertices, one a row.
        centre: (P, 3) of a bounding sphere, in that frame.
        radius: (P,) of the bounding sphere in [m].
        slack: (P,) by how much the whole hull may stand out beyond the reduced one in [m].
        lower: (P, 3) lower corner of the part's box in its frame.
        upper: (P, 3) upper corner.
    """

    frame: IntArray
    vertices: Float32Array
    corners: Float32Array
    centre: Float32Array
    radius: Float32Array
    slack: Float32Array
    lower: Float32Array
    upper: Float32Array

    @staticmethod
    def of(sets: Sequence[FloatArray], frames: Sequence[int]) -> "ConvexSets":
        """Prepare parts.

        Args:
            sets: P arrays (V, 3) of hull vertices, each in its frame.
            frames: The frame of each.
        """
        kept = [reduce_hull(vertices) for vertices in sets]
        vertices = pad_sets([vertices for vertices, _ in kept])
        spheres = [bounding_sphere(vertices) for vertices in sets]
        return ConvexSets(
            np.array(frames, dtype=np.int64),
            np.ascontiguousarray(vertices.transpose(0, 2, 1)),
            vertices.reshape(-1, 3),
            np.array([centre for centre, _ in spheres], dtype=np.float32).reshape(-1, 3),
            np.array([radius for _, radius in spheres], dtype=np.float32) + np.float32(ROUNDING),
            np.array([error for _, error in kept], dtype=np.float32) + np.float32(ROUNDING),
            np.array([vertices.min(axis=0) for vertices in sets], dtype=np.float32).reshape(-1, 3),
            np.array([vertices.max(axis=0) for vertices in sets], dtype=np.float32).reshape(-1, 3),
        )

    @cached_property
    def table(self) -> IntArray:
        """The kernels' `Sets`: where the arrays are, and how many vertices and parts."""
        arrays = self.frame, self.vertices, self.centre, self.radius, self.slack, self.lower, self.upper
        assert all(array.flags.c_contiguous for array in arrays)
        return np.array([*map(address, arrays), self.vertices.shape[2], len(self.frame)], dtype=np.int64)


@dataclass(frozen=True, eq=False)
class Frames:
    """Poses of the n + 1 chain frames in m states, single precision: enough for bounds.

    Attributes:
        poses: (n + 1, 3, 4, m) rotations beside translations in [m].
    """

    poses: Float32Array

    @staticmethod
    def of(poses: FloatArray) -> "Frames":
        """Round what `Chain.poses` gives."""
        return Frames(np.ascontiguousarray(poses, dtype=np.float32))

    def points(self, frame: IntArray, points: Float32Array) -> Float32Array:
        """Where points are.

        Args:
            frame: (P,) the frame that carries each.
            points: (P, 3) in that frame.

        Returns:
            (3, P, m) in the base.
        """
        carried = self.poses[frame]
        placed = np.einsum("pijm,pj->ipm", carried[:, :, :3], points)
        placed += carried[:, :, 3].transpose(1, 0, 2)
        return placed


@dataclass(frozen=True, eq=False)
class Candidates:
    """Part pairs in states that are not known to be apart.

    Attributes:
        state: (T,) index of the state.
        a: (T,) index of one part.
        b: (T,) index of the other.
        direction: (T, 3) a first guess of a direction from b to a.
        need: (T,) gap in [m] that is enough.
    """

    state: IntArray
    a: IntArray
    b: IntArray
    direction: Float32Array
    need: Float32Array

    def subset(self, keep: NDArray[np.bool_] | IntArray) -> "Candidates":
        """The candidates that a mask or an index selects."""
        return Candidates(self.state[keep], self.a[keep], self.b[keep], self.direction[keep], self.need[keep])


def gaps(sets: ConvexSets, frames: Frames, candidates: Candidates, iterations: int = 4) -> Float32Array:
    """Lower bounds of the distances of part pairs, improved until they are enough or the iterations end.

    Args:
        sets: The parts.
        frames: Where the frames are in each state.
        candidates: The pairs, and the gap each needs.
        iterations: Directions to try.

    Returns:
        (T,) in [m]: a pair is at least this far apart; at or below zero nothing is proven.
    """
    compiled, found = kernels(), np.empty(len(candidates.state), dtype=np.float32)
    if compiled is None:
        return _gaps(sets, frames, candidates, iterations)
    poses, given = frames.poses, (candidates.state, candidates.a, candidates.b)
    state, a, b = (np.ascontiguousarray(each, dtype=np.int64) for each in given)
    direction, need = (np.ascontiguousarray(e, np.float32) for e in (candidates.direction, candidates.need))
    compiled.separation_gaps(
        address(sets.table), address(poses), len(poses), poses.shape[3], address(state), address(a),
        address(b), len(state), address(direction), address(need), iterations, address(found),
    )  # fmt: skip
    return found


# -- the twin


def _gaps(sets: ConvexSets, frames: Frames, candidates: Candidates, iterations: int) -> Float32Array:
    """Bound the gap of each pair from below, as the kernel does."""
    best = np.full(len(candidates.state), -np.inf, dtype=np.float32)
    open_ = np.arange(len(best))
    both = _Placed.of(sets, frames, candidates)
    slack = sets.slack.take(candidates.a) + sets.slack.take(candidates.b)
    enough = candidates.need + slack
    direction = _units(candidates.direction)
    point: Float32Array | None = None
    for iteration in range(iterations):
        corner = both.difference(direction)
        gap = np.einsum("ij,ij->i", corner, direction)
        best[open_] = np.maximum(best[open_], gap - slack)
        keep = np.flatnonzero(gap <= enough)
        if not len(keep) or iteration == iterations - 1:
            break
        if point is None:
            point = both.between_centres()
        if len(keep) < len(gap):
            open_, slack, enough = open_[keep], slack[keep], enough[keep]
            point, corner, both = point[keep], corner[keep], both.subset(keep)
        point = _closest_on_segment(point, corner)
        direction = _units(point)
    return best


@dataclass(frozen=True, eq=False)
class _Placed:
    """The parts of T pairs, all first ones before all second ones, with the poses of their frames."""

    sets: ConvexSets
    part: IntArray
    pose: Float32Array

    @staticmethod
    def of(sets: ConvexSets, frames: Frames, candidates: Candidates) -> "_Placed":
        part = np.concatenate([candidates.a, candidates.b])
        state = np.concatenate([candidates.state, candidates.state])
        return _Placed(sets, part, frames.poses[sets.frame.take(part), :, :, state])

    def subset(self, keep: IntArray) -> "_Placed":
        keep = np.concatenate([keep, keep + len(self.part) // 2])
        return _Placed(self.sets, self.part.take(keep), self.pose.take(keep, axis=0))

    def between_centres(self) -> Float32Array:
        """From the second part's centre to the first one's, (T, 3) in the base."""
        return self._difference(self.sets.centre.take(self.part, axis=0))

    def difference(self, direction: Float32Array) -> Float32Array:
        """The point of A - B that lies farthest back along a direction, (T, 3) in the base."""
        outward = np.concatenate([-direction, direction])
        local = np.einsum("ti,tij->tj", outward, self.pose[:, :, :3])
        along = np.einsum("ti,tiv->tv", local, self.sets.vertices.take(self.part, axis=0))
        farthest = self.part * along.shape[1] + along.argmax(axis=1)
        return self._difference(self.sets.corners.take(farthest, axis=0))

    def _difference(self, points: Float32Array) -> Float32Array:
        placed = np.einsum("tij,tj->ti", self.pose[:, :, :3], points)
        placed += self.pose[:, :, 3]
        half = len(placed) // 2
        return placed[:half] - placed[half:]


def _units(vectors: Float32Array) -> Float32Array:
    lengths = np.sqrt(np.einsum("ij,ij->i", vectors, vectors))[:, None]
    upward = np.array([0, 0, 1], dtype=np.float32)
    return np.where(lengths > 1e-7, vectors / np.maximum(lengths, np.float32(1e-7)), upward)


def _closest_on_segment(a: Float32Array, b: Float32Array) -> Float32Array:
    edge = b - a
    length = np.maximum(np.einsum("ij,ij->i", edge, edge), np.float32(1e-14))
    t = np.clip(-np.einsum("ij,ij->i", a, edge) / length, 0, 1)
    return a + t[:, None] * edge
