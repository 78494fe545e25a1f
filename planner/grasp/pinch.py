"""Pinching between two fingers: where pads can reach an object's sides past everything around it.

All hand directions at a point of the object, and all depths of the finger tips, are looked at together:
arrays have one row for each pair of direction and depth that is still in the running.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from topple.planner.grasp.frames import Frames
from topple.planner.grasp.grasp import PINCH, RIM, Grasp
from topple.planner.grasp.hand import HandShape
from topple.planner.grasp.load import HOLD, chance_to_hold, in_words, jaw_load, weight_of
from topple.planner.grasp.pads import Between, antipodality, between, extents, packed
from topple.planner.grasp.shape import Sought
from topple.planner.grasp.surroundings import ITSELF, Dropped, Surroundings
from topple.planner.grasp.tolerances import OWN_MARGIN, PINCH_BRUSH, PINCH_TIGHT, ROUGH
from topple.robots.collision.prisms import Prism
from topple.topology.base.arrays import BoolArray, FloatArray, IntArray
from topple.topology.base.values import rounded

WEIGHTS = {"antipodality": 0.3, "balance": 0.3, "clearance": 0.15, "depth": 0.15, "upright": 0.1}
"""Exponents of a pinch's terms: one that is nil spoils the grasp alone."""
NOTHING = "nothing between the pads"
BELOW = "the hand would go below the ground"
SLIDES = "pads would slide off"


def score_of(terms: Mapping[str, float]) -> float:
    """Put the terms (0..1) of a pinch together, to 0..1."""
    return float(np.prod([terms[name] ** power for name, power in WEIGHTS.items()])) * terms.get(HOLD, 1.0)


def pinches(frames: Frames, sought: Sought, hand: HandShape) -> list[Grasp]:
    """Find how deep the fingers can go at one point of an object, and what they would hold.

    Args:
        frames: The point and the directions of the hand.
        sought: The object, and what is around it; nothing of the hand may go below the ground.
        hand: The hand.

    Returns:
        At most two grasps for each direction: the best-scored one and the deepest free one.
    """
    tolerances, dropped = sought.tolerances, sought.dropped
    look = _look(frames, sought, hand)
    if look is None:
        dropped.note(NOTHING, len(frames.tilts))
        return []
    dropped.note(NOTHING, len(frames.tilts) - len(look.tilts))
    hold = _holds(look, sought, hand)
    over = _over_floor(look, hold, sought, hand)
    dropped.note(BELOW, int(np.count_nonzero(~over)))
    hold = hold.of(over)
    clearance = _room(look, hold, sought, hand)
    hold, clearance = hold.of(clearance > 0.0), clearance[clearance > 0.0]
    wide = hold.high - hold.low + 2.0 * tolerances.side_clearance  # the slope goes on where the jaw ends
    held = antipodality(look.held.of(hold.row), hold.window, hold.low, hold.high, wide, hand, tolerances)
    dropped.note(SLIDES, int(np.count_nonzero(held <= 0.0)))
    hold, clearance, held = hold.of(held > 0.0), clearance[held > 0.0], held[held > 0.0]
    return _best_and_deepest(look, hold, clearance, held, sought, hand)


@dataclass(frozen=True, eq=False)
class _Look:
    """An object seen along F hand directions: in their axes."""

    origin: FloatArray
    rotations: FloatArray
    tilts: FloatArray
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
    depth: FloatArray
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
            self.row[keep], self.column[keep], self.depth[keep], self.tip[keep], self.window[keep],
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
    return _Look(frames.origin, rotations, frames.tilts[some], held, top)


def _holds(look: _Look, sought: Sought, hand: HandShape) -> _Hold:
    """What the pads would close on at each depth, where it is no wider than the hand opens."""
    tolerances = sought.tolerances
    depths = np.array(tolerances.depths)
    tips = look.top[:, None] + depths
    z = look.held.points[:, None, :, 2]
    window = look.held.there[:, None] & (z <= tips[..., None]) & (z >= tips[..., None] - hand.pad_length)
    row, at = np.nonzero(np.count_nonzero(window, axis=2) >= 3)
    y, window = look.held.points[row, :, 1], window[row, at]
    low, high = extents(y, window, tolerances)
    window &= (y >= low[:, None]) & (y <= high[:, None])
    some = np.count_nonzero(window, axis=1) >= 3  # a stray point that a gap parts from the rest is no object
    opening = np.minimum(hand.max_opening, high - low + 2.0 * tolerances.side_clearance)
    hold = _Hold(row, at, depths[at], tips[row, at], window, low, high, opening)
    width, spare = high - low, 2.0 * tolerances.least_side_clearance
    narrow = width + spare <= hand.max_opening
    sought.dropped.too_wide(width[some & ~narrow], spare, hand.max_opening)
    return hold.of(some & narrow)


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


def _room(look: _Look, hold: _Hold, sought: Sought, hand: HandShape) -> FloatArray:
    """(P,) how free the way in is, 0..1; 0 where the hand meets points or would pinch a neighbour along."""
    half, count = hold.opening / 2.0, len(hold.row)
    if count == 0:
        return np.empty(0)
    stray, around = sought.tolerances.stray_points, sought.around.near(look.origin, sought.tolerances.reach)
    fingers, palm, pads = _reaches(look, hold, sought, around.points, hand)
    pair, at, y = _met(pads, look, hold, hand, hand.tip)
    closed = (np.abs(pads.x.reshape(-1)[at]) < hand.pad_width / 2.0) & (np.abs(y) < half[pair])
    met = np.bincount(pair[closed], minlength=count) > stray
    hits = _Hits(sought, around)
    hits.add(pads, pair[closed], at[closed])
    hits.tell("pads", met, sought.dropped)
    brushed = np.zeros(count, dtype=bool)
    for what, reach, prisms in (("fingers", fingers, hand.finger), ("hand", palm, hand.body)):
        left, hits = np.flatnonzero(~met), _Hits(sought, around)
        passed = _passed(reach, prisms, look, hold.of(left), hand, hits)
        brushed[left], met[left] = brushed[left] | passed[0], passed[1]
        hits.tell(what, passed[1], sought.dropped)
    return np.where(met, 0.0, np.where(brushed, PINCH_TIGHT, 1.0))


class _Hits:
    """Whose points a part of the hand meets in each pair of direction and depth."""

    def __init__(self, sought: Sought, around: Surroundings) -> None:
        own, self.stray = len(sought.surface.points), sought.tolerances.stray_points
        self._owners = np.concatenate([np.full(own, len(around.names)), around.owners])
        self._names = (*around.names, ITSELF)
        self._found: list[IntArray] = []

    def add(self, reach: _Reach, pair: IntArray, at: IntArray) -> None:
        """Points of a reach that are met in pairs."""
        self._found.append(pair * len(self._names) + self._owners[reach.index.reshape(-1)[at]])

    def tell(self, what: str, met: BoolArray, dropped: Dropped) -> None:
        """Note for each pair in which a part of the hand meets too much whose points most of that are."""
        if not met.any():
            return
        shape = len(met), len(self._names)
        counts = np.bincount(np.concatenate(self._found), minlength=shape[0] * shape[1]).reshape(shape)
        for owner, count in enumerate(np.bincount(np.argmax(counts[met], axis=1), minlength=shape[1])):
            dropped.no_room(what, self._names[owner], int(count))


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
        index, there = packed(near & (z < shift + np.float32(front + ROUGH)))
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


def _passed(
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


def _best_and_deepest(
    look: _Look, hold: _Hold, clearance: FloatArray, held: FloatArray, sought: Sought, hand: HandShape
) -> list[Grasp]:
    """The best-scored and the deepest pinch of each direction."""
    surface, tolerances = sought.surface, sought.tolerances
    com = ((surface.centre - look.origin) @ look.rotations)[hold.row]
    arm = com - np.column_stack([np.zeros(len(com)), hold.middle, hold.tip - hand.tip])
    width, weight = hold.high - hold.low, weight_of(surface.volume, surface.mass)
    down = -(sought.up @ look.rotations)[hold.row]
    load = jaw_load(arm, down, weight, width, hold.depth, hand, tolerances.friction)
    rim = np.abs(arm[:, 1]) > width / 2.0 + 0.01
    terms = {
        "antipodality": held,
        "balance": 1.0 / (1.0 + ((arm[:, 0] ** 2 + arm[:, 1] ** 2) / tolerances.lever**2)),
        "clearance": clearance,
        "depth": np.minimum(1.0, hold.depth / (0.5 * hand.pad_length)),
        "upright": 1.0 - 0.5 * look.tilts[hold.row],
    }
    chance = chance_to_hold(load, surface.mass is not None)
    total = np.sum(list(terms.values()), axis=0) * chance
    found: list[Grasp] = []
    for row in np.unique(hold.row):
        here = np.flatnonzero(hold.row == row)
        best, deepest = int(here[np.argmax(total[here])]), int(here[-1])
        for k in (best, deepest) if best != deepest else (best,):
            pose = np.eye(4)
            pose[:3, :3] = look.rotations[row]
            shift = np.array([0.0, hold.middle[k], hold.tip[k] - hand.tip])
            pose[:3, 3] = look.origin + look.rotations[row] @ shift
            parts = {name: float(values[k]) for name, values in terms.items()}
            said = ", ".join(f"{term} {value:.2f}" for term, value in parts.items())
            reason = (
                f"{1e3 * float(width[k]):.0f} mm between the pads, tips {rounded(1e3 * float(hold.depth[k]))}"
                f" mm deep; {said}{in_words(float(load[k]))}"
            )
            parts[HOLD] = float(chance[k])
            kind, size = RIM if rim[k] else PINCH, (float(width[k]), float(hold.opening[k]))
            found.append(Grasp(sought.name, kind, pose, *size, score_of(parts), reason, parts))
    return found
