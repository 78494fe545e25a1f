"""Proof that a straight joint-space edge is free between its samples too.

An edge is covered by intervals. Where a part pair is farther apart in the middle state of an interval than
the motion within it can bring the two together, the pair is done there; the pairs that are left go on to the
pieces of it, all intervals of all edges in one batch, until everything is proven or a contact is found.
"""

from dataclasses import dataclass

import numpy as np

from topple.planner.motion.collision import Checker, Contact
from topple.planner.motion.model import CollisionModel
from topple.planner.motion.tolerances import DEPTH, DIRECTIONS, FINEST, FIRST, PIECES
from topple.robots.arm.kinematics import Chain
from topple.robots.collision.separation import Candidates, Float32Array, Frames, gaps
from topple.robots.collision.tolerances import ROUNDING
from topple.topology.base.arrays import BoolArray, FloatArray, IntArray
from topple.topology.kernels.compiled import address, kernels


@dataclass(frozen=True, eq=False)
class Certificate:
    """What is known of an edge.

    Attributes:
        proven: Whether it is free everywhere, with at least the clearance asked for.
        clearance: A lower bound in [m] of the distance, all along, of what moves to the obstacles (of the
            arm's own links to each other where there are none); 0 where not proven.
        contact: What comes too close, where something does.
        state: (n,) where that is.
    """

    proven: bool
    clearance: float
    contact: Contact | None = None
    state: FloatArray | None = None


@dataclass(frozen=True, eq=False)
class _Intervals:
    edge: IntArray
    middle: FloatArray  # position on the edge, 0 to 1
    half: FloatArray  # half the length, on the same scale

    def pieces(self, which: IntArray) -> "_Intervals":
        half = self.half[which] / PIECES
        offsets = np.arange(1 - PIECES, PIECES, 2)
        middle = self.middle[which][:, None] + half[:, None] * offsets
        return _Intervals(np.repeat(self.edge[which], PIECES), middle.ravel(), np.repeat(half, PIECES))


class Certifier:
    """Certifies edges against a checker's scene."""

    def __init__(self, checker: Checker) -> None:
        """Prepare for a checker; it may be used for many edges."""
        self._checker = checker
        self._model = checker.model
        self._chain = checker.arm.chain
        self._bounds = MotionBounds(checker.model, checker.arm.chain)
        m, s = np.nonzero(checker.model.standing_pairs)
        pairs = checker.model.moving_pairs
        self._a = np.concatenate([checker.model.moving[m], pairs[:, 0]])
        self._b = np.concatenate([checker.model.standing[s], pairs[:, 1]])
        wanted = checker.model.margin
        self._margin = (wanted[self._a] + wanted[self._b]).astype(np.float32)
        against = checker.model.obstacle[self._a] | checker.model.obstacle[self._b]
        self._stated = against if against.any() else np.ones(len(against), dtype=np.bool_)

    def certify(
        self, starts: FloatArray, ends: FloatArray, clearance: float = 0.0
    ) -> tuple[Certificate, ...]:
        """Prove edges free.

        Args:
            starts: (e, n) one end of each edge.
            ends: (e, n) the other end.
            clearance: Distance in [m] to be proven for every checked pair, on top of the checker's margin.

        Returns:
            A certificate for each edge.
        """
        work = _Work(starts, ends, np.full(len(starts), np.inf), {})
        intervals = _first(starts, ends)
        index = np.arange(len(intervals.edge))
        item = np.repeat(index, len(self._a))
        pair = np.tile(np.arange(len(self._a)), len(index))
        for depth in range(DEPTH):
            item, pair = self._level(work, intervals, item, pair, clearance, last=depth == DEPTH - 1)
            if not len(item):
                break
            which, position = np.unique(item, return_inverse=True)
            intervals = intervals.pieces(which)
            item = (PIECES * position[:, None] + np.arange(PIECES)).ravel()
            pair = np.repeat(pair, PIECES)
        return tuple(work.certificate(edge) for edge in range(len(starts)))

    def path(self, path: FloatArray, clearance: float = 0.0) -> Certificate:
        """Certify a path (k, n): the least clearance if all are proven, or the first failure."""
        if len(path) < 2:
            path = np.concatenate([path, path])
        found = self.certify(path[:-1], path[1:], clearance)
        failed = next((certificate for certificate in found if not certificate.proven), None)
        return failed or Certificate(True, min(certificate.clearance for certificate in found))

    def _level(
        self,
        work: "_Work",
        intervals: _Intervals,
        item: IntArray,
        pair: IntArray,
        clearance: float,
        last: bool,
    ) -> tuple[IntArray, IntArray]:
        """Treat all open (interval, pair) items of one size; returns those left for the pieces."""
        way = work.ends[intervals.edge] - work.starts[intervals.edge]
        middle = work.starts[intervals.edge] + intervals.middle[:, None] * way
        poses = self._chain.poses(middle)
        spans = (np.abs(way) * intervals.half[:, None]).astype(np.float32)
        wanted = self._margin[pair] + np.float32(clearance + 2 * ROUNDING)
        queries = Queries(item, self._a[pair], self._b[pair], wanted)
        motion, gap = self._bounds.of(Frames.of(poses), spans, queries)
        proven = gap > motion + wanted
        sure, open_ = np.flatnonzero(proven), np.flatnonzero(~proven)
        self._note(work, intervals.edge[item[sure]], pair[sure], (gap - motion)[sure])
        touching = gap[open_] <= self._margin[pair[open_]] + clearance
        fine = (motion[open_] < FINEST) | last
        asked = np.flatnonzero(touching | fine)
        settled = self._ask(work, intervals, middle, poses, item, pair, motion, open_[asked], clearance, last)
        keep = np.ones(len(open_), dtype=np.bool_)
        keep[asked[settled]] = False
        keep &= ~np.isin(intervals.edge[item[open_]], list(work.failed))
        return item[open_[keep]], pair[open_[keep]]

    def _ask(
        self,
        work: "_Work",
        intervals: _Intervals,
        middle: FloatArray,
        poses: FloatArray,
        item: IntArray,
        pair: IntArray,
        motion: Float32Array,
        open_: IntArray,
        clearance: float,
        last: bool,
    ) -> BoolArray:
        """Let python-fcl decide open items: a contact ends the edge, a distance may prove the item."""
        settled = np.zeros(len(open_), dtype=np.bool_)
        order = np.argsort(item[open_], kind="stable")
        if len(open_):
            self._checker.exact.load(poses[..., np.unique(item[open_])])
        row, current = -1, -1
        for k in order.tolist():
            i, p = int(item[open_[k]]), int(pair[open_[k]])
            row, current = (row, current) if i == current else (row + 1, i)
            edge = int(intervals.edge[i])
            if edge in work.failed:
                continue
            a, b = int(self._a[p]), int(self._b[p])
            self._checker.exact.place(row, a, b)
            distance = self._checker.exact.distance(a, b)
            wanted = float(self._margin[p]) + clearance
            if distance > wanted + float(motion[open_[k]]):
                settled[k] = True
                left = np.array([distance - float(motion[open_[k]])])
                self._note(work, np.array([edge]), np.array([p]), left)
            elif distance <= wanted or last:
                names = self._model.names
                work.failed[edge] = (Contact(names[a], names[b], distance), middle[i])
        return settled

    def _note(
        self, work: "_Work", edges: IntArray, pairs: IntArray, distances: FloatArray | Float32Array
    ) -> None:
        stated = self._stated[pairs]
        work.note(edges[stated], distances[stated])


@dataclass(frozen=True, eq=False)
class _Work:
    """The edges, and what has been found out about each."""

    starts: FloatArray
    ends: FloatArray
    clearance: FloatArray
    failed: dict[int, tuple[Contact, FloatArray]]

    def note(self, edges: IntArray, distances: FloatArray | Float32Array) -> None:
        np.minimum.at(self.clearance, edges, distances)

    def certificate(self, edge: int) -> Certificate:
        if edge in self.failed:
            contact, state = self.failed[edge]
            return Certificate(False, 0.0, contact, state)
        return Certificate(True, float(self.clearance[edge]))


def _first(starts: FloatArray, ends: FloatArray) -> _Intervals:
    count = np.maximum(np.ceil(np.abs(ends - starts).max(axis=1, initial=0.0) / FIRST), 1).astype(int)
    edge = np.repeat(np.arange(len(starts)), count)
    index = np.arange(len(edge)) - np.repeat(np.cumsum(count) - count, count)
    half = 0.5 / count[edge]
    return _Intervals(edge, (2 * index + 1) * half, half)


@dataclass(frozen=True, eq=False)
class Queries:
    """Part pairs a, b (T,) on intervals (T,), and how far apart [m] (T,) each is to be for any motion."""

    interval: IntArray
    a: IntArray
    b: IntArray
    wanted: Float32Array


class MotionBounds:
    """Bounds on the motion of every part relative to every frame nearer the base.

    Turning joint j by at most d moves a point at distance r from its axis by at most r d. Taking the joints
    from the part towards the base, the axis of each is where it is in the middle state while the farther
    joints have moved the point by what they can, so the bound is a sum of d (r + the bound so far).
    """

    def __init__(self, model: CollisionModel, chain: Chain) -> None:
        self._sets = model.sets
        self._revolute = chain.revolute
        self._axes = chain.axes.astype(np.float32)

    def of(self, frames: Frames, spans: Float32Array, asked: Queries) -> tuple[Float32Array, Float32Array]:
        """By how much motion brings parts together, and how far apart they are in the middle.

        Args:
            frames: Where the frames are in the m middle states.
            spans: (m, n) by how much each joint may differ from the middle state.
            asked: The pairs.

        Returns:
            (T,) bounds of the motion [m] and (T,) of the distance [m], by bounding volumes where they vouch
            for enough.
        """
        compiled, poses = kernels(), frames.poses
        if compiled is None:
            return self._by_twin(frames, spans, asked)
        motion, apart = np.empty(len(asked.a), np.float32), np.empty(len(asked.a), np.float32)
        compiled.separation_intervals(
            address(self._sets.table), address(poses), len(poses), poses.shape[3], address(self._axes),
            address(self._revolute), address(spans), address(asked.interval), address(asked.a),
            address(asked.b), len(asked.a), address(asked.wanted), DIRECTIONS, address(motion),
            address(apart),
        )  # fmt: skip
        return motion, apart

    # -- the twin

    def _by_twin(
        self, frames: Frames, spans: Float32Array, asked: Queries
    ) -> tuple[Float32Array, Float32Array]:
        sets, item, a, b = self._sets, asked.interval, asked.a, asked.b
        centres = frames.points(sets.frame, sets.centre)
        near = np.minimum(sets.frame[a], sets.frame[b])
        far = np.where(sets.frame[a] > sets.frame[b], a, b)
        motion = self._motion_bounds(frames, spans, centres)[near, far, item]
        need = motion + asked.wanted
        direction, apart = self._spheres(centres, item, a, b)
        left = np.flatnonzero(apart <= need)
        candidates = Candidates(item[left], a[left], b[left], direction[left], need[left])
        apart[left] = gaps(sets, frames, candidates, iterations=DIRECTIONS)
        return motion, apart

    def _motion_bounds(self, frames: Frames, spans: Float32Array, centres: Float32Array) -> Float32Array:
        """Bounds of the motion in m states.

        Args:
            frames: Where the frames are in the m middle states.
            spans: (m, n) by how much each joint may differ from the middle state.
            centres: (3, P, m) sphere centres of all parts in the base.

        Returns:
            (n + 1, P, m) in [m]: entry f bounds the motion of a part as seen from frame f, 0 where the part
            is carried by that frame or one nearer the base.
        """
        count, joints = spans.shape
        result = np.zeros((joints + 1, len(self._sets.frame), count), dtype=np.float32)
        axes = np.einsum("jabm,jb->jam", frames.poses[1:, :, :3], self._axes)
        for j in range(joints - 1, -1, -1):
            # parts are not sorted by frame: those beyond the joint are picked
            beyond = np.flatnonzero(self._sets.frame > j)
            span = spans[:, j]
            moved = result[j + 1, beyond]
            if self._revolute[j]:
                arms = centres[:, beyond] - frames.poses[j + 1, :, 3][:, None]
                along = np.einsum("apm,am->pm", arms, axes[j])
                squared = np.einsum("apm,apm->pm", arms, arms) - along * along
                radius = np.sqrt(np.maximum(squared, 0)) + self._sets.radius[beyond, None]
                moved += span * (radius + moved)
            else:
                moved += span
            result[j, beyond] = moved
        return result

    def _spheres(
        self, centres: Float32Array, item: IntArray, a: IntArray, b: IntArray
    ) -> tuple[Float32Array, Float32Array]:
        """First directions, and distances that bounding volumes vouch for."""
        sets = self._sets
        centre, other = centres[:, a, item].T, centres[:, b, item].T
        standing = sets.frame[b] == 0
        boxed = np.clip(centre, sets.lower[b], sets.upper[b])
        direction = centre - np.where(standing[:, None], boxed, other)
        apart = np.sqrt(np.einsum("ij,ij->i", direction, direction))
        apart -= sets.radius[a] + np.where(standing, 0, sets.radius[b])
        inside = ~direction.any(axis=1)
        direction[inside] = (centre - other)[inside]
        return direction, apart
