"""Which pairs of boxes are near each other, without looking at all of them."""

from collections.abc import Sequence

import numpy as np

from topple.topology.base.arrays import FloatArray, IntArray


def near_pairs(lower: FloatArray, upper: FloatArray, reach: float) -> IntArray:
    """Pairs of axis-aligned boxes no further than `reach` apart along every axis, by sort and sweep.

    Boxes are sorted along the axis on which they spread most relative to their size; each is compared
    with those that start before it ends.

    Args:
        lower: (n, 3) least corners [m].
        upper: (n, 3) greatest corners [m].
        reach: Largest distance along an axis [m].

    Returns:
        (p, 2) positions i < j, sorted.
    """
    if len(lower) < 2:
        return np.zeros((0, 2), dtype=np.int64)
    width = (upper - lower).mean(axis=0) + reach
    axis = int(np.argmax(np.ptp(lower, axis=0) / np.maximum(width, 1e-12)))
    order = np.argsort(lower[:, axis], kind="stable")
    low, high = lower[order], upper[order] + reach
    last = np.searchsorted(low[:, axis], high[:, axis], side="right")
    following = last - np.arange(1, len(order) + 1)
    first = np.repeat(np.arange(len(order)), following)
    starts = np.repeat(np.cumsum(following) - following, following)
    second = first + 1 + np.arange(len(first)) - starts
    kept = ((low[first] <= high[second]) & (low[second] <= high[first])).all(axis=1)
    pairs = np.sort(np.stack([order[first[kept]], order[second[kept]]], axis=1), axis=1)
    return pairs[np.lexsort((pairs[:, 1], pairs[:, 0]))]


def near_both_ways(boxes: Sequence[tuple[FloatArray, FloatArray]], reach: float) -> list[tuple[int, int]]:
    """The same pairs both ways round: (i, j) and (j, i), sorted.

    Args:
        boxes: Least and greatest corners (d,) of each [m].
        reach: Largest distance along an axis [m].
    """
    if not boxes:
        return []
    lower, upper = np.array(boxes).swapaxes(0, 1)
    found = near_pairs(lower, upper, reach).tolist()
    return sorted([(i, j) for i, j in found] + [(j, i) for i, j in found])
