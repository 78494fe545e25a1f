"""What two pads would close on at every direction and depth of a hand, and whether the hand has room there.

By a compiled kernel, or by its numpy twin: all hand directions at a point of the object, and all depths of
the finger tips, are looked at together there; arrays have one row for each pair still in the running.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from enum import IntEnum

import numpy as np
from numpy.typing import NDArray

from topple.planner.grasp.frames import Frames
from topple.planner.grasp.hand import HandShape
from topple.planner.grasp.pads import Between, antipodality, between, extents, pack
from topple.planner.grasp.shape import Sought
from topple.planner.grasp.surroundings import Surroundings
from topple.planner.grasp.tolerances import (
    EDGE,
    FEW,
    NORMAL_BIAS,
    OWN_MARGIN,
    PINCH_BRUSH,
    PINCH_TIGHT,
    ROD,
    ROUGH,
    SLICES,
    SLOPE_LENGTH,
    SLOPED,
)
from topple.robots.collision.prisms import Prism
from topple.topology.base.arrays import BoolArray, FloatArray, IntArray
from topple.topology.kernels.compiled import address, kernels


class State(IntEnum):
    """What becomes of a direction at a depth, by the first thing that it fails of."""

    EMPTY = 0  # nothing between the pads, at any depth
    FEW_POINTS = 1
    WIDE = 2
    LOW = 3
    PADS = 4  # closing they would meet others
    FINGERS = 5
    PALM = 6
    SLIDES = 7
    HOLDS = 8


@dataclass(frozen=True, eq=False)
class Windows:
    """What is found at F directions and D depths.

    Attributes:
        states: (F, D) values of `State`.
        barring: (F, D) whose points most of those are that leave no room: a place in the names of the
            surroundings, or their number for the object's own.
        values: (F, D, 5) z of the finger tips from the point, where the pads meet the object, low and high
            [m], how free the way in is, and how well the pads hold, 0..1; the last two where they hold.
    """

    states: NDArray[np.int8]
    barring: IntArray
    values: FloatArray


def windows(frames: Frames, sought: Sought, hand: HandShape) -> Windows:
    """Close the pads at every direction and depth.

    Args:
        frames: A point and the directions of the hand.
        sought: The object, and what is around it; nothing of the hand may go below the ground.
        hand: The hand.
    """
    shape = len(frames.tilts), len(sought.tolerances.depths)
    found = Windows(np.zeros(shape, dtype=np.int8), np.zeros(shape, dtype=np.int64), np.zeros((*shape, 5)))
    compiled, surface, around = kernels(), sought.surface, sought.around
    if compiled is None:
        _find(found, frames, sought, hand)
        return found
    fingers, palm = _numbers_of(hand.finger), _numbers_of(hand.body)
    arrays = [
        np.ascontiguousarray(array, dtype=np.float64)
        for array in (surface.points, surface.normals, around.points, frames.origin, frames.rotations)
    ]
    points, normals, others, origin, turns = arrays
    owners, depths = np.ascontiguousarray(around.owners), np.array(sought.tolerances.depths)
    given = _kernel_numbers(sought, hand)
    compiled.pinch_windows(
        address(points), address(normals), len(points), address(others), address(owners), len(others),
        len(around.names), address(origin), address(turns), len(turns), address(depths), len(depths),
        address(fingers), len(fingers), address(palm), len(palm), address(given),
        address(found.states), address(found.barring), address(found.values),
    )  # fmt: skip
    return found


def _numbers_of(prisms: Sequence[Prism]) -> FloatArray:
    return np.array([[*prism.x, *prism.y, prism.front] for prism in prisms]).reshape(-1, 5)


def _kernel_numbers(sought: Sought, hand: HandShape) -> FloatArray:
    """The kernel's `Numbers`."""
    t = sought.tolerances
    return np.array([
        *sought.up, sought.around.floor, hand.pad_width, hand.pad_length + ROUGH, hand.max_opening, hand.tip,
        t.spacing, t.side_clearance, t.least_side_clearance, t.under_clearance, OWN_MARGIN, *PINCH_BRUSH,
        np.arctan(t.friction), EDGE, SLOPED, SLOPE_LENGTH, NORMAL_BIAS, ROD, PINCH_TIGHT, t.reach,
        t.stray_points, FEW, SLICES,
    ], dtype=np.float64)  # fmt: skip


# -- the twin


def _find(found: Windows, frames: Frames, sought: Sought, hand: HandShape) -> None:
    """Find the windows as the kernel does."""
    look = _look(frames, sought, hand)
    if look is None:
        return
    found.states[look.rows] = State.FEW_POINTS
    hold = _holds(look, sought, hand)
    tolerances, at = sought.tolerances, (look.rows[hold.row], hold.column)
    found.values[(*at, slice(3))] = np.column_stack([hold.tip, hold.low, hold.high])
    narrow = hold.high - hold.low + 2.0 * tolerances.least_side_clearance <= hand.max_opening
    hold = _left(found, look, hold, State.WIDE, narrow)
    hold = _left(found, look, hold, State.LOW, _over_floor(look, hold, sought, hand))
    clearance = _room(found, look, hold, sought, hand)
    hold, clearance = hold.of(clearance > 0.0), clearance[clearance > 0.0]
    wide = hold.high - hold.low + 2.0 * tolerances.side_clearance  # the slope goes on where the jaw ends
    held = antipodality(look.held.of(hold.row), hold.window, hold.low, hold.high, wide, hand, tolerances)
    at = look.rows[hold.row], hold.column
    found.values[(*at, slice(3, 5))] = np.column_stack([clearance, held])
    found.states[at] = np.where(held > 0.0, State.HOLDS, State.SLIDES)


def _left(found: Windows, look: "_Look", hold: "_Hold", state: State, good: BoolArray) -> "_Hold":
    """Those pairs that are good; the state of the others is written down."""
    found.states[look.rows[hold.row[~good]], hold.column[~good]] = state
    return hold.of(good)


@dataclass(frozen=True, eq=False)
class _Look:
    """An object seen along some hand directions: in their axes."""

    rows: IntArray  # of the directions
    origin: FloatArray
    rotations: FloatArray
    held: Between
    top: FloatArray


@dataclass(frozen=True, eq=False)
class _Reach:
    """Points that a part of the hand can meet at any depth, F rows filled up to the longest."""

    x: FloatArray
    y: FloatArray
    z: FloatArray  # inf where there is no point
    index: IntArray  # which point: the object's own come first
    margin: FloatArray  # that the hand keeps to it


@dataclass(frozen=True, eq=False)
class _Hold:
    """P pairs of direction and depth: what the pads would close on there."""

    row: IntArray  # of the direction in the look
    column: IntArray  # of the depth among those tried
    tip: FloatArray
    window: BoolArray  # (P, S) which points between the pads they would meet
    low: FloatArray
    high: FloatArray
    opening: FloatArray

    @property
    def middle(self) -> FloatArray:
        return (self.low + self.high) / 2.0

    def of(self, keep: BoolArray | IntArray) -> "_Hold":
        return _Hold(
            self.row[keep], self.column[keep], self.tip[keep], self.window[keep],
            self.low[keep], self.high[keep], self.opening[keep],
        )  # fmt: skip


def _look(frames: Frames, sought: Sought, hand: HandShape) -> _Look | None:
    """See the object in the axes of each direction that has points of it between the pads."""
    surface = sought.surface
    points = surface.points - frames.origin
    x, y = (frames.rotations[:, :, axis] @ points.T for axis in (0, 1))
    half_open = hand.max_opening / 2.0
    # twice as far as the pads: a hand moved to the middle of what it holds sees past both of its ends
    inside = (np.abs(x) <= hand.pad_width / 2.0) & (np.abs(y) <= 2.0 * half_open)
    some = np.count_nonzero(inside & (np.abs(y) <= half_open), axis=1) >= 4
    if not some.any():
        return None
    rotations = frames.rotations[some]
    held = between(points, surface.normals, rotations, inside[some])
    between_pads = held.there & (np.abs(held.points[:, :, 1]) <= half_open)
    heights = np.sort(np.where(between_pads, held.points[:, :, 2], np.inf), axis=1)
    last = np.count_nonzero(between_pads, axis=1) - 1
    top = heights[np.arange(len(heights)), np.minimum(sought.tolerances.stray_points, last)]
    return _Look(np.flatnonzero(some), frames.origin, rotations, held, top)


def _holds(look: _Look, sought: Sought, hand: HandShape) -> _Hold:
    """Find the points that the pads would close on at each depth."""
    tolerances = sought.tolerances
    depths = np.array(tolerances.depths)
    tips = look.top[:, None] + depths
    backs = tips - hand.pad_length - ROUGH  # a depth may be as long as a pad is
    z = look.held.points[:, None, :, 2]
    window = look.held.there[:, None] & (z <= tips[..., None]) & (z >= backs[..., None])
    row, at = np.nonzero(np.count_nonzero(window, axis=2) >= 3)
    y, window = look.held.points[row, :, 1], window[row, at]
    low, high = extents(y, window, tolerances)
    window &= (y >= low[:, None]) & (y <= high[:, None])
    some = np.count_nonzero(window, axis=1) >= 3  # a stray point that a gap parts from the rest is no object
    opening = np.minimum(hand.max_opening, high - low + 2.0 * tolerances.side_clearance)
    return _Hold(row, at, tips[row, at], window, low, high, opening).of(some)


def _over_floor(look: _Look, hold: _Hold, sought: Sought, hand: HandShape) -> BoolArray:
    """(P,) whether the hand's lowest corner stays over the floor."""
    height = float(look.origin @ sought.up - sought.around.floor)
    x, y, z = (sought.up @ look.rotations)[hold.row].T
    corners = [
        np.minimum(x * x0, x * x1) + np.minimum(y * y0, y * y1) + z * front
        for x0, x1, y0, y1, front in hand.footprints(hold.opening)
    ]
    lowest = np.min(corners, axis=0) + y * hold.middle + z * (hold.tip - hand.tip)
    return height + lowest >= sought.tolerances.under_clearance


def _room(found: Windows, look: _Look, hold: _Hold, sought: Sought, hand: HandShape) -> FloatArray:
    """(P,) how free the way in is, 0..1; 0 where the hand meets points or would pinch a neighbour along.

    Which part of it that is, and what it meets, is written down.
    """
    half, count = hold.opening / 2.0, len(hold.row)
    if count == 0:
        return np.empty(0)
    stray, around = sought.tolerances.stray_points, sought.around.near(look.origin, sought.tolerances.reach)
    fingers, palm, pads = _reaches(look, hold, sought, around.points, hand)
    pair, point, y = _met(pads, look, hold, hand, hand.tip)
    closed = (np.abs(pads.x.reshape(-1)[point]) < hand.pad_width / 2.0) & (np.abs(y) < half[pair])
    met = np.bincount(pair[closed], minlength=count) > stray
    hits = _Hits(sought, around)
    hits.add(pads, pair[closed], point[closed])
    at = look.rows[hold.row], hold.column
    _bar(found, at, met, State.PADS, hits)
    brushed = np.zeros(count, dtype=bool)
    for part, reach, prisms in ((State.FINGERS, fingers, hand.finger), (State.PALM, palm, hand.body)):
        left, hits = np.flatnonzero(~met), _Hits(sought, around)
        passed = _count_passed(reach, prisms, look, hold.of(left), hand, hits)
        brushed[left], met[left] = brushed[left] | passed[0], passed[1]
        _bar(found, (at[0][left], at[1][left]), passed[1], part, hits)
    return np.where(met, 0.0, np.where(brushed, PINCH_TIGHT, 1.0))


def _bar(found: Windows, at: tuple[IntArray, IntArray], met: BoolArray, part: State, hits: "_Hits") -> None:
    """Write down at which pairs a part of the hand meets too much, and whose points most of that are."""
    if met.any():
        rows = at[0][met], at[1][met]
        found.states[rows], found.barring[rows] = part, hits.whose(met)


class _Hits:
    """Whose points a part of the hand meets in each pair of direction and depth."""

    def __init__(self, sought: Sought, around: Surroundings) -> None:
        own, self.stray = len(sought.surface.points), sought.tolerances.stray_points
        self._owners = np.concatenate([np.full(own, len(around.names)), around.owners])
        self._owned = len(around.names) + 1
        self._found: list[IntArray] = []

    def add(self, reach: _Reach, pair: IntArray, at: IntArray) -> None:
        """Points of a reach that are met in pairs."""
        self._found.append(pair * self._owned + self._owners[reach.index.reshape(-1)[at]])

    def whose(self, met: BoolArray) -> IntArray:
        """Whose points most are of those that are met in some of the pairs (P,), of which there are any."""
        shape = len(met), self._owned
        counts = np.bincount(np.concatenate(self._found), minlength=shape[0] * shape[1]).reshape(shape)
        return np.argmax(counts[met], axis=1)


def _reaches(
    look: _Look, hold: _Hold, sought: Sought, others: FloatArray, hand: HandShape
) -> tuple[_Reach, _Reach, _Reach]:
    """Points that fingers, palm, and the pads as they close can meet at any of the depths in question.

    Nearly all points are far from all of them: that is found with half the digits and `ROUGH` to spare.
    """
    own = sought.surface.points
    points = np.vstack([own, others]) - look.origin
    foreign = np.arange(len(points)) >= len(own)
    margin = np.where(foreign, sought.tolerances.under_clearance, OWN_MARGIN)
    rough, turns = points.T.astype(np.float32), look.rotations.astype(np.float32)
    x, y, z = (turns[:, :, axis] @ rough for axis in range(3))
    half = hold.opening / 2.0
    shift, least = (
        _extreme(look, hold, hold.tip - hand.tip, 1.0),
        _extreme(look, hold, half - hold.middle, -1.0),
    )
    inner, outer = _extreme(look, hold, half + hold.middle, -1.0), _extreme(look, hold, half, 1.0)
    middle = _extreme(look, hold, np.abs(hold.middle), 1.0)
    x = np.abs(x)

    def those(near: BoolArray, front: float) -> _Reach:
        index, there = pack(near & (z < shift + np.float32(front + ROUGH)))
        exact = np.matmul(points[index], look.rotations)
        z_in = np.where(there, exact[:, :, 2], np.inf)
        return _Reach(exact[:, :, 0], exact[:, :, 1], z_in, index, margin[index])

    first = min((prism.y[0] for prism in hand.finger), default=0.0) - PINCH_BRUSH[0] - ROUGH
    beside = (y > inner + np.float32(first)) | (-y > least + np.float32(first))
    found: list[_Reach] = []
    for prisms, near in ((hand.finger, beside), (hand.body, np.ones_like(beside))):
        wide = (
            max((max(-prism.x[0], prism.x[1]) for prism in prisms), default=-np.inf) + PINCH_BRUSH[0] + ROUGH
        )
        aside = max((max(-prism.y[0], prism.y[1]) for prism in prisms), default=0.0) + PINCH_BRUSH[0] + ROUGH
        limit = middle + np.float32(aside) + (outer if prisms is hand.finger else np.float32(0.0))
        front = max((prism.front for prism in prisms), default=-np.inf) + PINCH_BRUSH[1]
        found.append(those(near & (x < np.float32(wide)) & (np.abs(y) < limit), front))
    closing = (
        foreign
        & (x < np.float32(hand.pad_width / 2.0 + ROUGH))
        & (np.abs(y) < middle + outer + np.float32(ROUGH))
    )
    return found[0], found[1], those(closing, hand.tip)


def _extreme(look: _Look, hold: _Hold, values: FloatArray, sign: float) -> NDArray[np.float32]:
    """(F, 1) the largest (sign 1) or smallest (-1) of (P,) values of each direction, in half the digits."""
    found = np.full(len(look.top), -np.inf)
    np.maximum.at(found, hold.row, sign * values)
    return (sign * found).astype(np.float32)[:, None]


def _met(
    reach: _Reach, look: _Look, hold: _Hold, hand: HandShape, front: float
) -> tuple[IntArray, IntArray, FloatArray]:
    """Points before `front` at each pair: the pair's number, the point's, and its y in the hand."""
    shape = len(look.top), int(hold.column.max(initial=0)) + 1
    limit, number = np.full(shape, -np.inf), np.zeros(shape, dtype=np.int64)
    limit[hold.row, hold.column] = hold.tip - hand.tip + front
    number[hold.row, hold.column] = np.arange(len(hold.row))
    row, column, place = np.nonzero(reach.z[:, None, :] < limit[:, :, None])
    pair, at = number[row, column], row * reach.z.shape[1] + place
    return pair, at, reach.y.reshape(-1)[at] - hold.middle[pair]


def _count_passed(
    reach: _Reach, prisms: tuple[Prism, ...], look: _Look, hold: _Hold, hand: HandShape, hits: "_Hits"
) -> tuple[BoolArray, BoolArray]:
    """(P,) whether more than stray points are brushed by, and met by, any prism of fingers or palm."""
    count = len(hold.row)
    brushed, met = np.zeros(2 * count, dtype=bool), np.zeros(2 * count, dtype=bool)
    if not prisms:
        return brushed[:count], met[:count]
    key, at, y = _met(reach, look, hold, hand, max(prism.front for prism in prisms) + PINCH_BRUSH[1])
    if prisms is hand.finger:  # from the one pad outwards, and from the other, which counts for itself
        half = (hold.opening / 2.0)[key]
        key, at, y = np.concatenate([key, key + count]), np.tile(at, 2), np.concatenate([y - half, -y - half])
    first, last = min(prism.y[0] for prism in prisms), max(prism.y[1] for prism in prisms)
    near = np.flatnonzero((y > first - PINCH_BRUSH[0]) & (y < last + PINCH_BRUSH[0]))
    key, at, y = key[near], at[near], y[near]
    x, z, margin = (values.reshape(-1)[at] for values in (reach.x, reach.z, reach.margin))
    z = z - (hold.tip - hand.tip)[key % count]
    for prism in prisms:
        near = np.flatnonzero(z < prism.front + PINCH_BRUSH[1])
        a, b, c, keep = x[near], y[near], z[near], margin[near]
        # distance beside the prism, negative within
        aside = np.maximum(
            np.maximum(prism.x[0] - a, a - prism.x[1]), np.maximum(prism.y[0] - b, b - prism.y[1])
        )
        for found, hit in (
            (brushed, aside < PINCH_BRUSH[0]),
            (met, (aside < keep) & (c < prism.front + keep)),
        ):
            found |= np.bincount(key[near[hit]], minlength=2 * count) > hits.stray
            if found is met:
                hits.add(reach, key[near[hit]] % count, at[near[hit]])
    return brushed[:count] | brushed[count:], met[:count] | met[count:]
