"""A body inside a cloud's hull and one around it: what they settle needs no hull.

A hull costs more than anything that is asked of it once or twice. Its extent along a few directions and the
hull of a few of its points cost little, and most questions about depth are far from where the two disagree.
Where they are not, the two are brought closer to each other at that place, as the expanding polytope
algorithm does it (van den Bergen 2001).
"""

import numpy as np

from topple.topology.base.arrays import BoolArray, FloatArray
from topple.topology.geometry.hull import Hull

SMALL = 1000
"""Points up to which a cloud's own hull costs no more than that of a few of its points."""
SPREAD = 300
"""Points spread over a cloud whose hull, with the extremes, is the inner body: 2 sigma of the noise out."""
BLOCK = 1 << 13
"""Points looked at once: thirteen rows of so many numbers stay in a core's own cache."""
SLACK = 1e-9
"""Lengths [m] closer than this to a limit are left to the hull itself: far above rounding."""
ROUNDS = 3
"""Times the bodies are brought closer in one place: more cost as much as the hull."""
SIDES = 4
"""Facets of the inner body pushed out at a time."""
UNDECIDED = 2000
"""Points for which the bodies are brought closer: more ask for the hull."""

_LENGTHS = np.sqrt(np.repeat([1.0, 2.0, 3.0], [3, 6, 4]))


class Bracket:
    """Bounds of a cloud's hull from within and from without; they tighten as they are asked."""

    def __init__(self, columns: FloatArray) -> None:
        """Measure a cloud along the normals of a cube's faces, edges and corners.

        Args:
            columns: (3, N) points [m], each axis contiguous.
        """
        self._columns = columns
        self._low, self._high = np.full(13, np.inf), np.full(13, -np.inf)
        least, greatest = np.zeros(13, dtype=np.int64), np.zeros(13, dtype=np.int64)
        room = _room(columns)
        for start in range(0, columns.shape[1], BLOCK):
            along = _along_directions(columns[:, start : start + BLOCK], room)
            for found, best, where, wins in (
                (along.argmin(axis=1), self._low, least, np.less),
                (along.argmax(axis=1), self._high, greatest, np.greater),
            ):
                value = along[np.arange(13), found]
                better = wins(value, best)
                best[better] = value[better]
                where[better] = found[better] + start
        self._low /= _LENGTHS
        self._high /= _LENGTHS
        self.extremes = columns[:, np.unique(np.concatenate([least, greatest]))].T
        self._inner: Hull | None = None

    @property
    def inner(self) -> Hull:
        """Hull of some of the points, of all where they are few: it lies in the cloud's own."""
        if self._inner is None:
            step = 1 if self._columns.shape[1] <= SMALL else -(-self._columns.shape[1] // SPREAD)
            self._inner = Hull.of(np.concatenate([self._columns[:, ::step].T, self.extremes]))
        return self._inner

    def nowhere_deeper(self, other: "Bracket", depth: float) -> bool:
        """Whether some direction shows that no point of another cloud lies deeper in this one's hull.

        Args:
            other: The other cloud.
            depth: Depth below the hull's surface [m].

        Returns:
            True: no point is deeper. False: not decided.
        """
        least, greatest = self._low + depth - SLACK, self._high - depth + SLACK
        return bool(((other._low >= greatest) | (other._high <= least) | (least >= greatest)).any())

    def surely_deeper(self, points: FloatArray, depth: float) -> bool:
        """Whether one of the points (N, 3) [m] is sure to lie deeper than `depth` in the hull."""
        return len(points) > 0 and bool((self.inner.facet_distance(points) < -depth - SLACK).any())

    def surely_near(self, points: FloatArray, distance: float) -> bool:
        """Whether one of the points (N, 3) [m] is sure to lie no further from the hull than `distance`."""
        return len(points) > 0 and bool((self.inner.signed_distance(points) <= distance - SLACK).any())

    def maybe_deeper(self, columns: FloatArray, depth: float) -> FloatArray:
        """Those of the points (3, N) [m] that no direction shows to lie less deep in the hull."""
        kept = np.ones(columns.shape[1], dtype=np.bool_)
        least = ((self._low + depth - SLACK) * _LENGTHS)[:, None]
        greatest = ((self._high - depth + SLACK) * _LENGTHS)[:, None]
        room = _room(columns)
        for start in range(0, len(kept), BLOCK):
            along = _along_directions(columns[:, start : start + BLOCK], room)
            kept[start : start + BLOCK] = ((along > least) & (along < greatest)).all(axis=0)
        return columns[:, kept]

    def deeper(self, columns: FloatArray, depth: float) -> bool | None:
        """Whether a point lies deeper in the hull.

        Args:
            columns: (3, N) points [m].
            depth: Depth below the hull's surface [m].

        Returns:
            The answer, or None where only the hull itself can tell.
        """
        for _ in range(ROUNDS):
            if columns.shape[1] == 0:
                return False
            if columns.shape[1] > UNDECIDED:
                return None
            inner = self.inner
            table = inner.normals @ columns + inner.offsets[:, None]
            if (table.max(axis=0) < -depth - SLACK).any():
                return True
            shallowest = np.bincount(table.argmax(axis=0), minlength=len(table))
            sides = inner.normals[np.argsort(-shallowest, kind="stable")[:SIDES]]
            columns = columns[:, self._below(sides, columns, depth)]
        return None if columns.shape[1] else False

    def _below(self, sides: FloatArray, columns: FloatArray, depth: float) -> BoolArray:
        """Which points lie deeper than the cloud's furthest along some normals (k, 3), now known."""
        furthest, where = np.full(len(sides), -np.inf), np.zeros(len(sides), dtype=np.int64)
        for start in range(0, self._columns.shape[1], BLOCK):
            along = sides @ self._columns[:, start : start + BLOCK]
            found = along.argmax(axis=1)
            value = along[np.arange(len(sides)), found]
            better = value > furthest
            furthest[better], where[better] = value[better], found[better] + start
        self._inner = Hull.of(np.concatenate([self.inner.vertices, self._columns[:, where].T]))
        return np.asarray((sides @ columns < (furthest - depth + SLACK)[:, None]).all(axis=0))


def _room(columns: FloatArray) -> FloatArray:
    """(13, n) numbers to write one block after the other into: fresh memory costs more than the sums."""
    return np.empty((13, min(BLOCK, columns.shape[1])))


def _along_directions(columns: FloatArray, room: FloatArray) -> FloatArray:
    """(13, N) coordinates of points (3, N) along the directions, times their lengths, written into `room`."""
    x, y, z = columns
    along = room[:, : len(x)]
    along[:3] = columns
    for row, (one, other) in enumerate(((x, y), (x, z), (y, z))):
        np.add(one, other, out=along[3 + 2 * row])
        np.subtract(one, other, out=along[4 + 2 * row])
    for row in (0, 1):
        np.add(along[3 + row], z, out=along[9 + 2 * row])
        np.subtract(along[3 + row], z, out=along[10 + 2 * row])
    return along
