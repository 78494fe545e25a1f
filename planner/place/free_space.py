"""What of a table is free, seen from straight above."""

from collections.abc import Collection, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.ndimage import distance_transform_edt
from scipy.spatial import ConvexHull, QhullError

from topple.planner.place.resting import PLACEMENT_TOLERANCES, PlacementTolerances
from topple.planner.solids import Solids, level_axes, table_top, up_of
from topple.topology.arrays import BoolArray, FloatArray, IntArray
from topple.topology.scene import Scene


@dataclass(frozen=True, eq=False)
class FreeSpace:
    """What of a table is free.

    Attributes:
        origin: (2,) level coordinates of the grid's corner [m].
        distance: (I, J) distance of each cell to the nearest thing, edge or unseen table [m].
        ways: (I, J) whether what stands there would be in the way of lifting what is still to be taken, or
            of the hand around it.
        normal: (3,) unit normal of the table.
        height: Of the table along the normal [m].
        cell: Edge of a cell [m].
    """

    origin: FloatArray
    distance: FloatArray
    ways: BoolArray
    normal: FloatArray
    height: float
    cell: float

    def middles(self, cells: IntArray) -> FloatArray:
        """Level coordinates (P, 2) of the middles of cells (P, 2) [m]."""
        return self.origin + (cells + 0.5) * self.cell

    def under(self, cells: IntArray, covered: IntArray) -> tuple[FloatArray, BoolArray]:
        """What is free below things that cover some cells around others.

        Args:
            cells: (P, 2) indices of cells.
            covered: (K, 2) cells covered at each, relative to it.

        Returns:
            (P,) distance to the nearest thing [m], 0 where the table ends; and (P,) whether what stands there
            is in the way of what is still to be taken.
        """
        margin = int(np.abs(covered).max(initial=0))
        distance, ways = np.pad(self.distance, margin), np.pad(self.ways, margin)
        row = np.array([distance.shape[1], 1])
        index = ((cells + margin) @ row)[:, None] + covered @ row
        return distance.ravel()[index].min(axis=1), np.asarray(ways.ravel()[index].any(axis=1))


def free_space(
    scene: Scene,
    solids: Solids,
    *,
    leave_out: Collection[str] = (),
    avoid: Sequence[FloatArray] = (),
    remaining: Collection[str] = (),
    tolerances: PlacementTolerances = PLACEMENT_TOLERANCES,
) -> FreeSpace | None:
    """Map what of the table is free, everything seen from straight above.

    The way out of an object is its column, straight up, and half an open hand's width around it.

    Args:
        scene: The scene.
        solids: Convex parts of its objects.
        leave_out: Objects that do not count, for they are to be moved.
        avoid: (N, 3) points each, of places to keep free besides.
        remaining: Objects that are still to be taken, or put something on or into.
        tolerances: Grid and distance from the edge.

    Returns:
        The map, or None where the scene has no fixed level surface.
    """
    up = up_of(scene)
    axes = np.stack(level_axes(up))
    tables = [
        (name, top)
        for name in scene.names
        if name in scene.fixed and (top := table_top(scene.clouds[name], up))
    ]
    if not tables:
        return None
    table, (normal, height) = max(tables, key=lambda item: len(scene.clouds[item[0]]))
    ground = scene.clouds[table] @ axes.T
    origin = ground.min(axis=0)
    shape = np.ceil((ground.max(axis=0) - origin) / tolerances.cell).astype(int) + 1
    middles = origin + (np.argwhere(np.ones(tuple(shape))).reshape(*shape, 2) + 0.5) * tolerances.cell
    free = _within(middles, ground)
    edge = _to_nearest(free) * tolerances.cell
    free &= edge > tolerances.edge
    clear = np.ones_like(free)
    for name in scene.names:
        if name != table and name not in leave_out:
            taken = np.zeros_like(free)
            for part in solids[name]:
                taken |= _within(middles, part @ axes.T)
            _mark(taken, scene.clouds[name] @ axes.T, origin, tolerances.cell)
            free &= ~taken
            if name in remaining:
                clear &= ~taken
    for points in avoid:
        free &= ~_within(middles, points @ axes.T)
    away: FloatArray = np.asarray(distance_transform_edt(clear)) * tolerances.cell
    ways = (away < tolerances.good_gap) & (not clear.all())
    return FreeSpace(origin, _to_nearest(free) * tolerances.cell, ways, normal, height, tolerances.cell)


def _to_nearest(free: BoolArray) -> FloatArray:
    """Distance of every cell to the nearest one that is not free or beyond the edge, in cells."""
    distance: FloatArray = np.asarray(distance_transform_edt(np.pad(free, 1)), dtype=np.float64)
    return distance[1:-1, 1:-1]


def _within(places: FloatArray, points: FloatArray) -> BoolArray:
    """Which places lie in the convex outline of level points."""
    low, high = points.min(axis=0), points.max(axis=0)
    result = np.all((places >= low) & (places <= high), axis=-1)
    try:
        sides = ConvexHull(points).equations
        result[result] = (places[result] @ sides[:, :2].T + sides[:, 2] <= 0.0).all(axis=1)
    except (QhullError, ValueError):
        pass  # a line or a point: its box is it
    return result


def _mark(taken: BoolArray, points: FloatArray, origin: FloatArray, cell: float) -> None:
    index = np.floor((points - origin) / cell).astype(np.int64)
    inside = np.all((index >= 0) & (index < np.array(taken.shape)), axis=1)
    taken[index[inside, 0], index[inside, 1]] = True
