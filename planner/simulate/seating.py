"""Rebuilt bodies made to fit each other: parted where they overlap, set down on what carries them.

What was seen stays where it is; what was invented for the hidden sides gives way, and reaches as far down
as there is room, since the scene was at rest.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.spatial import ConvexHull, QhullError

from topple.planner.simulate.tolerances import (
    CELL,
    CLEAR,
    FAR,
    INSIDE,
    LEVEL_BONUS,
    NEAR,
    SEEN_WEIGHT,
    SLACK,
    STEPS,
    SURELY,
)
from topple.robots.collision.convex import hull_of
from topple.robots.world.body_clouds import Piece
from topple.topology.base.arrays import BoolArray, FloatArray, IntArray, cells_over
from topple.topology.geometry.axes import around
from topple.topology.geometry.sides import inset
from topple.topology.views.free_space import FreeSpace

Shape = list[Piece]


def part(shapes: Mapping[str, Shape]) -> None:
    """Cut overlapping pieces of different bodies apart, in place.

    Args:
        shapes: name -> its pieces; the lists are changed.
    """
    names = list(shapes)
    for i, one in enumerate(names):
        for two in names[i + 1 :]:
            a, b = shapes[one], shapes[two]
            for k, other in _overlaps(a, b):
                cut = _separate(a[k], b[other])
                if cut is not None:
                    a[k], b[other] = cut


def _overlaps(a: Sequence[Piece], b: Sequence[Piece]) -> list[tuple[int, int]]:
    """Pairs of pieces whose boxes overlap."""
    low = [np.array([p.corners.min(axis=0) for p in each]) for each in (a, b)]
    high = [np.array([p.corners.max(axis=0) for p in each]) for each in (a, b)]
    over = (low[0][:, None] < high[1][None] - CLEAR) & (low[1][None] < high[0][:, None] - CLEAR)
    return [(int(k), int(other)) for k, other in np.argwhere(over.all(axis=2))]


def _separate(a: Piece, b: Piece) -> tuple[Piece, Piece] | None:
    """Both pieces on their own sides of a plane that takes least of what was seen; None if they are apart."""
    directions = np.concatenate([_DIRECTIONS, _normals(a), -_normals(b)])
    high, low = (a.corners @ directions.T).max(axis=0), (b.corners @ directions.T).min(axis=0)
    depth = high - low
    if depth.min() < CLEAR:
        return None
    seen_high = (a.seen @ directions.T).max(axis=0) if len(a.seen) else high - depth / 2
    seen_low = (b.seen @ directions.T).min(axis=0) if len(b.seen) else low + depth / 2
    cost = depth + SEEN_WEIGHT * np.maximum(seen_high - seen_low, 0.0)
    best = int(np.argmin(cost - LEVEL_BONUS * (np.abs(directions[:, 2]) > 0.999)))
    if cost[best] > (1 + SEEN_WEIGHT) * 0.02:
        return None  # one is round the other: no plane parts them
    first, last = max(seen_high[best], low[best]), min(seen_low[best], high[best])
    limit = (first + last) / 2 if first > last else float(np.clip((low[best] + high[best]) / 2, first, last))
    kept = clip(a.corners, directions[best], limit), clip(b.corners, -directions[best], -limit)
    if kept[0] is None or kept[1] is None:
        return None
    return Piece(kept[0], a.seen), Piece(kept[1], b.seen)


def clip(corners: FloatArray, normal: FloatArray, limit: float) -> FloatArray | None:
    """The part of a convex set on the near side of a plane.

    Args:
        corners: (V, 3) [m].
        normal: (3,) unit vector.
        limit: Keeps the points p with normal · p <= limit [m].

    Returns:
        (W, 3) corners, or None where nothing with a volume is left.
    """
    beyond = corners @ normal - limit
    inside, outside = beyond <= 0, beyond > 0
    if not outside.any():
        return corners
    if not inside.any():
        return None
    near, far = corners[inside], corners[outside]
    share = (beyond[inside][:, None] / (beyond[inside][:, None] - beyond[outside][None]))[..., None]
    across = (near[:, None] + share * (far[None] - near[:, None])).reshape(-1, 3)
    every = np.concatenate([near, across])
    try:
        hull = ConvexHull(every)
    except (QhullError, ValueError):
        return None
    return every[hull.vertices] if hull.volume > 1e-9 else None


def _normals(piece: Piece) -> FloatArray:
    """(F, 3) outward normals of a hull's faces, those that differ."""
    normals = piece.planes[:, :3]
    return normals[np.unique(np.round(normals, 1), axis=0, return_index=True)[1]]


_DIRECTIONS = np.concatenate([[[0.0, 0, 1], [0.0, 0, -1]], np.column_stack([around(16), np.zeros(16)])])
"""Up, down and sixteen level directions, in which things usually stand apart."""


@dataclass(frozen=True, eq=False)
class _Under:
    """What lies below an object, cell by cell.

    Attributes:
        cells: (M, 2) middles of the plan cells [m].
        bottom: (M,) height of its own underside [m].
        piece: (M,) which of its pieces that is.
        top: (M,) height of the highest thing below [m].
        owner: (M,) which body that is, -1 for the floor.
    """

    cells: FloatArray
    bottom: FloatArray
    piece: IntArray
    top: FloatArray
    owner: IntArray

    @property
    def gap(self) -> FloatArray:
        """(M,) room below [m]."""
        return self.bottom - self.top


@dataclass(frozen=True, eq=False)
class Seat:
    """Where a body is carried.

    Attributes:
        centre: (3,) its centre of mass as its shape has it [m].
        cells: (M, 2) middles of the plan cells at which it is carried [m]; none where nothing does.
        carriers: Names of the bodies that do.
    """

    centre: FloatArray
    cells: FloatArray
    carriers: tuple[str, ...]


def seat(
    name: str, shapes: Mapping[str, Shape], grounds: Mapping[str, Shape], floor: float,
    centre: FloatArray, sight: FreeSpace | None,
) -> Seat:  # fmt: skip
    """Set a body down on what lies below it, in place, and say where its weight may be.

    The closest cells of the underside are drawn down to what they face. Where the underside was hidden, more
    cells follow until the weight lies over the outline of what carries it.

    Args:
        name: The body.
        shapes: name -> pieces of everything that moves; this body's are changed.
        grounds: name -> pieces of what is fixed.
        floor: Height [m] of the surface everything stands on.
        centre: (3,) its centre of mass as its shape has it [m].
        sight: What was seen to be empty, or None where the cloud is whole.

    Returns:
        The places at which it is carried, and by what.
    """
    every = {other: shape for other, shape in (*shapes.items(), *grounds.items()) if other != name}
    under = _look_below(shapes[name], list(every.values()), floor)
    if under is None:
        return Seat(centre, np.empty((0, 2)), ())
    gap = np.maximum(under.gap, 0.0)
    free = gap < (NEAR if sight is None else FAR)
    if sight is not None:
        middle = np.column_stack([under.cells, under.bottom - gap / 2])
        free &= ~sight.empty(middle) | (gap < NEAR)
    if not free.any():
        return Seat(centre, np.empty((0, 2)), ())
    chosen = _supports(under.cells, gap, under.owner, free, centre, hidden=sight is not None)
    alone = len(np.unique(under.owner[free])) == 1
    near = chosen if alone else chosen & (gap <= NEAR)
    shape = shapes[name]
    for k in np.unique(under.piece[near]):
        mine = near & (under.piece == k)
        feet = np.column_stack([under.cells[mine], under.top[mine]])
        shape[int(k)] = shape[int(k)].with_points(feet)
    for owner in np.unique(under.owner[chosen & ~near]):
        shape.append(_hidden_below(under, np.flatnonzero(chosen & ~near & (under.owner == owner))))
    carriers = tuple(list(every)[k] for k in np.unique(under.owner[chosen]) if k >= 0)
    return Seat(centre, under.cells[chosen], carriers)


def _hidden_below(under: _Under, index: IntArray) -> Piece:
    """Fill the unseen space between a body's underside and the body below that must carry it there.

    A piece of its own: the hull of the whole body and it would reach into what stands beside. It ends at the
    outermost of the places: down to all of an uneven top it would stand on a bump in its middle, and rock.
    """
    outer = np.unique(index[np.argmax(under.cells[index] @ around(8).T, axis=0)])
    square = _CORNERS * (CELL / 2 / np.abs(_CORNERS).max())
    places = (under.cells[outer][:, None] + square).reshape(-1, 2)
    ends = [
        np.column_stack([places, np.repeat(z, 4)]) for z in (under.top[outer], under.bottom[outer] + CELL)
    ]
    return Piece(hull_of(np.concatenate(ends))[0], np.empty((0, 3)))


def _supports(
    cells: FloatArray, gap: FloatArray, owner: IntArray, free: BoolArray, centre: FloatArray, hidden: bool
) -> BoolArray:
    """Which cells of an underside rest on something.

    What lies closest carries; further bodies and then further cells follow, nearest first, until the weight
    is over the outline of them all.
    """
    nearest = {int(k): float(gap[free & (owner == k)].min()) for k in np.unique(owner[free])}
    above = np.array([gap[i] - nearest.get(int(owner[i]), np.inf) for i in range(len(gap))])
    touching = free & (above <= SLACK)
    least = min(nearest.values())
    chosen = np.zeros(len(gap), dtype=np.bool_)
    for k in sorted(nearest, key=nearest.__getitem__):
        if nearest[k] > least + SLACK and _outside(centre[:2], cells[chosen]) <= -INSIDE:
            return chosen
        chosen |= touching & (owner == k)
    for step in STEPS if hidden else ():
        if _outside(centre[:2], cells[chosen]) <= -INSIDE:
            break
        chosen = free & (above <= step)
    return chosen


def balance_centres(seats: Mapping[str, Seat], masses: Mapping[str, float]) -> dict[str, FloatArray]:
    """Centres of mass, each moved level until it and all it carries are over what carries them.

    Args:
        seats: name -> where it is carried, the lowest bodies first.
        masses: name -> mass [kg].

    Returns:
        name -> (3,) centre of mass [m]. A load on several bodies is shared evenly.
    """
    loads: dict[str, list[tuple[float, FloatArray]]] = {name: [] for name in seats}
    found: dict[str, FloatArray] = {}
    for name in reversed(list(seats)):
        seat_of, mass = seats[name], masses[name]
        weights = np.array([mass, *(load for load, _ in loads[name])])
        places = np.stack([seat_of.centre[:2], *(place for _, place in loads[name])])
        common = weights @ places / weights.sum()
        wanted = _move_over(common, seat_of.cells) if len(seat_of.cells) else common
        shift = (wanted - common) * weights.sum() / mass
        own = seat_of.centre[:2] + shift
        if len(seat_of.cells):
            own = _move_over(own, seat_of.cells)  # it stands without its load, too
        found[name] = np.append(own, seat_of.centre[2])
        for carrier in seat_of.carriers:
            if carrier in loads:
                loads[carrier].append((float(weights.sum()) / len(seat_of.carriers), wanted))
    return found


def _move_over(place: FloatArray, cells: FloatArray) -> FloatArray:
    """A place in plan, moved until it lies over the outline of cells."""
    middle = (cells.min(axis=0) + cells.max(axis=0)) / 2
    places = [(1 - share) * place + share * middle for share in np.linspace(0.0, 1.0, 11)]
    outside = np.maximum([_outside(each, cells) for each in places], -SURELY)
    return places[int(np.argmin(outside))]


def _outside(point: FloatArray, cells: FloatArray) -> float:
    """How far a point lies outside the outline of the middles of plan cells [m], negative inside."""
    corners = (cells[:, None] + _CORNERS).reshape(-1, 2)
    return float(-inset(corners, point[None])[0])


_CORNERS = np.array([[-1, -1], [-1, 1], [1, -1], [1, 1]]) * 1e-3
"""A single cell has an outline, too."""


def _look_below(shape: Shape, others: Sequence[Shape], floor: float) -> _Under | None:
    """Hold the underside of a body against everything below it."""
    corners = np.concatenate([piece.corners for piece in shape])
    lower, upper = corners[:, :2].min(axis=0), corners[:, :2].max(axis=0)
    cells = cells_over(lower, upper, CELL)
    bottoms = np.stack([_column(piece, cells)[0] for piece in shape])
    piece = np.argmin(bottoms, axis=0)
    bottom = bottoms.min(axis=0)
    within = np.isfinite(bottom)
    if not within.any():
        return None
    cells, piece, bottom = cells[within], piece[within], bottom[within]
    top, owner = np.full(len(cells), floor), np.full(len(cells), -1)
    for number, other in enumerate(others):
        for each in other:
            low, high = each.corners[:, :2].min(axis=0), each.corners[:, :2].max(axis=0)
            if (low < upper).all() and (high > lower).all():
                reach = _column(each, cells)[1]
                higher = np.isfinite(reach) & (reach <= bottom + NEAR) & (reach > top)
                top, owner = np.where(higher, reach, top), np.where(higher, number, owner)
    return _Under(cells, bottom, piece, top, owner)


def _column(piece: Piece, cells: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Lowest and highest point of a convex set over plan cells [m]: inf and -inf beside it."""
    planes = piece.planes
    reach = cells @ planes[:, :2].T + planes[:, 3]
    down, up = planes[:, 2] < -1e-6, planes[:, 2] > 1e-6
    low = (-reach[:, down] / planes[down, 2]).max(axis=1)
    high = (-reach[:, up] / planes[up, 2]).min(axis=1)
    hit: BoolArray = (low <= high) & (reach[:, ~(down | up)] <= 0).all(axis=1)
    return np.where(hit, low, np.inf), np.where(hit, high, -np.inf)


def floor_cut(shape: Shape, floor: float) -> Shape:
    """Pieces without what reaches below the floor: noise; pieces that lie below it altogether stay."""
    kept: Shape = []
    for piece in shape:
        corners = clip(piece.corners, np.array([0.0, 0.0, -1.0]), -floor)
        kept.append(piece if corners is None else Piece(hull_of(corners)[0], piece.seen))
    return kept
