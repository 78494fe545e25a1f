"""What of the tops of tables and shelves is free, seen from straight above."""

from collections.abc import Collection, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.ndimage import distance_transform_edt

from topple.planner.placement.resting import PLACEMENT_TOLERANCES
from topple.planner.placement.tolerances import SKIN
from topple.topology.base.arrays import BoolArray, FloatArray, IntArray
from topple.topology.bodies.matter import MATTER
from topple.topology.bodies.solids import Solids
from topple.topology.bodies.tops import Top, tops_of
from topple.topology.geometry.axes import level_axes
from topple.topology.geometry.sides import beyond, sides_of
from topple.topology.situation.situation import Situation
from topple.topology.statics.tolerances import LIFT


@dataclass(frozen=True, eq=False)
class FreeSpace:
    """What of one top is free.

    Attributes:
        owner: The fixed body whose top it is.
        origin: (2,) level coordinates of the grid's corner [m].
        distance: (I, J) distance of each cell to the nearest thing, edge or unseen table [m].
        ways: (I, J) whether what stands there would be in the way of lifting what is still to be taken, or
            of the hand around it.
        normal: (3,) unit normal of the top.
        height: Of the top along the normal [m].
        cell: Edge of a cell [m].
    """

    owner: str
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
        """Measure the free space below objects that cover some cells around others.

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


def free_spaces(
    situation: Situation,
    *,
    leave_out: Collection[str] = (),
    avoid: Sequence[FloatArray] = (),
    remaining: Collection[str] = (),
    tall: float = 0.0,
) -> tuple[FreeSpace, ...]:
    """Map what of every top is free, everything on it seen from straight above.

    The way out of an object is its column, straight up, or what it slides over where something fixed is over
    it, and half an open hand's width around it. A place under a fixed board is free where there is room
    below it for what is put down and for the hand.

    Args:
        situation: Where everything is.
        leave_out: Objects that do not count, for they are to be moved.
        avoid: (N, 3) points each, of places to keep free besides.
        remaining: Objects that are still to be taken, or put something on or into.
        tall: Height of what is put down [m].

    Returns:
        One map a top; none where the scene has no fixed level surface. The floor of a bin is only among them
        where there is no other.
    """
    scene, up = situation.scene, situation.up
    tops = [(name, top) for name in sorted(scene.fixed) for top in tops_of(scene.clouds[name], up).tops]
    tops = [(name, top) for name, top in tops if not top.walled] or tops
    return tuple(_free_space(name, top, situation, leave_out, avoid, remaining, tall) for name, top in tops)


def _free_space(
    owner: str,
    top: Top,
    situation: Situation,
    leave_out: Collection[str],
    avoid: Sequence[FloatArray],
    remaining: Collection[str],
    tall: float,
) -> FreeSpace:
    """The map of one top."""
    scene, solids = situation.scene, situation.solids
    axes = np.stack(level_axes(situation.up))
    ground = top.points @ axes.T
    origin, middles = _grid(ground, PLACEMENT_TOLERANCES.cell)
    boards = [part for part in solids[owner] if abs(float(top.above(part).max())) < SKIN] or [top.points]
    free = np.any([_within(middles, board @ axes.T) for board in boards], axis=0)
    edge = _to_nearest(free) * PLACEMENT_TOLERANCES.cell
    free &= edge > PLACEMENT_TOLERANCES.edge
    clear = np.ones_like(free)
    for name in scene.names:
        if name in leave_out or (name == owner and len(top.points) == len(scene.clouds[name])):
            continue  # strays above a table that is nothing but its top are noise
        fixed = name in scene.fixed
        ceiling = tall + PLACEMENT_TOLERANCES.headroom if fixed else np.inf
        taken = np.zeros_like(free)
        for part in solids[name]:
            heights = top.above(part)
            if heights.max() > (SKIN if fixed else -SKIN) and heights.min() < ceiling:
                taken |= _within(middles, part @ axes.T)
        heights = top.above(scene.clouds[name])
        met = (heights > (SKIN if fixed else -SKIN)) & (heights < ceiling)
        _mark(taken, scene.clouds[name][met] @ axes.T, origin, PLACEMENT_TOLERANCES.cell)
        free &= ~taken
        if name in remaining:
            clear &= ~taken
            for part in () if situation.goes_up(name) else solids[name]:
                clear &= ~_within(middles, np.vstack([part, part + LIFT * situation.way_out(name)]) @ axes.T)
    for part in solids.get(MATTER, ()):
        heights = top.above(part)
        if heights.max() > SKIN and heights.min() < tall + PLACEMENT_TOLERANCES.headroom:
            free &= ~_within(middles, part @ axes.T)
    for points in avoid:
        free &= ~_within(middles, points @ axes.T)
    away: FloatArray = np.asarray(distance_transform_edt(clear)) * PLACEMENT_TOLERANCES.cell
    ways = (away < PLACEMENT_TOLERANCES.good_gap) & (not clear.all())
    distance = _to_nearest(free) * PLACEMENT_TOLERANCES.cell
    return FreeSpace(owner, origin, distance, ways, top.normal, top.height, PLACEMENT_TOLERANCES.cell)


def free_around(
    owner: str,
    corners: FloatArray,
    axes: FloatArray,
    up: FloatArray,
    bodies: Solids,
) -> FreeSpace:
    """Map what of a level area is free of bodies.

    Args:
        owner: Its name.
        corners: (N, 3) of the area, which is their level outline [m].
        axes: (2, 3) level axes.
        up: (3,) unit vector.
        bodies: By name the convex parts of what may stand there.
    """
    ground, height = corners @ axes.T, float((corners @ up).max())
    origin, middles = _grid(ground, PLACEMENT_TOLERANCES.cell)
    free = _within(middles, ground)
    for part in (part for parts in bodies.values() for part in parts):
        if float((part @ up).max()) > height + SKIN:
            free &= ~_within(middles, part @ axes.T)
    distance = _to_nearest(free) * PLACEMENT_TOLERANCES.cell
    return FreeSpace(owner, origin, distance, np.zeros_like(free), up, height, PLACEMENT_TOLERANCES.cell)


def _grid(ground: FloatArray, cell: float) -> tuple[FloatArray, FloatArray]:
    """Corner (2,) of the grid over level points (N, 2), and the middles (I, J, 2) of its cells [m]."""
    origin = ground.min(axis=0)
    shape = np.ceil((ground.max(axis=0) - origin) / cell).astype(int) + 1
    return origin, origin + (np.argwhere(np.ones(tuple(shape))).reshape(*shape, 2) + 0.5) * cell


def _to_nearest(free: BoolArray) -> FloatArray:
    """Distance of every cell to the nearest one that is not free or beyond the edge, in cells."""
    distance: FloatArray = np.asarray(distance_transform_edt(np.pad(free, 1)), dtype=np.float64)
    return distance[1:-1, 1:-1]


def _within(places: FloatArray, points: FloatArray) -> BoolArray:
    """Which places lie in the convex outline of level points."""
    low, high = points.min(axis=0), points.max(axis=0)
    result = np.all((places >= low) & (places <= high), axis=-1)
    sides = sides_of(points)
    if sides is not None:  # the box of a line or a point is it
        result[result] = beyond(sides, places[result]) <= 0.0
    return result


def _mark(taken: BoolArray, points: FloatArray, origin: FloatArray, cell: float) -> None:
    index = np.floor((points - origin) / cell).astype(np.int64)
    inside = np.all((index >= 0) & (index < np.array(taken.shape)), axis=1)
    taken[index[inside, 0], index[inside, 1]] = True
