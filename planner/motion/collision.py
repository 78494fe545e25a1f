"""Batched exact collision checks: bounding volumes, then separating directions, python-fcl for the rest."""

from collections.abc import Collection
from copy import copy
from dataclasses import dataclass, replace

import numpy as np

from topple.planner.motion.exact import ExactPhase
from topple.planner.motion.model import Attachment, CollisionModel
from topple.planner.motion.open_pairs import OpenPairs
from topple.planner.motion.tolerances import EDGE_STEP, ROUNDED
from topple.robots.arm.arm import Arm
from topple.robots.arm.gripper import ToolState
from topple.topology.base.arrays import BoolArray, FloatArray, IntArray
from topple.topology.bodies.solids import Solids

BATCH = 1024  # states per batch: the arrays of one batch stay within the processor's cache
SMALL = 96  # states that cost little more than a few: such a batch is not divided
FAR = 1e3  # [m] where nothing is


@dataclass(frozen=True)
class Contact:
    """Two things that touch in a state.

    Attributes:
        a: Name of a link or of what is held.
        b: Name of the other link, or of the obstacle.
        distance: In [m], negative where they overlap.
    """

    a: str
    b: str
    distance: float


class Checker:
    """Tells which states and straight joint-space edges are free of collision.

    A state is free where no checked pair of parts touches; with a margin, where nothing comes closer than the
    margin to an obstacle. The answer is that of python-fcl on the exact hulls, whichever stage gives it.

    Attributes:
        arm: The arm.
        model: Parts and pairs.
        tool_state: How the hand stands.
        attached: What it holds, if anything.
        margin: Wanted distance from obstacles in [m].
        allow: Pairs of names that may touch.
    """

    def __init__(
        self,
        arm: Arm,
        pose_base_to_world: FloatArray,
        obstacles: Solids,
        *,
        tool_state: ToolState | None = None,
        attached: Attachment | None = None,
        allow: Collection[frozenset[str]] = (),
        margin: float = 0.0,
    ) -> None:
        """Prepare a checker.

        Args:
            arm: The arm.
            pose_base_to_world: (4, 4).
            obstacles: By name convex parts (V, 3) in the world [m].
            tool_state: How the hand stands; open if not given.
            attached: What it holds.
            allow: Pairs of names (links, obstacles, what is held) that may touch.
            margin: Wanted distance from obstacles in [m].

        Raises:
            InvalidInput: If an obstacle has no finite points or shares a link's name.
        """
        self.arm, self.margin = arm, margin
        self.tool_state, self.attached = tool_state or arm.open_hand, attached
        self.allow = frozenset(allow)
        self.model = CollisionModel.of(
            arm, pose_base_to_world, obstacles, self.tool_state, attached, allow, margin
        )
        self._open = OpenPairs(self.model)
        self.exact = ExactPhase(self.model)

    def at_distance(self, clearance: float, states: FloatArray | None = None) -> "Checker":
        """The same checks with a larger distance from obstacles, where the states have it.

        Args:
            clearance: Wanted distance from obstacles in [m].
            states: (m, n) states that have to stay free: of a part nearer to one of them than the clearance,
                only the distance it has there is wanted.

        Returns:
            A checker that wants the clearance, or less from some parts, but never less than this one.
        """
        least = self.model.margin
        wanted = np.maximum(least, np.where(self.model.obstacle, clearance, 0.0))
        stricter = self._with_margins(wanted)
        if states is None:
            return stricter
        state, a, b = stricter._hits(states, np.arange(len(states)), every=True)
        if not len(state):
            return stricter
        self.exact.load(self.arm.chain.poses(states))
        for s, i, j in zip(state.tolist(), a.tolist(), b.tolist(), strict=True):
            part = j if self.model.obstacle[j] else i
            self.exact.place(s, i, j)
            wanted[part] = min(wanted[part], self.exact.distance(i, j) - ROUNDED)
        return self._with_margins(np.maximum(least, wanted))

    def _with_margins(self, margin: FloatArray) -> "Checker":
        """A checker of the same parts and pairs with other margins."""
        other = copy(self)
        other.model = replace(self.model, margin=margin)
        other._open = OpenPairs(other.model)
        return other

    def free(self, q: FloatArray) -> BoolArray:
        """Which states are free.

        Args:
            q: (m, n) or (n,) joint values.

        Returns:
            (m,) booleans.
        """
        q = np.atleast_2d(q)
        return self.groups_free(q, np.arange(len(q)), len(q))

    def hand_meets(self, pose_flange_to_base: FloatArray) -> list[tuple[str, str] | None]:
        """Find obstacles that the last frame's load meets, wherever the arm behind it may be.

        Args:
            pose_flange_to_base: (m, 4, 4) poses of that frame.

        Returns:
            For each pose a pair of names that touch, or None. Where there is one, no state that brings the
            hand there is free.
        """
        last, count = len(self.arm.joints), len(pose_flange_to_base)
        poses = np.full((last + 1, 3, 4, count), FAR)
        poses[0] = np.eye(3, 4)[:, :, None]
        poses[last] = pose_flange_to_base[:, :3].transpose(1, 2, 0)
        met: list[tuple[str, str] | None] = [None] * count
        found = self._hits_at(poses, np.arange(count), carried=True)
        for state, a, b in np.stack(found, axis=1).tolist():
            met[state] = (self.model.names[a], self.model.names[b])
        return met

    def witness(self, q: FloatArray) -> tuple[str, str] | None:
        """Name the deepest pair in collision in a state; None where the state is free."""
        found = self.contacts(q)
        return (found[0].a, found[0].b) if found else None

    def contacts(self, q: FloatArray) -> tuple[Contact, ...]:
        """All pairs that touch in a state (n,), deepest first."""
        q = np.atleast_2d(q)
        state, a, b = self._hits(q[:1], np.zeros(1, dtype=np.int64), every=True)
        if not len(state):
            return ()
        self.exact.load(self.arm.chain.poses(q[:1]))
        self.exact.place(0, *a.tolist(), *b.tolist())
        names = self.model.names
        found: dict[tuple[str, str], float] = {}
        for i, j in zip(a.tolist(), b.tolist(), strict=True):
            pair = names[i], names[j]
            found[pair] = min(self.exact.distance(i, j), found.get(pair, np.inf))
        return tuple(
            sorted((Contact(*pair, d) for pair, d in found.items()), key=lambda c: (c.distance, c.a, c.b))
        )

    def edge_free(self, a: FloatArray, b: FloatArray, step: float = EDGE_STEP) -> bool:
        """Whether the states on the straight edge from a to b, both (n,), at most `step` apart, are free."""
        return bool(self.edges_free(a[None], b[None], step)[0])

    def edges_free(self, starts: FloatArray, ends: FloatArray, step: float = EDGE_STEP) -> BoolArray:
        """Which straight edges are free at all states sampled on them.

        Args:
            starts: (e, n) one end of each edge.
            ends: (e, n) the other end.
            step: Largest joint change between samples in [rad] or [m].

        Returns:
            (e,) booleans. Between the samples nothing is promised; a `Certifier` does that.
        """
        length = np.abs(ends - starts).max(axis=1, initial=0.0)
        count = np.ceil(length / step).astype(int) + 1
        free = np.ones(len(starts), dtype=np.bool_)
        # coarse samples first: an edge that hits something large is gone after an eighth of the work
        for phase in _phases(count):
            edge, t = phase
            alive = free[edge]
            edge, t = edge[alive], t[alive]
            states = starts[edge] + t[:, None] * (ends[edge] - starts[edge])
            free &= self.groups_free(states, edge, len(free))
        return free

    def groups_free(self, q: FloatArray, group: IntArray, count: int) -> BoolArray:
        """Which groups of states are free as a whole; one hit settles a group.

        Args:
            q: (m, n) joint values.
            group: (m,) the group of each state, 0 to `count` - 1.
            count: How many groups there are.

        Returns:
            (count,) booleans; a group without states is free.
        """
        free = np.ones(count, dtype=np.bool_)
        for first in range(0, len(q), BATCH):
            some = slice(first, first + BATCH)
            state, _, _ = self._hits(q[some], group[some])
            free[group[some][state]] = False
        return free

    def _hits(
        self, q: FloatArray, owner: IntArray, every: bool = False
    ) -> tuple[IntArray, IntArray, IntArray]:
        """For each owner of states (m,) one of them that is in collision, and a pair that shows it.

        With `every`, all states in collision and all pairs.
        """
        return self._hits_at(self.arm.chain.poses(q), owner, every)

    def _hits_at(
        self, poses: FloatArray, owner: IntArray, every: bool = False, carried: bool = False
    ) -> tuple[IntArray, IntArray, IntArray]:
        """The same for frames (n + 1, 3, 4, m); with `carried` for what the last one carries alone."""
        state, a, b = self._open.among(poses, carried)  # likeliest pairs first: one hit settles an owner
        if not len(state):
            return state, a, b
        margin = (self.model.margin[a] + self.model.margin[b]).tolist()
        which, row = np.unique(state, return_inverse=True)
        self.exact.load(poses[..., which])
        hits: list[tuple[int, int, int]] = []
        settled: set[int] = set()
        columns = (row, owner[state], state, a, b)
        for (r, whose, s, i, j), wanted in zip(np.stack(columns, axis=1).tolist(), margin, strict=True):
            if whose in settled and not every:
                continue
            self.exact.place(r, i, j)
            if self.exact.touches(i, j, wanted):
                hits.append((s, i, j))
                settled.add(whose)
        found = np.array(hits, dtype=np.int64).reshape(-1, 3)
        return found[:, 0], found[:, 1], found[:, 2]


def _phases(count: IntArray) -> list[tuple[IntArray, FloatArray]]:
    """Samples of edges with `count` states each, as (edge, position 0..1): every eighth first."""
    edge = np.repeat(np.arange(len(count)), count)
    first = np.repeat(np.cumsum(count) - count, count)
    index = np.arange(len(edge)) - first
    t = index / np.maximum(count[edge] - 1, 1)
    if len(edge) <= SMALL:
        return [(edge, t)]
    coarse = (index % 8 == 4) | (count[edge] <= 8)
    return [(edge[coarse], t[coarse]), (edge[~coarse], t[~coarse])]
