"""A tree of joint states for RRT-Connect: nodes, parents, and the nearest node of many states at once."""

import numpy as np

from topple.topology.arrays import FloatArray, IntArray


class Tree:
    """States with parents, grown from one or more roots."""

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
