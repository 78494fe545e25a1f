"""What is between two open pads: how wide it is there, and how well opposed faces would hold it."""

from dataclasses import dataclass

import numpy as np

from topple.planner.grasp.hand import HandShape
from topple.planner.grasp.tolerances import (
    EDGE,
    FEW,
    NORMAL_BIAS,
    ROD,
    SLICES,
    SLOPE_LENGTH,
    SLOPED,
    GraspTolerances,
)
from topple.topology.base.arrays import BoolArray, FloatArray, IntArray


@dataclass(frozen=True, eq=False)
class Between:
    """Points of an object between the pads, in P hand frames at once, in each sorted along the closing axis.

    Attributes:
        points: (P, S, 3) in the hand's axes [m].
        normals: (P, S, 3) in the hand's axes.
        there: (P, S) which of them are points: rows are filled up to the longest.
    """

    points: FloatArray
    normals: FloatArray
    there: BoolArray

    def of(self, rows: IntArray | BoolArray) -> "Between":
        """Some of the frames, in the given order."""
        return Between(self.points[rows], self.normals[rows], self.there[rows])


def between(points: FloatArray, normals: FloatArray, rotations: FloatArray, inside: BoolArray) -> Between:
    """Gather what is between the pads.

    Args:
        points: (N, 3) an object's points from where the hand is turned about, in the world's axes [m].
        normals: (N, 3) its normals.
        rotations: (F, 3, 3) of the hand, columns in the world.
        inside: (F, N) which points are between the pads.

    Returns:
        The points by frame.
    """
    index, there = pack(inside)
    y = np.where(there, np.einsum("fsi,fi->fs", points[index], rotations[:, :, 1]), np.inf)
    order = np.argsort(y, axis=1, kind="stable")
    index, there = np.take_along_axis(index, order, axis=1), np.take_along_axis(there, order, axis=1)
    return Between(np.matmul(points[index], rotations), np.matmul(normals[index], rotations), there)


def pack(mask: BoolArray) -> tuple[IntArray, BoolArray]:
    """Columns that are set in each row, moved to its left.

    Args:
        mask: (F, N) any mask.

    Returns:
        (F, K) columns and which of them count; K is the largest count of a row, at least 1.
    """
    rows, columns = np.nonzero(mask)
    counts = np.count_nonzero(mask, axis=1)
    place = np.arange(len(rows)) - np.repeat(np.cumsum(counts) - counts, counts)
    index = np.zeros((len(mask), max(int(counts.max(initial=0)), 1)), dtype=np.int64)
    index[rows, place] = columns
    return index, np.arange(index.shape[1]) < counts[:, None]


def extents(y: FloatArray, window: BoolArray, tolerances: GraspTolerances) -> tuple[FloatArray, FloatArray]:
    """Bounds of the points around 0 up to a gap a finger could enter; one in fifty is left out.

    Args:
        y: (P, S) places along the closing axis, rising where they count [m].
        window: (P, S) which count, at least one in each row.
        tolerances: Spacing of the points.

    Returns:
        (P,) lower and (P,) upper bounds [m].
    """
    before = np.maximum.accumulate(np.where(window, y, -np.inf), axis=1)[:, :-1]
    starts = window.copy()
    starts[:, 1:] &= y[:, 1:] - before > 2.5 * tolerances.spacing
    run, row = np.cumsum(starts, axis=1), np.arange(len(y))
    nearest = np.argmin(np.where(window, np.abs(y), np.inf), axis=1)
    window = window & (run == run[row, nearest][:, None])
    rank = np.cumsum(window, axis=1)
    count = rank[:, -1:]
    skip = count // FEW
    low = np.argmax(window & (rank == skip + 1), axis=1)
    high = np.argmax(window & (rank == count - skip), axis=1)
    return y[row, low], y[row, high]


def antipodality(
    held: Between,
    window: BoolArray,
    low: FloatArray,
    high: FloatArray,
    opening: FloatArray,
    hand: HandShape,
    tolerances: GraspTolerances,
    lenient: bool = False,
) -> FloatArray:
    """How well two opposed pads hold: 1 for faces square to the closing direction, 0 at the friction cone.

    Where the object's side is seen its normals decide. Where the silhouette ends between the pads (thin or
    steep sides, not seen from above) the outline's direction within the pads does, and the hidden side is
    taken as upright. Where the object widens below the tips, the pads meet a slope.

    Args:
        held: What is between the pads.
        window: (P, S) which points are at the height of the pads and within `low` and `high`.
        low: (P,) where the one pad meets the object [m].
        high: (P,) where the other one does [m].
        opening: (P,) distance of the open pads [m].
        hand: The hand.
        tolerances: Friction and spacing.
        lenient: Whether hidden sides, and contact off a pad's middle, get the benefit of the doubt.

    Returns:
        (P,) values in 0..1.
    """
    x, y, z = (held.points[:, :, axis] for axis in range(3))
    cone, worst = np.arctan(tolerances.friction), np.ones(len(x))
    tip = np.where(window, z, -np.inf).max(axis=1)[:, None]
    below = held.there & (z > tip) & (z < tip + SLOPE_LENGTH)
    below &= np.abs(y - ((low + high) / 2.0)[:, None]) < opening[:, None] / 2.0
    for side, edge in ((-1.0, low), (1.0, high)):
        contact, there = pack(window & (np.abs(y - edge[:, None]) < EDGE))
        at = np.take_along_axis(x, contact, axis=1)
        normals = np.take_along_axis(held.normals, contact[:, :, None], axis=1)
        count, square = np.count_nonzero(there, axis=1), side * normals[:, :, 1]
        seen = there & (square > 0.5)
        known = np.count_nonzero(seen, axis=1) >= np.maximum(2, 0.3 * count)
        holds = np.abs(np.where(there, at, 0.0).sum(axis=1) / count) <= 0.3 * hand.pad_width
        holds |= lenient
        # a seen face, and too flat a slope to press on: pads would slide off its wedge
        holds &= known | (_medians(square, there) <= SLOPED)
        angle = _facing_angle(normals, seen, side)
        unseen = holds & ~known
        hidden = 0.25 * cone + _outline_angle(x[unseen], y[unseen], window[unseen], side)
        angle[unseen] = 0.0 if lenient else hidden
        widening = np.where(below, side * y, -np.inf).max(axis=1) - side * edge
        slope = np.arctan2(np.maximum(widening, 0.0), SLOPE_LENGTH)
        angle = np.where(widening > tolerances.spacing, np.maximum(angle, slope), angle)
        worst = np.where(holds, np.minimum(worst, 1.0 - angle / cone), 0.0)
    return np.maximum(0.0, worst)


def _facing_angle(normals: FloatArray, seen: BoolArray, side: float) -> FloatArray:
    """(P,) angles between the mean of the seen normals and the closing axis, less their bias [rad]."""
    mean = np.einsum("psi,ps->pi", normals, seen.astype(np.float64))
    length = np.maximum(np.linalg.norm(mean, axis=1), 1e-12)
    return np.maximum(0.0, np.arccos(np.clip(side * mean[:, 1] / length, -1.0, 1.0)) - NORMAL_BIAS)


def _medians(values: FloatArray, chosen: BoolArray) -> FloatArray:
    """(P,) medians of the chosen values of each row, of which there is at least one."""
    ordered = np.sort(np.where(chosen, values, np.inf), axis=1)
    count, row = np.count_nonzero(chosen, axis=1), np.arange(len(values))
    return (ordered[row, (count - 1) // 2] + ordered[row, count // 2]) / 2.0


def _outline_angle(x: FloatArray, y: FloatArray, window: BoolArray, side: float) -> FloatArray:
    """(P,) angles between the pad and the outline along x, a line through the outermost of slices [rad]."""
    low = np.where(window, x, np.inf).min(axis=1)[:, None]
    high = np.where(window, x, -np.inf).max(axis=1)[:, None]
    long = (high - low)[:, 0] >= ROD
    share = (x - low) / np.maximum(high - low, 1e-12) * SLICES
    slices = np.minimum(np.where(window, share, 0.0).astype(int), SLICES - 1)
    row = np.arange(len(x))
    known = np.zeros((len(x), SLICES), dtype=bool)
    middles, edges = np.zeros(known.shape), np.zeros(known.shape)
    for index in range(SLICES):
        inside = window & (slices == index)
        known[:, index] = inside.any(axis=1)
        outermost = np.argmax(np.where(inside, side * y, -np.inf), axis=1)
        middles[:, index], edges[:, index] = x[row, outermost], y[row, outermost]
    count = np.maximum(known.sum(axis=1), 1)[:, None]
    middles = np.where(known, middles - np.where(known, middles, 0.0).sum(axis=1)[:, None] / count, 0.0)
    edges = np.where(known, edges - np.where(known, edges, 0.0).sum(axis=1)[:, None] / count, 0.0)
    slope = (middles * edges).sum(axis=1) / np.maximum((middles**2).sum(axis=1), 1e-12)
    return np.where(long & (count[:, 0] >= 3), np.abs(np.arctan(slope)), 0.0)
