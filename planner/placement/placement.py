"""Where to put things down: free, reachable places on tables, the object resting as it would by itself."""

from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace

import numpy as np

from topple.planner.placement.free_space import FreeSpace, free_spaces
from topple.planner.placement.resting import (
    PLACEMENT_TOLERANCES,
    Rest,
    about,
    resting_poses,
)
from topple.planner.placement.tolerances import KEPT, SPARE_SHARE, YAWS
from topple.planner.tolerances import ALIKE
from topple.topology.base.arrays import BoolArray, FloatArray, freeze
from topple.topology.base.errors import UnknownObject
from topple.topology.base.values import Word
from topple.topology.geometry.axes import level_axes
from topple.topology.geometry.thin import voxel_means
from topple.topology.scene.scene import Scene
from topple.topology.situation.situation import Situation


@dataclass(frozen=True, eq=False)
class Placement:
    """A place for an object.

    Attributes:
        pose_before_to_after: (4, 4) rigid transform in the world that moves the object from where it is now.
        score: 0..1, higher is better.
        rest: How it stands there, in words.
        drop: How far it falls when it is let go [m].
        into: What it is put on or into, whose inferred body it may enter: its seen surface was kept clear of.
        how: On or within that, or where else it goes (`topple.planner.placement.away`); None on a table.
        rolls: Whether it could roll away from there.
        falls: Whether it is known not to stay there, and is to be let go all the same.
    """

    pose_before_to_after: FloatArray
    score: float
    rest: str = ""
    drop: float = 0.0
    into: str | None = None
    how: Word | None = None
    rolls: bool = False
    falls: bool = False

    def __post_init__(self) -> None:
        object.__setattr__(self, "pose_before_to_after", freeze(self.pose_before_to_after))

    def pose_at_rest(self, up: FloatArray) -> FloatArray:
        """(4, 4) rigid transform in the world to where it lies once it fell by `drop`; up (3,) is a unit."""
        pose = self.pose_before_to_after.copy()
        pose[:3, 3] -= self.drop * up
        return pose

    def higher(self, by: float, up: FloatArray) -> "Placement":
        """The same place, let go from further up by some metres; up (3,) is a unit."""
        pose = self.pose_before_to_after.copy()
        pose[:3, 3] += by * up
        drop = self.drop + by
        words = f"{self.rest}, let go {1e3 * drop:.0f} mm above"
        return replace(self, pose_before_to_after=pose, drop=drop, rest=words)

    def same(self, other: "Placement") -> bool:
        """Whether another place is this one, to the last digits."""
        return np.allclose(self.pose_before_to_after, other.pose_before_to_after, atol=ALIKE)

    def tilt(self, up: FloatArray) -> float:
        """Angle by which it is tilted against up (3,), a unit vector, from how it stands now [rad]."""
        cosine = float(up @ self.pose_before_to_after[:3, :3] @ up)
        return float(np.arccos(np.clip(cosine, -1.0, 1.0)))


def placements(
    name: str,
    scene: Scene | Situation,
    *,
    pose_base_to_world: FloatArray | None = None,
    avoid: Sequence[FloatArray] = (),
    remaining: Collection[str] = (),
    spaces: Sequence[FreeSpace] | None = None,
    limit: int = 24,
    scale: float = 1.0,
) -> list[Placement]:
    """Find free places on tops for an object, off the ways out of what remains while there are any.

    Args:
        name: The object.
        scene: The scene, with `up` and a fixed body that has a top, or the situation it was read as.
        pose_base_to_world: (4, 4) the arm's base: places within its reach and off its foot.
        avoid: (N, 3) points each: places to keep free besides.
        remaining: Objects that are still to be taken, or put something on or into.
        spaces: What is free, where that is known; else that of all tops is mapped.
        limit: At most so many, spread over the tops; the last of them in other attitudes.
        scale: Of the arm, see `topple.robots.arm.home.scale_of`: places are as much nearer to its base.

    Returns:
        Placements, best first; empty where there is no room. Deterministic.

    Raises:
        UnknownObject: The scene has no such object.
    """
    situation = Situation.of(scene)
    scene, up = situation.scene, situation.up
    if name not in scene.clouds:
        raise UnknownObject(name, scene.names)
    cloud, parts = scene.clouds[name], situation.solids[name]
    rests = resting_poses(cloud, parts, up, scene.centres.get(name))
    tall = max(float(np.ptp(cloud @ (rest.rotation.T @ up))) for rest in rests)
    if spaces is None:
        spaces = free_spaces(situation, leave_out={name}, avoid=avoid, remaining=remaining, tall=tall)
    at = pose_base_to_world, scale
    found = [
        [spot for space in spaces for spot in _at_rest(cloud, parts, rest, space, up, *at)] for rest in rests
    ]
    best = _spread_out([spot for spots in found for spot in spots], limit)
    worse = [spots for spots in found if not any(spot in best for spot in spots)]
    spare = [spot for spots in worse for spot in _spread_out(spots, limit // SPARE_SHARE)]
    chosen = [*best[: max(limit - len(spare), limit // 2)], *spare][:limit]
    return [spot.placement(cloud.mean(axis=0)) for spot in chosen]


@dataclass(frozen=True, eq=False)
class _Spot:
    """Where the middle of an object may come to lie (3,) [m], turned (3, 3) as in a resting pose."""

    middle: FloatArray
    rotation: FloatArray
    rest: Rest
    score: float
    room: float

    def placement(self, before: FloatArray) -> Placement:
        """The placement, from where its middle is before (3,) [m]."""
        pose = np.eye(4)
        pose[:3, :3], pose[:3, 3] = self.rotation, self.middle - self.rotation @ before
        words = f"turned {np.degrees(self.rest.turn):.0f} deg onto a face, {1e3 * self.room:.0f} mm free"
        return Placement(pose, self.score, words, PLACEMENT_TOLERANCES.drop, rolls=self.rest.rolls)


def _at_rest(
    cloud: FloatArray,
    parts: Sequence[FloatArray],
    rest: Rest,
    space: FreeSpace,
    up: FloatArray,
    pose_base_to_world: FloatArray | None,
    scale: float,
) -> list[_Spot]:
    """Every free place and heading on one top for an object in one resting pose."""
    axes = np.stack(level_axes(up))
    base = None if pose_base_to_world is None else axes @ pose_base_to_world[:3, 3]
    middle = cloud.mean(axis=0)
    body = np.vstack([voxel_means(cloud, 0.008, ahead=0.0), *parts])
    cells = 2 * np.argwhere(space.distance[::2, ::2] > PLACEMENT_TOLERANCES.gap)
    places = space.middles(cells)
    if pose_base_to_world is not None:
        rise = space.height - float(pose_base_to_world[:3, 3] @ space.normal)
        within = reachable(places, rise, axes @ pose_base_to_world[:3, 3], scale)
        cells, places = cells[within], places[within]
    found: list[_Spot] = []
    for k in range(YAWS):
        rotation = about(up, 2.0 * np.pi * k / YAWS) @ rest.rotation
        turned = (body - middle) @ rotation.T
        along, aside = np.round(axes @ turned.T / space.cell).astype(np.int64)
        width = int(np.abs(aside).max()) + 1
        each = np.unique(2 * width * along + aside + width)
        covered = np.stack([each // (2 * width), each % (2 * width) - width], axis=1)
        room, bars = space.under(cells, covered)
        lift = space.height + PLACEMENT_TOLERANCES.drop - float((turned @ space.normal).min())
        scores = _scores(places, room, rest, axes @ middle, base, k / YAWS, scale)
        scores[bars] = -1.0
        best = np.argsort(-scores, kind="stable")[:KEPT]
        best = best[scores[best] > 0.0]
        targets = places[best] @ axes
        targets += np.outer((lift - targets @ space.normal) / float(up @ space.normal), up)
        found += [
            _Spot(target, rotation, rest, *given)
            for target, *given in zip(targets, scores[best].tolist(), room[best].tolist(), strict=True)
        ]
    return found


def reachable(places: FloatArray, rise: float, base: FloatArray, scale: float) -> BoolArray:
    """Which places an arm works at freely.

    Args:
        places: (P, 2) level coordinates [m].
        rise: Height of their top over the arm's base [m].
        base: (2,) level coordinates of the base [m].
        scale: Of the arm.
    """
    level, (near, far) = np.linalg.norm(places - base, axis=1), PLACEMENT_TOLERANCES.reach
    return (level > scale * near) & (np.hypot(level, rise) < scale * far)


def _scores(
    places: FloatArray,
    room: FloatArray,
    rest: Rest,
    before: FloatArray,
    base: FloatArray | None,
    turn: float,
    scale: float,
) -> FloatArray:
    """Score (N,) of places: room around, a short way, an easy reach, little turning, a steady stand."""
    way = 1.0 / (1.0 + np.linalg.norm(places - before, axis=1) / 0.5)
    easy = np.ones(len(places))
    if base is not None:
        comfortable = 0.5 * (scale * PLACEMENT_TOLERANCES.reach[0] + scale * PLACEMENT_TOLERANCES.reach[1])
        far = np.linalg.norm(places - base, axis=1)
        easy = 1.0 - np.minimum(1.0, np.abs(far - comfortable) / comfortable)
    stand = 1.0 - rest.turn / np.pi + min(1.0, rest.steadiness / PLACEMENT_TOLERANCES.steady)
    heading = 1.0 - min(turn, 1.0 - turn)
    score = 0.3 * np.minimum(1.0, room / PLACEMENT_TOLERANCES.good_gap) + 0.15 * way + 0.15 * easy
    return np.where(room > PLACEMENT_TOLERANCES.gap, score + 0.1 * heading + 0.15 * stand, -1.0)


def _spread_out(found: list[_Spot], limit: int) -> list[_Spot]:
    """Steady ones first, best first: at most three headings at a place, places 6 cm apart."""
    kept: list[_Spot] = []
    spots = np.empty((0, 3))
    for spot in sorted(found, key=lambda spot: (spot.rest.rolls, -spot.score)):
        apart = np.sqrt(((spots - spot.middle) ** 2).sum(axis=1))
        same = np.count_nonzero(apart < 0.005)
        if np.count_nonzero(apart < 0.06) == same and same < 3:
            kept.append(spot)
            spots = np.vstack([spots, spot.middle])
        if len(kept) >= limit:
            break
    return kept
