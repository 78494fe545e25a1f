"""Search trees of points: the nearest neighbours of places and what lies within a radius of them."""

from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from topple.topology.kernels.compiled import address, kernels

if TYPE_CHECKING:
    from topple.topology.base.arrays import FloatArray, IntArray


class PointTree:
    """A search tree, with those methods of scipy's KDTree that are asked here; that one is its twin.

    Distances are the same to the last bit. Of points that are equally near the first of the cloud counts; the
    twin takes any of them. Within a radius is what is no further, up to the rounding of its square.

    Args:
        points: (N, d) points [m], d = 1, 2 or 3, finite.

    Attributes:
        data: (N, d) the points [m], not to be written to.
    """

    def __init__(self, points: "FloatArray") -> None:
        self.data = np.ascontiguousarray(points, dtype=np.float64)
        self._kernels = kernels()
        if self._kernels is None:
            from scipy.spatial import KDTree

            self._twin = KDTree(self.data)
        elif len(self.data):
            self._points = _in_space(self.data)
            sizes = np.empty(2, dtype=np.int64)
            self._kernels.tree_sizes(len(self.data), address(sizes), address(sizes[1:]))
            self._leaves, self._groups = (np.empty(int(size), dtype=np.uint8) for size in sizes)
            at = address(self._points)
            self._arrays = address(self._leaves), address(self._groups), len(self.data), at
            self._kernels.tree_build(at, len(self.data), *self._arrays[:2])

    @cached_property
    def box(self) -> "tuple[FloatArray, FloatArray]":
        """(d,) least and (d,) greatest coordinates of the points [m], of which there is one."""
        columns = self.data.T.copy()  # row by row numpy takes twenty times as long
        return columns.min(axis=1), columns.max(axis=1)

    def __reduce__(self) -> tuple[object, ...]:
        """Pickle by its points: another process may have no kernels."""
        return (PointTree, (self.data,))

    def query(
        self, places: "FloatArray", k: int = 1, distance_upper_bound: float = np.inf
    ) -> "tuple[FloatArray, IntArray]":
        """Find the nearest points of places.

        Args:
            places: (..., d) [m], finite.
            k: How many of each, 1 or more.
            distance_upper_bound: What is not nearer than this [m] is left out.

        Returns:
            (..., k) distances [m], rising, and rows of the points; infinite and N behind the last one.
            Without the last axis for k = 1.
        """
        if self._kernels is None:
            distances, rows = self._twin.query(places, k=k, distance_upper_bound=distance_upper_bound)
            return np.asarray(distances), np.asarray(rows, dtype=np.int64)
        shape = places.shape[:-1] if k == 1 else (*places.shape[:-1], k)
        if not len(self.data):
            return np.full(shape, np.inf), np.zeros(shape, dtype=np.int64)
        distances, rows = np.empty(shape), np.empty(shape, dtype=np.int64)
        asked = _in_space(places.reshape(-1, places.shape[-1]))
        self._kernels.tree_nearest(
            *self._arrays, address(asked), len(asked), k, distance_upper_bound,
            address(distances), address(rows),
        )  # fmt: skip
        return distances, rows

    def query_ball_point(self, places: "FloatArray", r: float) -> "list[IntArray]":
        """Find all points within a radius.

        Args:
            places: (N, d) [m], finite.
            r: The radius [m].

        Returns:
            For each place the rows of the points that are no further, rising.
        """
        if self._kernels is None:
            found = self._twin.query_ball_point(places, r, return_sorted=True)
            return [np.asarray(rows, dtype=np.int64) for rows in found]
        counts, rows = self._within(places, r)
        return np.split(rows, np.cumsum(counts)[:-1]) if len(counts) else []

    def query_pairs(self, r: float) -> "IntArray":
        """(P, 2) rows of all pairs of points that are no further than r [m] from each other, in any order."""
        if self._kernels is None:
            return np.asarray(self._twin.query_pairs(r, output_type="ndarray"), dtype=np.int64)
        counts, rows = self._within(self.data, r)
        first = np.repeat(np.arange(len(counts)), counts)
        return np.stack([first, rows], axis=1)[first < rows]

    def around(self, weights: "FloatArray", r: float, k: int) -> "tuple[FloatArray, FloatArray, IntArray]":
        """Look around every point, once.

        Args:
            weights: (N,) one for each point.
            r: A radius [m].
            k: How many neighbours, 2 or more.

        Returns:
            (N,) sums of the weights of all points within the radius, each itself among them; (N, k) distances
            [m] and rows of the nearest points, as `query` has them.
        """
        if self._kernels is None:
            sums, pairs = weights.copy(), self.query_pairs(r)
            for one, other in ((0, 1), (1, 0)):
                sums += np.bincount(pairs[:, one], weights=weights[pairs[:, other]], minlength=len(weights))
            return sums, *self.query(self.data, k)
        given, sums = np.ascontiguousarray(weights, dtype=np.float64), np.zeros(len(self.data))
        distances, rows = np.empty((len(sums), k)), np.empty((len(sums), k), dtype=np.int64)
        if len(sums):
            self._kernels.tree_around(
                *self._arrays, r, address(given), k, address(sums),
                address(distances), address(rows),
            )  # fmt: skip
        return sums, distances, rows

    def _within(self, places: "FloatArray", r: float) -> "tuple[IntArray, IntArray]":
        """How many points are within a radius of each place, and their rows, one place after the other."""
        asked = _in_space(places)
        counts, room = np.zeros(len(asked), dtype=np.int64), 64 * len(asked) + 1024
        if len(self.data) == 0 or self._kernels is None:
            return counts, np.empty(0, dtype=np.int64)
        while True:
            rows = np.empty(room, dtype=np.int64)
            total = self._kernels.tree_within(
                *self._arrays[:3], address(asked), len(asked), r, address(counts), address(rows), room
            )
            if total <= room:
                return counts, rows[:total]
            room = total


def _in_space(points: NDArray[Any]) -> "FloatArray":
    """(N, 3) points, those on a line or in a plane with zeros for what they have not."""
    missing = 3 - points.shape[1]
    if missing == 0:
        return np.ascontiguousarray(points, dtype=np.float64)
    return np.concatenate([points, np.zeros((len(points), missing))], axis=1, dtype=np.float64)
