"""Taking hold with a suction cup: smooth patches as wide as the cup, near the centre of mass."""

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from topple.planner.grasp.frames import spread
from topple.planner.grasp.grasp import GraspKind
from topple.planner.grasp.hand import hand_bodies
from topple.planner.grasp.prisms import Prism, prisms
from topple.planner.grasp.score import score_of
from topple.planner.grasp.surface import Surface
from topple.planner.grasp.surroundings import ITSELF, Dropped, Surroundings
from topple.planner.grasp.tolerances import (
    FINGER_SLABS,
    GRASP_TOLERANCES,
    LEAST_INSIDE,
    RING,
    SUCTION_BRUSH,
    SUCTION_TIGHT,
    GraspTolerances,
)
from topple.robots.arm.gripper import SuctionCup, ToolName, lip_plane
from topple.topology.base.arrays import BoolArray, FloatArray, IntArray
from topple.topology.base.errors import InvalidInput

if TYPE_CHECKING:
    from topple.robots.arm.arm import Arm

SECTORS = 8  # the lip is judged in eight parts: a gap in any of them leaks
SPARSE = "too few points for a cup's lip"
STEEP = "too steep for the cup"
UNEVEN = "no smooth patch as wide as the cup's lip"


@dataclass(frozen=True)
class CupShape:
    """A suction cup and what is around it, in its tool frame (z approach, origin at the lip's centre).

    Attributes:
        radius: Of the lip [m].
        max_force: Largest pull along its axis [N].
        lip_depth: Unevenness that its rubber bridges [m].
        friction: Coefficient between its lip and the object.
        body: Prisms of the hand with the cup out.
        opening: Opening of the fingers beside it [m].
    """

    radius: float
    max_force: float
    lip_depth: float
    friction: float
    body: tuple[Prism, ...]
    opening: float = 0.0

    def beside(self, points: FloatArray, margin: float) -> BoolArray:
        """Which points (N, 3), in the tool frame [m], are in the cup or the way behind it, or next to it.

        Args:
            points: What the cup does not take: that may bulge into the bellows.
            margin: How close is next to it; up to as far behind the lip is still the patch itself [m].
        """
        return (np.hypot(points[:, 0], points[:, 1]) < self.radius + margin) & (points[:, 2] < -margin)


def cup_shape(arm: "Arm") -> CupShape:
    """Measure an arm's suction cup with the hand around it, the cup out.

    Args:
        arm: An arm with a tool named "suction".

    Returns:
        The shape.
    """
    tool = arm.tools[ToolName.SUCTION]
    cup = tool.gripper
    if not isinstance(cup, SuctionCup):
        raise InvalidInput(f"robot {arm.name!r}: its tool 'suction' is no suction cup")
    bodies = hand_bodies(arm, ToolName.SUCTION, tool.ready)
    body = tuple(
        prism for link, vertices in bodies if link != cup.link for prism in prisms(vertices, FINGER_SLABS)
    )
    return CupShape(cup.radius, cup.max_force, cup.lip_depth, cup.friction, body, tool.ready.opening)


@dataclass(frozen=True, eq=False)
class Patch:
    """A place for the cup.

    Attributes:
        pose_tool_to_world: (4, 4).
        residual: Largest unevenness under the lip [m].
        terms: Parts of the score, each in 0..1.
    """

    pose_tool_to_world: FloatArray
    residual: float
    terms: dict[str, float]


def patches(
    surface: Surface,
    dense: FloatArray,
    around: Surroundings,
    up: FloatArray,
    cup: CupShape,
    count: int = 40,
    tolerances: GraspTolerances = GRASP_TOLERANCES,
    dropped: Dropped | None = None,
) -> list[Patch]:
    """Find where a cup would seal.

    Args:
        surface: The object.
        dense: (N, 3) its cloud, unthinned, which the seal is judged on [m].
        around: Points of everything else nearby.
        up: (3,) unit vector against gravity.
        cup: The cup.
        count: Places to try.
        tolerances: What the cup's bellows takes up.
        dropped: Takes down what is left out and why, if given.

    Returns:
        The places where it seals and the hand has room, best first. Deterministic.
    """
    dropped = Dropped() if dropped is None else dropped
    seen = np.arange(len(surface.points)) < surface.seen
    facing = seen & (surface.normals @ up > np.cos(tolerances.seal_tilt + 0.15))
    if not facing.any():
        dropped.note(STEEP)
        return []
    spots, normals = surface.points[facing], surface.normals[facing]
    flat_centre = surface.centre + up * float(np.median((spots - surface.centre) @ up))
    found: list[Patch] = []
    for index in spread(spots, flat_centre, count):
        near = dense[np.linalg.norm(dense - spots[index], axis=1) < 1.4 * cup.radius]
        near = near[_this_side(near - spots[index], normals[index], cup.lip_depth)]
        patch = _patch(spots[index], surface, near, around, up, cup, tolerances, dropped)
        if patch is not None:
            found.append(patch)
    return sorted(found, key=lambda patch: -score_of(GraspKind.SUCTION, patch.terms))


def _patch(
    spot: FloatArray,
    surface: Surface,
    near: FloatArray,
    around: Surroundings,
    up: FloatArray,
    cup: CupShape,
    tolerances: GraspTolerances,
    dropped: Dropped,
) -> Patch | None:
    if len(near) < 4 * SECTORS:
        dropped.note(SPARSE)
        return None
    normal, middle = _robust_plane(near, up)
    tilt = float(np.arccos(np.clip(normal @ up, -1.0, 1.0)))
    if tilt > tolerances.seal_tilt:
        dropped.note(STEEP)
        return None
    centre = spot - normal * float((spot - middle) @ normal)
    residual = _lip_residual(near - centre, normal, cup.radius)
    if residual > cup.lip_depth:
        dropped.note(UNEVEN)
        return None
    rotation = _rotation(-normal, up)
    clearance = _room(surface.points, around, centre, rotation, cup, tolerances, dropped)
    if clearance is None:
        return None
    arm = surface.centre - centre
    lever = float(np.linalg.norm(arm - normal * float(arm @ normal)))
    terms = {
        "seal": float(np.exp(-0.5 * (residual / tolerances.seal_tolerance) ** 2)),
        "balance": float(1.0 / (1.0 + (lever / cup.radius / 1.5) ** 2)),
        "upright": 1.0 - tilt / tolerances.seal_tilt,
        "clearance": clearance,
    }
    pose = np.eye(4)
    pose[:3, :3], pose[:3, 3] = rotation, centre
    return Patch(pose, residual, terms)


def _this_side(offsets: FloatArray, normal: FloatArray, gap: float) -> BoolArray:
    """Which points (N, 3) from a spot [m] are not below a gap under it: thin things show their undersides."""
    heights = offsets @ normal
    below = np.append(0.0, -np.sort(-heights[heights < 0.0]))
    jumps = np.flatnonzero(-np.diff(below) > gap)
    return heights >= (below[jumps[0]] if len(jumps) else -np.inf)


def _robust_plane(points: FloatArray, up: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Plane (unit normal turned up, middle) fitted twice, without the tenth that fits worst."""
    kept = points
    normal, middle = up, points.mean(axis=0)
    for _ in range(2):
        middle = kept.mean(axis=0)
        _, _, axes = np.linalg.svd(kept - middle, full_matrices=False)
        normal = axes[2] if axes[2] @ up >= 0 else -axes[2]
        distance = np.abs((points - middle) @ normal)
        kept = points[distance <= np.quantile(distance, 0.9)]
    return normal, middle


def _lip_residual(offsets: FloatArray, normal: FloatArray, radius: float) -> float:
    """Unevenness the lip meets [m], inf where a sector of it lies on nothing.

    Each sector of the ring counts by its median height, which averages the depth noise but keeps steps, rims
    and curvature; so does all that is within it, and each sector of that with points enough to tell noise
    from what stands up and would hold the lip off.
    """
    rotation = _rotation(-normal, normal)
    flat, heights = offsets @ rotation[:, :2], offsets @ normal
    distance = np.hypot(*flat.T)
    sector = ((np.arctan2(flat[:, 1], flat[:, 0]) + np.pi) / (2.0 * np.pi) * SECTORS).astype(int) % SECTORS
    within = distance < RING[0] * radius
    ring = _medians(flat, heights, np.where(~within & (distance < RING[1] * radius), sector, -1))
    if len(ring) < SECTORS:
        return float("inf")
    plane, uneven = lip_plane(ring[:, :2], ring[:, 2])
    whole = _medians(flat, heights, np.where(within, 0, -1))
    parts = _medians(flat, heights, np.where(within, sector, -1), LEAST_INSIDE)
    inner = np.concatenate([whole, parts])
    above = inner[:, 2] - inner[:, :2] @ plane[:2] - plane[2]
    return max(uneven, float(above.max(initial=0.0)))


def _medians(flat: FloatArray, heights: FloatArray, group: IntArray, least: int = 1) -> FloatArray:
    """(k, 3) mean place and median height [m] of every group (N,) with so many points; -1 is none."""
    chosen = [np.flatnonzero(group == each) for each in range(SECTORS)]
    found = [[*flat[own].mean(axis=0), np.median(heights[own])] for own in chosen if len(own) >= least]
    return np.array(found).reshape(-1, 3)


def _rotation(approach: FloatArray, up: FloatArray) -> FloatArray:
    """A right-handed frame whose z is the approach; its x is as level with the world's axes as it can be."""
    axis = np.eye(3)[int(np.argmin(np.abs(approach)))]
    y = np.cross(approach, axis)
    y /= np.linalg.norm(y)
    return np.asarray(np.column_stack([np.cross(y, approach), y, approach]), dtype=np.float64)


def _room(
    own: FloatArray,
    around: Surroundings,
    centre: FloatArray,
    rotation: FloatArray,
    cup: CupShape,
    tolerances: GraspTolerances,
    dropped: Dropped,
) -> float | None:
    """How free the way in is, 0..1, or None where the hand meets points."""
    foreign, margin = (around.points - centre) @ rotation, tolerances.under_clearance
    met = cup.beside(foreign, margin)
    if np.count_nonzero(met) > tolerances.stray_points:
        dropped.no_room("cup", around.met(met))
        return None
    brushed = False
    for points in ((own - centre) @ rotation, foreign):
        met = _inside(points, cup.body, margin, margin, tolerances)
        if met.any():
            dropped.no_room("hand", around.met(met) if points is foreign else ITSELF)
            return None
        brushed = brushed or bool(_inside(points, cup.body, SUCTION_BRUSH, SUCTION_BRUSH, tolerances).any())
    return SUCTION_TIGHT if brushed else 1.0


def _inside(
    points: FloatArray, prisms: tuple[Prism, ...], aside: float, before: float, tolerances: GraspTolerances
) -> BoolArray:
    """Which points in the tool's frame are in a prism, wider by `aside`, with more than stray points."""
    found = np.zeros(len(points), dtype=bool)
    for prism in prisms:
        lower, upper = np.array([prism.x[0], prism.y[0]]), np.array([prism.x[1], prism.y[1]])
        inside = np.all((points[:, :2] > lower - aside) & (points[:, :2] < upper + aside), axis=1)
        inside &= points[:, 2] < prism.front + before
        if np.count_nonzero(inside) > tolerances.stray_points:
            found |= inside
    return found
