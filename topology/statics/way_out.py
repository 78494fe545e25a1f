"""The way out of an object: straight up, or where something fixed is over it level to where nothing is."""

from collections.abc import Callable

import numpy as np

from topple.topology.base.arrays import BoolArray, FloatArray, bounds
from topple.topology.base.remembered import remember
from topple.topology.bodies.tops import tops_of
from topple.topology.geometry.axes import level_axes
from topple.topology.geometry.outline import least_rectangle
from topple.topology.statics.tolerances import (
    CLEAR,
    COVERED,
    KEPT_PAIRS,
    OVERHEAD,
    WALL_CELL,
    WALL_MARGIN,
    WALLED,
)


@remember(KEPT_PAIRS)
def way_out(own: FloatArray, fixed: FloatArray, up: FloatArray) -> FloatArray:
    """Find where an object goes when it is taken.

    It goes up, unless something fixed bars that, be it only for a hand from above. Then it slides out level,
    across a side of what is over it: the shortest way to where nothing is over it any more that no wall bars.

    Args:
        own: (N, 3) points of the object [m].
        fixed: (M, 3) points of all that never moves [m].
        up: (3,) unit vector against gravity.

    Returns:
        (3,) unit vector; `up` itself where nothing is over the object, and where no other way is free either.
    """
    heights, high = own @ up, fixed @ up
    low, top = float(heights.min()), float(heights.max())
    over = (high > top + CLEAR) & (high < top + OVERHEAD)
    axes = np.stack(level_axes(up))
    plan, around = own @ axes.T, fixed[over] @ axes.T
    barring = _in_cells(around, plan)
    if barring.any():  # a wall that it leans on is beside it, and not over it
        leant_on = fixed[(high > low + WALL_MARGIN) & (high < top)] @ axes.T
        barring &= ~_in_cells(around, leant_on)
    if not barring.any() or _count_cells(around[barring]) < COVERED * _count_cells(plan):
        return up
    beside = (high > low + WALL_MARGIN) & (high < float(high[over][barring].min()) - WALL_MARGIN)
    walls, levels = fixed[beside] @ axes.T, high[beside]
    window = float(high[over][barring].min()) - low - 2.0 * WALL_MARGIN
    side = least_rectangle(around)
    found: list[tuple[float, FloatArray]] = []
    for way in (side, -side, np.array([-side[1], side[0]]), np.array([side[1], -side[0]])):
        across = np.array([-way[1], way[0]])
        least, most = float((plan @ across).min()), float((plan @ across).max())
        back, front = float((plan @ way).min()), float((plan @ way).max())
        board = (around @ across > least) & (around @ across < most)
        end = float((around[board] @ way).max(initial=front))
        met = (walls @ across > least + CLEAR) & (walls @ across < most - CLEAR)
        met &= (walls @ way > (back + front) / 2.0) & (walls @ way < end + front - back)
        wall = np.column_stack([walls[met] @ across, levels[met]])
        if _count_cells(wall) < WALLED * max(most - least, WALL_CELL) * window / WALL_CELL**2:
            found.append((end - back, way @ axes))
    return min(found, key=lambda each: each[0])[1] if found else up


def leads_up(way: FloatArray, up: FloatArray) -> bool:
    """Whether a way out (3,) is up (3,), and not level."""
    return float(way @ up) > 0.5


def continued_boards(
    cloud: FloatArray, up: FloatArray, empty: Callable[[FloatArray], BoolArray]
) -> FloatArray:
    """Places where the upper boards of a fixed body may go on: pictures end, and things hide them.

    Args:
        cloud: (N, 3) points of the body [m].
        up: (3,) unit vector against gravity.
        empty: Which of (M, 3) places cameras saw to be empty.

    Returns:
        (K, 3) places at the heights of its tops but the lowest, within the rectangle around it [m].
    """
    boards = tops_of(cloud, up).tops[:-1]
    if not boards:
        return cloud[:0]
    level = np.stack(level_axes(up))
    side = least_rectangle(cloud @ level.T)
    frame = np.stack([side, [-side[1], side[0]]]) @ level
    x, y = (np.arange(*ends, WALL_CELL) for ends in zip(*bounds(cloud @ frame.T), strict=True))
    plan = np.stack(np.meshgrid(x, y), axis=-1).reshape(-1, 2) @ frame
    places = np.concatenate([plan - np.outer(top.above(plan) / (top.normal @ up), up) for top in boards])
    return places[~empty(places)]


def along(axes: FloatArray, points: FloatArray) -> FloatArray:
    """Points (N, 3) along axes, the rows; as they are where the third is z: the others are then, too."""
    return points if axes[2, 2] == 1.0 else points @ axes.T


def _count_cells(flat: FloatArray) -> int:
    """How many cells points (N, 2) are in."""
    return len(np.unique(np.floor(flat / WALL_CELL), axis=0))


def _in_cells(flat: FloatArray, cells: FloatArray) -> BoolArray:
    """Which points (N, 2) are in a cell in which one of others (M, 2) is."""
    if len(cells) == 0:
        return np.zeros(len(flat), dtype=np.bool_)
    corner = np.floor(cells.min(axis=0) / WALL_CELL) * WALL_CELL
    index = np.floor((cells - corner) / WALL_CELL).astype(np.int64)
    there = np.zeros(index.max(axis=0) + 1, dtype=np.bool_)
    there[tuple(index.T)] = True
    asked = np.floor((flat - corner) / WALL_CELL).astype(np.int64)
    inside = np.all((asked >= 0) & (asked < there.shape), axis=1)
    inside[inside] = there[tuple(asked[inside].T)]
    return inside
