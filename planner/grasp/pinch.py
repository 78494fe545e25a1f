"""Pinching between two fingers: where pads can reach an object's sides past everything around it."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from topple.planner.grasp.hand import HandShape
from topple.planner.grasp.surface import Surface
from topple.planner.grasp.tolerances import GRASP_TOLERANCES, GraspTolerances
from topple.topology.arrays import BoolArray, FloatArray

OWN_MARGIN = 0.0005  # fingers may come this close to the object they take [m]
BRUSH = (0.006, 0.01)  # beside and below the hand: less room than this halves the clearance term [m]
NORMAL_BIAS = (
    0.15  # normals next to a silhouette average in what lies before it, 3 mm of a can: 9 degrees [rad]
)
CENTRAL = 0.03  # around the centre of mass, where a grasp hardly turns in the hand [m]
SLOPED = 0.2  # a level top has normals square to the closing direction, give or take 10 degrees of noise
SLOPE_LENGTH = 0.01  # below the tips, where the object's widening tells a slope from noise [m]


@dataclass(frozen=True, eq=False)
class Frame:
    """A hand direction to try at a point of the object.

    Attributes:
        origin: (3,) point of the object [m].
        rotation: (3, 3) columns x, y (closing), z (approach) in the world.
        tilt: Angle between the approach and straight down [rad].
    """

    origin: FloatArray
    rotation: FloatArray
    tilt: float


@dataclass(frozen=True, eq=False)
class Pinch:
    """A pinch found in a frame.

    Attributes:
        pose_tool_to_world: (4, 4).
        width: Extent between the pads [m].
        opening: Distance of the pads on the way in [m].
        depth: Finger tips below the object's top between the pads [m].
        rim: Whether the object goes on beyond one of the fingers.
        terms: Parts of the score, each in 0..1.
    """

    pose_tool_to_world: FloatArray
    width: float
    opening: float
    depth: float
    rim: bool
    terms: dict[str, float]


def frames(surface: Surface, up: FloatArray, tilts: Sequence[float], count: int = 32) -> list[Frame]:
    """Lay out the hand directions to try: points spread over the object x closing directions x tilts.

    Args:
        surface: The object.
        up: (3,) unit vector against gravity.
        tilts: Angles between the approach and straight down, about the closing axis [rad].
        count: Points of the object to try.

    Returns:
        The frames, nearest to the centre of mass first. Deterministic.
    """
    points = surface.points[: surface.seen]
    flat = points - np.outer(points @ up, up)
    across_all = _closing_directions(points, up)
    found: list[Frame] = []
    for origin in _places(points, surface.centre, up, count):
        near = points[np.linalg.norm(flat - (origin - up * float(origin @ up)), axis=1) < 0.02]
        normal = _facing(near, up)
        closings = _distinct([*_closing_directions(near, up), *across_all])
        for closing in closings:
            # on a face that leans sideways the pads close along the face, or a thin thing rolls in them
            along = closing - up * float(closing @ normal) / float(normal @ up)
            along /= np.linalg.norm(along)
            across = cross(up, along)
            across /= np.linalg.norm(across)
            down = cross(across, along)
            for tilt in tilts:
                approach = np.cos(tilt) * down + np.sin(tilt) * across
                rotation = np.column_stack([cross(along, approach), along, approach])
                found.append(Frame(origin, rotation, float(np.arccos(np.clip(-approach @ up, -1.0, 1.0)))))
    return found


def _places(points: FloatArray, centre: FloatArray, up: FloatArray, count: int) -> list[FloatArray]:
    """Points to try: spread over the object, and closer together around its centre of mass."""
    offsets = points - centre
    aside = np.linalg.norm(offsets - np.outer(offsets @ up, up), axis=1)
    central = points[aside < CENTRAL]
    chosen = [points[index] for index in spread(points, centre, count)]
    return chosen + [central[index] for index in spread(central, centre, count // 4)]


def _facing(points: FloatArray, up: FloatArray) -> FloatArray:
    """Normal of the face some points lie on, where they lie on one that faces up; up otherwise."""
    if len(points) < 8:
        return up
    values, vectors = np.linalg.eigh(np.cov(points.T))
    normal = vectors[:, 0] if vectors[:, 0] @ up > 0 else -vectors[:, 0]
    return normal if values[0] < 0.15 * values[1] and normal @ up > 0.8 else up


def cross(a: FloatArray, b: FloatArray) -> FloatArray:
    """Cross product of two (3,) vectors, without the overhead of the general one."""
    (ax, ay, az), (bx, by, bz) = a.tolist(), b.tolist()
    return np.array([ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx])


def spread(points: FloatArray, first: FloatArray, count: int) -> list[int]:
    """Pick points far from one another (farthest point sampling).

    Args:
        points: (N, 3) points [m].
        first: (3,) the sampling starts at the point nearest to this one.
        count: How many.

    Returns:
        Indices of the picked points.
    """
    if len(points) == 0:
        return []
    chosen = [int(np.argmin(np.linalg.norm(points - first, axis=1)))]
    distance = np.linalg.norm(points - points[chosen[0]], axis=1)
    while len(chosen) < min(count, len(points)):
        chosen.append(int(np.argmax(distance)))
        distance = np.minimum(distance, np.linalg.norm(points - points[chosen[-1]], axis=1))
    return chosen


def _closing_directions(points: FloatArray, up: FloatArray) -> list[FloatArray]:
    """Level directions to close along: across the narrow side first; four where none stands out."""
    east = np.cross(up, [0.0, 1.0, 0.0] if abs(up[1]) < 0.9 else [1.0, 0.0, 0.0])
    east /= np.linalg.norm(east)
    north = np.cross(up, east)
    if len(points) < 4:
        return [east, north]
    plane = np.stack([(points - points.mean(axis=0)) @ east, (points - points.mean(axis=0)) @ north])
    values, vectors = np.linalg.eigh(plane @ plane.T)
    narrow = vectors[0, 0] * east + vectors[1, 0] * north
    wide = vectors[0, 1] * east + vectors[1, 1] * north
    if values[0] < 0.5 * values[1]:
        return [narrow, wide]
    turns = np.arange(4) * np.pi / 4.0
    return [np.cos(turn) * narrow + np.sin(turn) * wide for turn in turns]


def _distinct(directions: list[FloatArray], angle: float = 0.2) -> list[FloatArray]:
    kept: list[FloatArray] = []
    for direction in directions:
        if all(abs(float(direction @ other)) < np.cos(angle) for other in kept):
            kept.append(direction)
    return kept


def pinches(
    frame: Frame,
    surface: Surface,
    others: FloatArray,
    floor: float,
    up: FloatArray,
    hand: HandShape,
    tolerances: GraspTolerances = GRASP_TOLERANCES,
) -> list[Pinch]:
    """Find how deep the fingers can go in one frame, and what they would hold.

    Args:
        frame: Point and directions of the hand.
        surface: The object.
        others: (M, 3) points of everything else nearby [m].
        floor: Height along `up` nothing of the hand may go below [m].
        up: (3,) unit vector against gravity.
        hand: The hand.
        tolerances: Clearances and depths.

    Returns:
        At most two pinches: the deepest free one and the best-scored one.
    """
    own = (surface.points - frame.origin) @ frame.rotation
    strip = (np.abs(own[:, 0]) <= hand.pad_width / 2.0) & (np.abs(own[:, 1]) <= hand.max_opening / 2.0)
    if np.count_nonzero(strip) < 4:
        return []
    foreign = (others - frame.origin) @ frame.rotation
    top = float(np.sort(own[strip, 2])[min(tolerances.stray_points, np.count_nonzero(strip) - 1)])
    look = _Look(
        frame,
        own,
        surface.normals @ frame.rotation,
        strip,
        (surface.centre - frame.origin) @ frame.rotation,
        top,
        up @ frame.rotation,
        float(frame.origin @ up - floor),
        *_in_reach(own, foreign, top, hand, tolerances),
    )
    found = [pinch for depth in tolerances.depths if (pinch := _at_depth(look, depth, hand, tolerances))]
    if not found:
        return []
    best = max(found, key=lambda pinch: sum(pinch.terms.values()))
    return [best] if best is found[-1] else [best, found[-1]]


@dataclass(frozen=True, eq=False)
class _Look:
    """An object and its surroundings seen along one hand direction: all in the frame's axes."""

    frame: Frame
    own: FloatArray
    normals: FloatArray
    strip: BoolArray
    com: FloatArray
    top: float
    up: FloatArray
    over_floor: float
    at_fingers: FloatArray  # (K, 5): x, y, z, margin, whether it is the object's own
    at_palm: FloatArray


def _in_reach(
    own: FloatArray, foreign: FloatArray, top: float, hand: HandShape, tolerances: GraspTolerances
) -> tuple[FloatArray, FloatArray]:
    """The points fingers and palm can meet at any depth, with the margin each keeps to them."""
    points = np.vstack(
        [
            np.column_stack([own, np.full(len(own), OWN_MARGIN), np.ones(len(own))]),
            np.column_stack(
                [foreign, np.full(len(foreign), tolerances.under_clearance), np.zeros(len(foreign))]
            ),
        ]
    )
    deepest = top + max(tolerances.depths) - hand.tip + BRUSH[1]
    found: list[FloatArray] = []
    for group in (hand.finger, hand.palm):
        wide = max(max(-prism.x[0], prism.x[1]) for prism in group) + BRUSH[0] if group else 0.0
        front = max(prism.front for prism in group) if group else -np.inf
        found.append(points[(np.abs(points[:, 0]) < wide) & (points[:, 2] < deepest + front)])
    return found[0], found[1]


def _at_depth(look: _Look, depth: float, hand: HandShape, tolerances: GraspTolerances) -> Pinch | None:
    """What the hand holds with its tips `depth` below the object's top, or None where it cannot go there."""
    own, tip = look.own, look.top + depth
    window = look.strip & (own[:, 2] <= tip) & (own[:, 2] >= tip - hand.pad_length)
    if np.count_nonzero(window) < 3:
        return None
    low, high = _extent(own[window, 1], tolerances)
    window &= (own[:, 1] >= low) & (own[:, 1] <= high)
    width, middle = high - low, (high + low) / 2.0
    if width + 2.0 * tolerances.least_side_clearance > hand.max_opening:
        return None
    opening = min(hand.max_opening, width + 2.0 * tolerances.side_clearance)
    shift = np.array([0.0, middle, tip - hand.tip])
    if _lowest_corner(look, shift, hand, opening) < tolerances.under_clearance:
        return None
    clearance = _room(look, shift, hand, opening, tolerances)
    if clearance is None:
        return None
    held = _antipodality(look, window, low, high, opening, hand, tolerances)
    if held <= 0.0:
        return None
    lever = float(np.hypot(look.com[0], look.com[1] - middle))
    terms = {
        "antipodality": held,
        "balance": float(1.0 / (1.0 + (lever / tolerances.lever) ** 2)),
        "clearance": clearance,
        "depth": min(1.0, depth / (0.5 * hand.pad_length)),
        "upright": 1.0 - 0.5 * look.frame.tilt,
    }
    pose = np.eye(4)
    pose[:3, :3] = look.frame.rotation
    pose[:3, 3] = look.frame.origin + look.frame.rotation @ shift
    rim = abs(float(look.com[1]) - middle) > width / 2.0 + 0.01
    return Pinch(pose, width, opening, depth, rim, terms)


def _extent(values: FloatArray, tolerances: GraspTolerances) -> tuple[float, float]:
    """Bounds of the values around 0 up to a gap a finger could enter; one in fifty is left out."""
    ordered = np.sort(values)
    ends = np.flatnonzero(np.diff(ordered) > 2.5 * tolerances.spacing)
    runs = np.split(ordered, ends + 1)
    run = min(runs, key=lambda values: float(np.abs(values).min()))
    skip = len(run) // 50
    return float(run[skip]), float(run[len(run) - 1 - skip])


def _room(
    look: _Look, shift: FloatArray, hand: HandShape, opening: float, tolerances: GraspTolerances
) -> float | None:
    """How free the way in is, 0..1, or None where the hand meets points."""
    worst = 1.0
    fingers = 2 * len(hand.finger)
    for number, (x0, x1, y0, y1, front) in enumerate(hand.footprints(opening)):
        points = look.at_fingers if number < fingers else look.at_palm
        x, y, z, margin = points[:, 0], points[:, 1] - shift[1], points[:, 2] - shift[2], points[:, 3]
        # distance beside the footprint, negative within
        aside = np.maximum(np.maximum(x0 - x, x - x1), np.maximum(y0 - y, y - y1))
        if np.count_nonzero((aside < margin) & (z < front + margin)) > tolerances.stray_points:
            return None
        if np.count_nonzero((aside < BRUSH[0]) & (z < front + BRUSH[1])) > tolerances.stray_points:
            worst = 0.4
    x, y, z, own = (look.at_fingers[:, k] for k in (0, 1, 2, 4))
    between = (own < 0.5) & (np.abs(x) < hand.pad_width / 2.0) & (np.abs(y - shift[1]) < opening / 2.0)
    if np.count_nonzero(between & (z - shift[2] < hand.tip)) > tolerances.stray_points:
        return None  # a neighbour would be pinched along
    return worst


def _lowest_corner(look: _Look, shift: FloatArray, hand: HandShape, opening: float) -> float:
    """Height of the hand's lowest corner over the floor [m]."""
    x, y, z = look.up
    lowest = min(
        min(x * x0, x * x1) + min(y * y0, y * y1) + z * front
        for x0, x1, y0, y1, front in hand.footprints(opening)
    )
    return look.over_floor + float(shift @ look.up) + lowest


def _antipodality(
    look: _Look,
    window: BoolArray,
    low: float,
    high: float,
    opening: float,
    hand: HandShape,
    tolerances: GraspTolerances,
) -> float:
    """How well two opposed pads hold: 1 for faces square to the closing direction, 0 at the friction cone.

    Where the object's side is seen its normals decide. Where the silhouette ends between the pads (thin or
    steep sides, not seen from above) the outline's direction within the pads does, and the hidden side is
    taken as upright. Where the object widens below the tips, the pads meet a slope.
    """
    own, cone, worst = look.own, np.arctan(tolerances.friction), 1.0
    tip, middle = float(own[window, 2].max()), (low + high) / 2.0
    below = look.strip & (own[:, 2] > tip) & (own[:, 2] < tip + SLOPE_LENGTH)
    beyond = own[below & (np.abs(own[:, 1] - middle) < opening / 2.0), 1]
    for side, edge in ((-1.0, low), (1.0, high)):
        contact = window & (np.abs(own[:, 1] - edge) < 0.003)
        if abs(float(own[contact, 0].mean())) > 0.3 * hand.pad_width:
            return 0.0  # only a pad's edge would touch
        facing = look.normals[contact]
        seen = facing[facing @ np.array([0.0, side, 0.0]) > 0.5]
        if len(seen) >= max(2, 0.3 * len(facing)):
            mean = seen.mean(axis=0)
            angle = float(np.arccos(np.clip(side * mean[1] / np.linalg.norm(mean), -1.0, 1.0)))
            angle = max(0.0, angle - NORMAL_BIAS)
        elif float(np.median(facing @ np.array([0.0, side, 0.0]))) > SLOPED:
            return 0.0  # a seen face, and too flat a slope to press on: pads would slide off its wedge
        else:
            angle = 0.25 * cone + _outline_angle(own[window], side)
        widening = float((side * beyond).max()) - side * edge if len(beyond) > 0 else 0.0
        if widening > tolerances.spacing:
            angle = max(angle, float(np.arctan2(widening, SLOPE_LENGTH)))
        worst = min(worst, 1.0 - angle / cone)
    return max(0.0, worst)


def _outline_angle(points: FloatArray, side: float) -> float:
    """Angle between the pad and the object's outline along x, from the outermost points of slices [rad]."""
    low, high = float(points[:, 0].min()), float(points[:, 0].max())
    if high - low < 0.004:
        return 0.0  # a rod along the approach
    slices = np.minimum(((points[:, 0] - low) / (high - low) * 4).astype(int), 3)
    middles, edges = [], []
    for index in range(4):
        inside = points[slices == index]
        if len(inside) > 0:
            outermost = inside[np.argmax(side * inside[:, 1])]
            middles.append(outermost[0])
            edges.append(outermost[1])
    if len(middles) < 3:
        return 0.0
    slope = float(np.polyfit(np.array(middles), np.array(edges), 1)[0])
    return float(abs(np.arctan(slope)))
