"""Shortening a path: the shortest way through its own points, with edges checked only when they matter."""

from collections.abc import Callable
from itertools import pairwise

import numpy as np

from topple.planner.motion.tolerances import POINTS, SHORTCUT_ROUNDS, TRIES
from topple.topology.base.arrays import BoolArray, FloatArray

EdgesFree = Callable[[FloatArray, FloatArray], BoolArray]


def shortcut(path: FloatArray, edges_free: EdgesFree, *, trusted: bool = True) -> FloatArray | None:
    """Shorten a free path.

    It is divided into points, and the shortest way through them from start to end is found, taking every
    connection for free until it lies on the best way and is checked (LazySP, Dellin and Srinivasa 2016).

    Args:
        path: (k, n) waypoints.
        edges_free: Tells which edges (starts (e, n), ends (e, n)) are free.
        trusted: Whether the path's own edges are taken as free; else they are asked about as well.

    Returns:
        (j, n) waypoints, the ends unchanged, no longer than the path; None where its own edges are not free
        and there is no way around them.
    """
    return path if len(path) <= 2 and trusted else _shortest(_divide(path, POINTS), edges_free, trusted)


def length(path: FloatArray) -> float:
    """Length of a path (k, n) in joint space in [rad]."""
    return float(np.linalg.norm(np.diff(path, axis=0), axis=1).sum())


def densely(path: FloatArray, step: float) -> FloatArray:
    """States on a path (k, n), its waypoints among them, at most `step` [rad] apart in any joint."""
    pieces = [path[:1]]
    for a, b in pairwise(path):
        count = max(int(np.ceil(np.abs(b - a).max() / step)), 1)
        pieces.append(a + np.arange(1, count + 1)[:, None] / count * (b - a))
    return np.concatenate(pieces)


def _divide(path: FloatArray, count: int) -> FloatArray:
    """The waypoints and, evenly between them, enough others to make about `count`."""
    steps = np.linalg.norm(np.diff(path, axis=0), axis=1)
    spacing = steps.sum() / max(count - len(path), 4)
    points: list[FloatArray] = [path[:1]]
    for a, b, step in zip(path[:-1], path[1:], steps, strict=True):
        pieces = max(int(step / spacing), 1)
        t = np.arange(1, pieces)[:, None] / pieces
        points += [a + t * (b - a), b[None]]
    return np.concatenate(points)


def _shortest(points: FloatArray, edges_free: EdgesFree, trusted: bool) -> FloatArray | None:
    count = len(points)
    cost = np.linalg.norm(points[:, None] - points[None], axis=2)
    known = np.eye(count, k=1, dtype=np.bool_) & trusted
    for _ in range(SHORTCUT_ROUNDS):
        best, ahead, behind = _best_way(cost)
        if not np.isfinite(ahead[-1]):
            return None
        edges = [(i, j) for i, j in pairwise(best) if not known[i, j]]
        if not edges:
            return points[best]
        if trusted:  # the plain check is cheap in bulk, a certificate is not: then only what is needed
            edges += _alternatives(cost, known, ahead, behind, set(edges))
        i, j = np.array(edges).T
        free = edges_free(points[i], points[j])
        known[i[free], j[free]] = True
        cost[i[~free], j[~free]] = np.inf
    cost[~known] = np.inf
    best, ahead, _ = _best_way(cost)
    return points[best] if np.isfinite(ahead[-1]) else None


def _best_way(cost: FloatArray) -> tuple[list[int], FloatArray, FloatArray]:
    """The cheapest way from first to last point, and each point's cost from the start and to the end."""
    count = len(cost)
    ahead, behind = np.full(count, np.inf), np.full(count, np.inf)
    parent = np.zeros(count, dtype=int)
    ahead[0] = behind[-1] = 0.0
    for j in range(1, count):
        through = ahead[:j] + cost[:j, j]
        parent[j] = np.argmin(through)
        ahead[j] = through[parent[j]]
    for i in range(count - 2, -1, -1):
        behind[i] = np.min(cost[i, i + 1 :] + behind[i + 1 :])
    way = [count - 1]
    while way[-1] > 0:
        way.append(int(parent[way[-1]]))
    return way[::-1], ahead, behind


def _alternatives(
    cost: FloatArray, known: BoolArray, ahead: FloatArray, behind: FloatArray, taken: set[tuple[int, int]]
) -> list[tuple[int, int]]:
    """Unknown edges on the next best ways: likely needed when the best way turns out blocked."""
    through = np.triu(ahead[:, None] + cost + behind[None, :], k=2)
    through[np.tril_indices(len(cost), k=1)] = np.inf
    through[known] = np.inf
    order = np.argsort(through, axis=None)[: TRIES + len(taken)]
    pairs = [divmod(int(k), len(cost)) for k in order if np.isfinite(through.flat[k])]
    return [pair for pair in pairs if pair not in taken][:TRIES]
