"""Seeded RRT-Connect (Kuffner and LaValle 2000) that extends a dozen branches with each collision check."""

from collections.abc import Callable
from typing import Protocol

import numpy as np

from topple.planner.budget import check_budget
from topple.planner.motion.tolerances import ROUNDS
from topple.robots.arm.arm import Arm
from topple.topology.base.arrays import BoolArray, FloatArray, IntArray


class EdgeChecker(Protocol):
    """What a search asks: a `Checker`, or one that refuses more."""

    @property
    def arm(self) -> Arm:
        """The arm."""
        ...

    def edges_free(self, starts: FloatArray, ends: FloatArray) -> BoolArray:
        """Which straight edges (e, n) are free."""
        ...


Projection = Callable[[FloatArray], FloatArray]
"""States (m, n) to the nearest ones that keep a constraint."""


BATCH = 12
"""Branches in one collision check; numpy then costs little more than for one."""

REACH = 1.0
"""Longest branch [rad], in the Euclidean norm over the joints."""


class Tree:
    """Joint states with parents, grown from one or more roots."""

    def __init__(self, roots: FloatArray) -> None:
        """Start a tree from (r, n) roots."""
        self._states = np.empty((max(256, 2 * len(roots)), roots.shape[1]))
        self._parents: list[int] = []
        for root in roots:
            self.add(root, -1)

    @property
    def states(self) -> FloatArray:
        """(k, n) states of the nodes, in the order they were added."""
        return self._states[: len(self._parents)]

    def add(self, state: FloatArray, parent: int) -> int:
        """Add a node and return its index; a root has the parent -1."""
        index = len(self._parents)
        if index == len(self._states):
            self._states = np.concatenate([self._states, np.empty_like(self._states)])
        self._states[index] = state
        self._parents.append(parent)
        return index

    def nearest(self, states: FloatArray) -> IntArray:
        """Index of the node nearest to each of (m, n) states."""
        nodes = self.states
        squared = np.sum(nodes**2, axis=1) - 2 * states @ nodes.T
        return np.argmin(squared, axis=1)

    def path(self, node: int) -> FloatArray:
        """(k, n) states from the root to a node."""
        states: list[FloatArray] = []
        while node >= 0:
            states.append(self._states[node])
            node = self._parents[node]
        return np.array(states[::-1])


def rrt_connect(
    checker: EdgeChecker,
    start: FloatArray,
    goals: FloatArray,
    *,
    seed: int,
    rounds: int = ROUNDS,
    reach: float = REACH,
    project: Projection | None = None,
) -> FloatArray | None:
    """A path from the start to one of the goals.

    Args:
        checker: Collision checker.
        start: (n,) a free state.
        goals: (g, n) free states.
        seed: Seed of the samples.
        rounds: Batches of branches before giving up.
        reach: Longest branch [rad].
        project: Brings samples and ends of branches to states that keep a constraint.

    Returns:
        (k, n) path, or None where none was found.

    Raises:
        OutOfBudget: The budget of the call ran out.
    """
    rng = np.random.default_rng(seed)
    ours, theirs = Tree(start[None]), Tree(goals)
    forward = True
    for _ in range(rounds):
        check_budget()
        samples = rng.uniform(checker.arm.lower, checker.arm.upper, (BATCH, len(start)))
        samples = samples if project is None else project(samples)
        added = _extend(checker, ours, samples, reach, project)
        joined = _connect(checker, ours, added, theirs, reach, project)
        if joined is not None:
            first, second = (ours, theirs) if forward else (theirs, ours)
            a, b = joined if forward else joined[::-1]
            path = np.concatenate([first.path(a), second.path(b)[::-1]])
            return path[np.concatenate([[True], np.abs(np.diff(path, axis=0)).max(axis=1) > 1e-9])]
        # grow the smaller tree next: the one in the narrower place gets the most help
        if len(ours.states) > len(theirs.states):
            ours, theirs, forward = theirs, ours, not forward
    return None


def _extend(
    checker: EdgeChecker, tree: Tree, samples: FloatArray, reach: float, project: Projection | None
) -> list[int]:
    nearest = tree.nearest(samples)
    starts = tree.states[nearest].copy()
    ends = _towards(starts, samples, reach)
    ends = ends if project is None else project(ends)
    free = checker.edges_free(starts, ends)
    return [tree.add(end, int(parent)) for end, parent in zip(ends[free], nearest[free], strict=True)]


def _connect(
    checker: EdgeChecker,
    ours: Tree,
    added: list[int],
    theirs: Tree,
    reach: float,
    project: Projection | None,
) -> tuple[int, int] | None:
    """Grow the other tree towards new nodes, step by step, as long as a step is free."""
    goals = ours.states[added].copy()
    heads = theirs.nearest(goals) if added else np.empty(0, dtype=np.int64)
    nodes = list(added)
    while len(heads):
        starts = theirs.states[heads].copy()
        ends = _towards(starts, goals, reach)
        free = np.ones(len(ends), dtype=np.bool_)
        if project is not None:  # a branch that is turned back to where it came from leads nowhere
            ends = project(ends)
            gain = np.linalg.norm(goals - starts, axis=1) - np.linalg.norm(goals - ends, axis=1)
            free = gain > 0.2 * np.minimum(reach, np.linalg.norm(goals - starts, axis=1))
        free[free] = checker.edges_free(starts[free], ends[free])
        arrived = np.flatnonzero(free & (np.abs(ends - goals).max(axis=1) < 1e-12))
        if len(arrived):
            return nodes[int(arrived[0])], int(heads[arrived[0]])
        grown = [theirs.add(end, int(head)) for end, head in zip(ends[free], heads[free], strict=True)]
        heads, goals = np.array(grown, dtype=np.int64), goals[free]
        nodes = [node for node, ok in zip(nodes, free, strict=True) if ok]
    return None


def _towards(starts: FloatArray, ends: FloatArray, reach: float) -> FloatArray:
    way = ends - starts
    length = np.linalg.norm(way, axis=1, keepdims=True)
    return np.where(length > reach, starts + way * (reach / np.maximum(length, 1e-12)), ends)
