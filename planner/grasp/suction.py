"""Taking hold with a suction cup: smooth patches as wide as the cup, near the centre of mass."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar

import numpy as np

from topple.planner.grasp.cells import Region, swept
from topple.planner.grasp.frames import spread
from topple.planner.grasp.grasp import Grasp
from topple.planner.grasp.load import HOLD, chance_to_hold, in_words, weight_of
from topple.planner.grasp.shape import Shape, Sought, body_of
from topple.planner.grasp.surroundings import ITSELF
from topple.planner.grasp.tolerances import (
    AT_LIP,
    GRASP_TOLERANCES,
    LEAST_INSIDE,
    RING,
    SUCTION_BRUSH,
    SUCTION_TIGHT,
)
from topple.robots.arm.cup import SuctionCup, lip_plane, vacuum_load
from topple.robots.arm.gripper import SUCTION
from topple.robots.collision.prisms import Prism
from topple.topology.base.arrays import BoolArray, FloatArray, IntArray
from topple.topology.base.errors import InvalidInput

if TYPE_CHECKING:
    from topple.robots.arm.arm import Arm

SECTORS = 8  # the lip is judged in eight parts: a gap in any of them leaks
SPARSE = "too few points for a cup's lip"
STEEP = "too steep for the cup"
UNEVEN = "no smooth patch as wide as the cup's lip"


_Patch = tuple[FloatArray, float, dict[str, float]]
"""Pose of the tool (4, 4), largest unevenness under the lip [m], parts of the score, each in 0..1."""

TURNS: tuple[FloatArray, ...] = tuple(
    np.array([[np.cos(a), -np.sin(a), 0, 0], [np.sin(a), np.cos(a), 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]])
    for a in (0.0, np.pi / 4, np.pi / 2, -np.pi / 4)
)
"""Turns (4, 4) of the hand about the cup's axis; the arm tries each with half a turn more as well."""


@dataclass(frozen=True, eq=False)
class CupShape(Shape):
    """A suction cup and what is around it, in its tool frame (z approach, origin at the lip's centre).

    Attributes:
        body: Prisms of the hand with the cup out.
        cup: The cup.
        beside: Links of the fingers that stand open beside it.
    """

    cup: SuctionCup
    beside: tuple[str, ...] = ()

    kind: ClassVar[str] = SUCTION
    where: ClassVar[str] = "under its cup"
    holder: ClassVar[str] = "the cup holds"

    @property
    def links(self) -> tuple[str, ...]:
        """Links that may be next to what it takes: the cup's, and the fingers that stand open around it.

        The search kept the open hand clear of the object's cloud; the hulls drawn around the cloud bridge its
        hollows, a plate's for one, and would bar it.
        """
        return (*self.tool.links, *self.beside)

    def under(self, points: FloatArray, margin: float) -> BoolArray:
        """Which points (N, 3), in the tool frame [m], are in the cup or the way behind it, or next to it.

        Args:
            points: What the cup does not take: that may bulge into the bellows.
            margin: How close is next to it; up to as far behind the lip is still the patch itself [m].
        """
        return (np.hypot(points[:, 0], points[:, 1]) < self.cup.radius + margin) & (points[:, 2] < -margin)

    def grasps(self, sought: Sought) -> list[Grasp]:
        """Put the cup on smooth patches, spread over what of the object is seen from above."""
        surface, up, found = sought.surface, sought.up, list[Grasp]()
        for pose, residual, parts in self._patches(sought):
            arm = surface.centre - pose[:3, 3]
            lever = float(np.linalg.norm(arm - up * float(arm @ up)))
            tilt = float(np.arccos(np.clip(-pose[:3, 2] @ up, -1.0, 1.0)))
            load = cup_load(lever, weight_of(surface.volume, surface.mass), self.cup, tilt)
            reason = f"seal within {1e3 * residual:.1f} mm; " + ", ".join(
                f"{term} {value:.2f}" for term, value in parts.items()
            )
            if self.score(parts) < sought.tolerances.least_seal:
                sought.dropped.note("the seal would leak or peel off")
                continue
            terms = {**parts, HOLD: float(chance_to_hold(load, surface.mass is not None))}
            score, reason, opening = self.score(terms), reason + in_words(load), self.tool.ready.opening
            for turn in TURNS:
                found.append(Grasp(sought.name, self.kind, pose @ turn, 0.0, opening, score, reason, terms))
        return found

    def _patches(self, sought: Sought, count: int = 40) -> list[_Patch]:
        """The places where it seals and the hand has room, of so many that are tried, best first."""
        surface, cloud, tolerances = sought.surface, sought.cloud, sought.tolerances
        seen = np.arange(len(surface.points)) < surface.seen
        facing = seen & (surface.normals @ sought.up > np.cos(tolerances.seal_tilt + 0.15))
        if not facing.any():
            sought.dropped.note(STEEP)
            return []
        spots, normals = surface.points[facing], surface.normals[facing]
        flat_centre = surface.centre + sought.up * float(np.median((spots - surface.centre) @ sought.up))
        found: list[_Patch] = []
        for index in spread(spots, flat_centre, count):
            near = cloud[np.linalg.norm(cloud - spots[index], axis=1) < 1.4 * self.cup.radius]
            near = near[_this_side(near - spots[index], normals[index], self.cup.lip_depth)]
            patch = _patch(spots[index], near, sought, self)
            if patch is not None:
                found.append(patch)
        return sorted(found, key=lambda patch: -self.score(patch[2]))

    def score(self, terms: Mapping[str, float]) -> float:
        """Multiply the terms: a leak or a long lever spoils it alone."""
        ease = (0.5 + 0.5 * terms["upright"]) * (0.8 + 0.2 * terms["clearance"])
        return terms["seal"] * terms["balance"] * ease * terms.get(HOLD, 1.0)

    def max_weight(self, friction: float | None) -> float:
        """Weight [N] that the cup lifts at most."""
        return self.cup.max_force

    def load(
        self, weight: float, centre: FloatArray, down: FloatArray, width: float, own: FloatArray
    ) -> float:
        """How much of what the cup holds a weight takes; see `cup_load`."""
        tilt = float(np.arccos(np.clip(down[2], -1.0, 1.0)))
        return cup_load(float(np.hypot(*centre[:2])), weight, self.cup, tilt)

    def holds(self, count: int) -> Region:
        """Before and behind the lip."""
        bound = np.tile([self.cup.radius, self.cup.radius, AT_LIP], (count, 1))
        return Region(-bound, bound, self.cup.radius)

    def sweeps(self, openings: FloatArray) -> tuple[list[Region], list[Region]]:
        """Regions that hands (P,) with the cup out sweep; the object taken may bulge into the bellows."""
        side = self.cup.radius + GRASP_TOLERANCES.under_clearance
        lip = swept(len(openings), -side, side, -side, side, 0.0)
        return super().sweeps(openings)[0], [Region(lip.lower, lip.upper, side)]


def cup_shape(arm: "Arm") -> CupShape:
    """Measure an arm's suction cup with the hand around it, the cup out.

    Args:
        arm: An arm with a tool named "suction".

    Returns:
        The shape.
    """
    tool, jaw = arm.tools[SUCTION], arm.jaw
    cup = tool.gripper.cup
    if cup is None:
        raise InvalidInput(f"robot {arm.name!r}: its tool 'suction' is no suction cup")
    return CupShape(tool, body_of(arm, tool), cup, () if jaw is None else jaw.links)


def cup_load(lever: float, weight: float, cup: SuctionCup, tilt: float = 0.0) -> float:
    """How much of what a cup holds a weight takes, by the model that lets go in simulation.

    Args:
        lever: Level distance between the cup's axis and the centre of mass [m].
        weight: In [N].
        cup: Its force, radius and friction.
        tilt: Angle between its axis and the vertical [rad]: what hangs aslant shears.

    Returns:
        The share; above 1 the lip opens.
    """
    pull, shear = weight * np.cos(tilt), weight * np.sin(tilt)
    model = {"force": cup.max_force, "radius": cup.radius, "friction": cup.friction}
    return vacuum_load(pull, shear, weight * lever, 0.0, **model)


def _patch(spot: FloatArray, near: FloatArray, sought: Sought, hand: CupShape) -> _Patch | None:
    surface, up, tolerances, dropped = sought.surface, sought.up, sought.tolerances, sought.dropped
    if len(near) < 4 * SECTORS:
        dropped.note(SPARSE)
        return None
    normal, middle = _robust_plane(near, up)
    tilt = float(np.arccos(np.clip(normal @ up, -1.0, 1.0)))
    if tilt > tolerances.seal_tilt:
        dropped.note(STEEP)
        return None
    centre = spot - normal * float((spot - middle) @ normal)
    residual = _lip_residual(near - centre, normal, hand.cup.radius)
    if residual > hand.cup.lip_depth:
        dropped.note(UNEVEN)
        return None
    rotation = _rotation(-normal, up)
    clearance = _room(sought, centre, rotation, hand)
    if clearance is None:
        return None
    arm = surface.centre - centre
    lever = float(np.linalg.norm(arm - normal * float(arm @ normal)))
    terms = {
        "seal": float(np.exp(-0.5 * (residual / tolerances.seal_tolerance) ** 2)),
        "balance": float(1.0 / (1.0 + (lever / hand.cup.radius / 1.5) ** 2)),
        "upright": 1.0 - tilt / tolerances.seal_tilt,
        "clearance": clearance,
    }
    pose = np.eye(4)
    pose[:3, :3], pose[:3, 3] = rotation, centre
    return pose, residual, terms


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


def _room(sought: Sought, centre: FloatArray, rotation: FloatArray, hand: CupShape) -> float | None:
    """How free the way in is, 0..1, or None where the hand meets points."""
    around, tolerances, dropped = sought.around, sought.tolerances, sought.dropped
    foreign, margin = (around.points - centre) @ rotation, tolerances.under_clearance
    met = hand.under(foreign, margin)
    if np.count_nonzero(met) > tolerances.stray_points:
        dropped.no_room("cup", around.met(met))
        return None
    brushed = False
    for points in ((sought.surface.points - centre) @ rotation, foreign):
        met = _inside(points, hand.body, margin, margin)
        if met.any():
            dropped.no_room("hand", around.met(met) if points is foreign else ITSELF)
            return None
        brushed = brushed or bool(_inside(points, hand.body, SUCTION_BRUSH, SUCTION_BRUSH).any())
    return SUCTION_TIGHT if brushed else 1.0


def _inside(points: FloatArray, prisms: tuple[Prism, ...], aside: float, before: float) -> BoolArray:
    """Which points in the tool's frame are in a prism, wider by `aside`, with more than stray points."""
    found = np.zeros(len(points), dtype=bool)
    for prism in prisms:
        lower, upper = np.array([prism.x[0], prism.y[0]]), np.array([prism.x[1], prism.y[1]])
        inside = np.all((points[:, :2] > lower - aside) & (points[:, :2] < upper + aside), axis=1)
        inside &= points[:, 2] < prism.front + before
        if np.count_nonzero(inside) > GRASP_TOLERANCES.stray_points:
            found |= inside
    return found
