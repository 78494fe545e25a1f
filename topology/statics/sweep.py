"""What a straight lift runs into: the volume an object sweeps on its way up, and what is in it.

Along another way out the same is asked of points in axes whose third is that way: see `way_out.along`.
"""

from dataclasses import dataclass

import numpy as np
from scipy.ndimage import binary_opening, maximum_filter

from topple.topology.base.arrays import FloatArray, IntArray, bounds
from topple.topology.base.remembered import remember
from topple.topology.geometry.axes import around
from topple.topology.kernels.heights import heights_over
from topple.topology.statics.tolerances import CLEAR, KEPT_PAIRS, LIFT, PLACES, SWEEP_CELL

DIRECTIONS = around(24)


@dataclass(frozen=True, eq=False)
class Overlap:
    """The part of one object that hangs over another.

    Attributes:
        evasion: How far [m] the upper object must be pushed sideways before it hangs over nothing
            of the other: what a lift would push it by, at least.
        area: Overlapping area in plan view [m²].
        broad: Of it what is two cells wide or more: of two that stand side by side the cells between them
            hold points of both.
        places: (k, 3) some upright places [m] of the upper surface where it does.
    """

    evasion: float
    area: float
    broad: float
    places: FloatArray


@remember(KEPT_PAIRS)
def overlap(upper: FloatArray, lower: FloatArray) -> Overlap | None:
    """How one object hangs over another.

    Args:
        upper: (N, 3) upright surface points [m] of the object that may be in the way.
        lower: (M, 3) upright surface points [m] of the object that is lifted.

    Returns:
        The overlap, or None where no part of `upper` is above a part of `lower` within the lift, or by so
        little that nothing has to move.
    """
    (least, most), (lowest, highest) = bounds(upper), bounds(lower)
    low, high = np.maximum(least, lowest)[:2] - SWEEP_CELL, np.minimum(most, highest)[:2] + SWEEP_CELL
    if (low >= high).any() or most[2] < lowest[2]:
        return None
    size = np.ceil((high - low) / SWEEP_CELL).astype(np.int64) + 1
    ceiling = heights_over(upper, low, SWEEP_CELL, size, highest=True)
    height = ceiling - heights_over(lower, low, SWEEP_CELL, size, highest=False)
    # Where the lifted one reaches higher, it is the one on top: solids do not pass through each other.
    # The neighbouring cells count, since a sampled surface leaves some cells without a point.
    on_top = ceiling > maximum_filter(heights_over(lower, low, SWEEP_CELL, size, highest=True), size=3)
    above = on_top & np.isfinite(height) & (height > CLEAR) & (height < LIFT + 0.1)
    cells = np.argwhere(above)
    if len(cells) == 0:
        return None
    spots = low + (cells + 0.5) * SWEEP_CELL
    # Sideways escape: past the farthest lower point that is lower than what hangs over it.
    below = lower[lower[:, 2] < ceiling[above].max() - CLEAR][:, :2]
    reach = (below @ DIRECTIONS.T).max(axis=0) - (spots @ DIRECTIONS.T).min(axis=0)
    if (evasion := float(reach.min())) <= 0.0:
        return None
    places = np.column_stack([spots, ceiling[above]])[:: len(cells) // PLACES + 1]
    broad = binary_opening(above, np.ones((2, 2)))
    return Overlap(evasion, len(cells) * SWEEP_CELL**2, int(broad.sum()) * SWEEP_CELL**2, places)


@remember(KEPT_PAIRS)
def swept_matrix(swept: FloatArray, other: FloatArray) -> IntArray:
    """The 6-intersection matrix of a body with all that it passes on its way up, and another body.

    Args:
        swept: (N, 3) upright surface points [m] of the object that is lifted.
        other: (M, 3) upright surface points [m] of the other one.

    Returns:
        (2, 3) counts, the swept body first. Its own surface lies outside of the other one, as solids do not
        pass through each other, or on it.
    """
    low, high = bounds(swept)
    cells = np.floor((other[:, :2] - low[:2]) / SWEEP_CELL).astype(np.int64)
    least, most = bounds(cells)
    least = least.clip(0)  # of a room only what the other is in
    size = np.minimum(np.ceil((high[:2] - low[:2]) / SWEEP_CELL).astype(np.int64), most) + 1 - least
    if (size <= 0).any():
        return np.array([[0, 0, len(swept)], [0, 0, len(other)]])
    ground, top = (heights_over(swept, low[:2], SWEEP_CELL, size, each, least) for each in (False, True))
    cells -= least
    over = np.all((cells >= 0) & (cells < size), axis=1)
    index = (cells[over, 0], cells[over, 1])
    height = np.full(len(other), np.nan)
    height[over] = other[over, 2] - ground[index]
    beyond = np.zeros(len(other), dtype=np.bool_)
    beyond[over] = other[over, 2] > top[index] + LIFT
    inside = (height > CLEAR) & np.isfinite(height) & ~beyond
    on = (np.abs(height) <= CLEAR) & ~inside
    inner, boundary = int(inside.sum()), int(on.sum())
    own = min(boundary, len(swept))
    return np.array([[0, own, len(swept) - own], [inner, boundary, len(other) - inner - boundary]])
