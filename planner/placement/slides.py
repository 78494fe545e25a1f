"""Slides: a thing that no hand takes where it lies is pushed along its top until it hangs over an edge.

Two fingers push against its side, as far apart as the jaw opens and to either side of its centre of mass:
what is pushed so goes straight (Lynch and Mason, Stable Pushing, 1996), whatever friction there is below.
"""

from dataclasses import dataclass

import numpy as np

from topple.planner.grasp.grasp import Grasp, GraspKind
from topple.planner.grasp.hand import HandShape
from topple.planner.placement.placement import Placement
from topple.planner.placement.tolerances import (
    BALANCED,
    BOTH_PUSH,
    HANGS,
    LIES,
    LONGEST_SLIDE,
    ONE_SIDE,
    OVER_TOP,
    PUSH_DIRECTIONS,
    PUSHES,
)
from topple.topology.arrays import FloatArray
from topple.topology.bodies.edges import Edge, edge_ahead, top_under
from topple.topology.bodies.solids import hull_vertices
from topple.topology.geometry.axes import cross, level_axes
from topple.topology.geometry.samples import centre_of_mass
from topple.topology.geometry.sides import way_out
from topple.topology.situation import Situation


@dataclass(frozen=True, eq=False)
class Slide:
    """A way to push a thing over an edge.

    Attributes:
        grasp: Where the fingers touch it.
        placement: Where it then lies.
        ahead: (3,) level unit vector, where it is pushed.
    """

    grasp: Grasp
    placement: Placement
    ahead: FloatArray

    @property
    def length(self) -> float:
        """How far it goes [m]."""
        return float(np.linalg.norm(self.placement.pose_before_to_after[:3, 3]))


def slides(name: str, situation: Situation, hand: HandShape) -> list[Slide]:
    """Find ways to push a thing until it hangs over an edge far enough to be pinched.

    Args:
        name: The object.
        situation: Where everything is. What is in the way is not asked.
        hand: The fingers.

    Returns:
        The ways, shortest first; none where it does not lie on a top, where that was not seen to end, where
        the thing is too short to hang over and stay, or has no side that both fingers meet.
    """
    scene, up = situation.scene, situation.up
    found = top_under(name, scene)
    if found is None:
        return []
    owner, top = found
    body = hull_vertices(np.vstack([scene.clouds[name], *situation.completed[name]]))
    heights = top.above(body)
    if float(heights.min()) > LIES:
        return []
    centre = centre_of_mass(scene.clouds[name], situation.completed[name])
    axes = np.stack(level_axes(up))
    ways: list[Slide] = []
    for angle, reach in _sides(body - centre, float(heights.max()), axes, up, hand):
        ahead = np.array([np.cos(angle), np.sin(angle)]) @ axes
        flat = _seen_along(body - centre, ahead, up)
        edge = edge_ahead(
            owner, top, scene, centre, ahead, [(float(flat[:, 1].min()), float(flat[:, 1].max()))]
        )
        if edge is None or (way := _way(flat, centre, ahead, edge)) is None:
            continue
        pose, moved = np.eye(4), np.eye(4)
        pose[:3, :3] = np.column_stack([ahead, cross(-up, ahead), -up])
        place = centre + reach * ahead
        pose[:3, 3] = place + (OVER_TOP + hand.tip - float(top.above(place[None])[0])) * top.normal
        moved[:3, 3] = way[0] * ahead
        score = float(ahead @ edge.outward)  # the less askew the better
        why = f"two fingers {1e3 * hand.max_opening:.0f} mm apart push against its side"
        grasp = Grasp(name, GraspKind.PUSH, pose, hand.max_opening, hand.max_opening, score, why)
        words = f"{1e3 * way[1]:.0f} mm over the edge of {owner}"
        ways.append(Slide(grasp, Placement(moved, score, words), ahead))
    return sorted(ways, key=lambda way: way.length)[:PUSHES]


def _sides(
    body: FloatArray, rise: float, axes: FloatArray, up: FloatArray, hand: HandShape
) -> list[tuple[float, float]]:
    """Directions [rad] to push a body (V, 3) in, square to its sides, and where the hand is along them."""
    angles = np.arange(PUSH_DIRECTIONS) * (2.0 * np.pi / PUSH_DIRECTIONS)
    met = [_touch(_seen_along(body, np.array([np.cos(a), np.sin(a)]) @ axes, up), rise, hand) for a in angles]
    late = np.array([np.inf if touch is None else touch[1] for touch in met])
    wide = int(np.ceil(ONE_SIDE / (2.0 * np.pi / PUSH_DIRECTIONS)))
    near = np.min([np.roll(late, shift) for shift in range(-wide, wide + 1)], axis=0)
    best = np.flatnonzero(np.isfinite(late) & (late <= near))
    return [(float(angles[number]), touch[0]) for number in best if (touch := met[number]) is not None]


def _seen_along(body: FloatArray, ahead: FloatArray, up: FloatArray) -> FloatArray:
    """Points (V, 2) of a body (V, 3): along the way, and to its left [m]."""
    return np.column_stack([body @ ahead, body @ cross(up, ahead)])


def _touch(flat: FloatArray, rise: float, hand: HandShape) -> tuple[float, float] | None:
    """Where along the way the hand is as its fingers touch an outline (V, 2), and how much later one is [m].

    None where that is more than `BOTH_PUSH`, where the palm is first, or where a corner stands out between.
    """
    half, rear = hand.max_opening / 2.0, _rear(flat)
    tall = [p for p in hand.finger if OVER_TOP + hand.tip - p.front < rise]
    palm = [p for p in hand.palm if OVER_TOP + hand.tip - p.front < rise]
    rows = [[(side * (half + p.y[0]), side * (half + p.y[1]), p) for p in tall] for side in (1.0, -1.0)]
    back = [min((_least(rear, a, b) for a, b, _ in row), default=np.inf) for row in rows]
    touch = [
        min((_least(rear, a, b) - max(-p.x[0], p.x[1]) for a, b, p in row), default=np.inf) for row in rows
    ]
    first, late = min(touch), max(touch)
    if not np.isfinite(late) or late - first > BOTH_PUSH or _least(rear, -half, half) < min(back) - BOTH_PUSH:
        return None
    if any(_least(rear, *p.y) - max(-p.x[0], p.x[1]) < late + BOTH_PUSH for p in palm):
        return None
    return first, late - first


def _rear(flat: FloatArray) -> FloatArray:
    """(K, 2) the rear of the hull of points (V, 2): where its first coordinate is least, by rising second."""
    chain: list[FloatArray] = []
    for point in flat[np.lexsort((flat[:, 0], flat[:, 1]))]:
        if chain and point[1] - chain[-1][1] < 1e-9:
            continue
        while len(chain) > 1 and not _stands_back(chain[-2], chain[-1], point):
            chain.pop()
        chain.append(point)
    return np.array(chain)


def _stands_back(a: FloatArray, b: FloatArray, c: FloatArray) -> bool:
    """Whether b (2,) is farther back than the line from a to c."""
    return bool(b[0] < a[0] + (b[1] - a[1]) / (c[1] - a[1]) * (c[0] - a[0]))


def _least(rear: FloatArray, one: float, other: float) -> float:
    """How far back a rear (K, 2) reaches between two second coordinates [m]; infinite beyond its ends."""
    low, high = max(min(one, other), rear[0, 1]), min(max(one, other), rear[-1, 1])
    if low > high:
        return np.inf
    between = rear[(rear[:, 1] > low) & (rear[:, 1] < high), 0]
    return float(min(np.interp([low, high], rear[:, 1], rear[:, 0]).min(), between.min(initial=np.inf)))


def _way(flat: FloatArray, centre: FloatArray, ahead: FloatArray, edge: Edge) -> tuple[float, float] | None:
    """How far a thing is to be pushed, and how far it then hangs over [m]; None where it would not stay."""
    square = float(ahead @ edge.outward)
    front = way_out(flat)
    if front is None:
        return None
    over = float(edge.beyond(centre + front * ahead))
    most = (-BALANCED - float(edge.beyond(centre))) / square
    least = (HANGS[0] - over) / square
    way = min(most, (HANGS[1] - over) / square)
    if not 0.0 < least <= most or way > LONGEST_SLIDE:
        return None
    return way, over + square * way
