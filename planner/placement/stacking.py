"""Putting a thing on or into another one: where it would come to lie on what is there."""

from dataclasses import dataclass

import numpy as np
from scipy.ndimage import binary_closing, distance_transform_edt

from topple.planner.decide.goal import PlaceRelation
from topple.planner.placement.placement import Placement
from topple.planner.placement.resting import (
    PLACEMENT_TOLERANCES,
    Rest,
    about,
    resting_poses,
)
from topple.planner.placement.tolerances import CELL, CONTACT, GAPS, HEADINGS, INSET, SPOT, YAWS
from topple.topology.base.arrays import FloatArray, IntArray
from topple.topology.base.errors import UnknownObject
from topple.topology.bodies.solids import centre_in, hull_vertices
from topple.topology.bodies.tops import tops_of
from topple.topology.geometry.axes import level_axes
from topple.topology.geometry.samples import sample
from topple.topology.geometry.sides import inset
from topple.topology.geometry.thin import voxel_means
from topple.topology.scene.scene import Scene
from topple.topology.situation.situation import Situation

DROPS = {
    PlaceRelation.WITHIN: (0.005, 0.02, 0.04, 0.08)
}  # into a container also from higher up: hands need room beside [m]


@dataclass(frozen=True, eq=False)
class Heights:
    """The upper surface of what is below: one height for each cell, -inf where nothing is known.

    Attributes:
        origin: (2,) level coordinates of the grid's corner [m].
        top: (I, J) heights along up [m].
        owner: (I, J) index of the object that is highest there, -1 for none.
    """

    origin: FloatArray
    top: FloatArray
    owner: IntArray

    def look_up(self, places: FloatArray) -> tuple[FloatArray, IntArray]:
        """Heights and owners at (N, 2) level coordinates; -inf and -1 outside."""
        index = np.floor((places - self.origin) / CELL).astype(np.int64)
        inside = np.all((index >= 0) & (index < np.array(self.top.shape)), axis=1)
        index = np.clip(index, 0, np.array(self.top.shape) - 1)
        top = np.where(inside, self.top[index[:, 0], index[:, 1]], -np.inf)
        return top, np.where(inside, self.owner[index[:, 0], index[:, 1]], -1)


def placements_on(
    name: str,
    scene: Scene | Situation,
    where: str,
    how: PlaceRelation | str = PlaceRelation.ON,
    *,
    limit: int = 24,
) -> list[Placement]:
    """Find how an object can lie on or within another one.

    The object is lowered, in each of its resting attitudes and headings, over a grid of places until it
    meets what is below; on: its centre of mass has to stand over the carrying face; within: all of it has
    to be inside the outline of the container, as deep as possible.

    Args:
        name: The object.
        scene: The scene, or the situation it was read as; what else lies on or in `where` stays there.
        where: What is to carry it.
        how: On or within.
        limit: At most so many.

    Returns:
        Placements, best first; empty where it would not stay. Deterministic.

    Raises:
        UnknownObject: The scene has no such object.
    """
    situation, how = Situation.of(scene), PlaceRelation(how)
    scene, up, solids = situation.scene, situation.up, situation.solids
    for known in (name, where):
        if known not in scene.clouds:
            raise UnknownObject(known, scene.names)
    axes = np.stack(level_axes(up))
    ceiling = float((scene.clouds[where] @ up).max() + np.ptp(scene.clouds[name], axis=0).max())
    heights = heights_of(scene, up, leave_out=name, ceiling=ceiling + PLACEMENT_TOLERANCES.headroom)
    outline = hull_vertices(scene.clouds[where] @ axes.T)
    low, high = outline.min(axis=0), outline.max(axis=0)
    middle, steps = (low + high) / 2.0, np.linspace(-0.3, 0.3, 7)
    offsets = np.stack(np.meshgrid(steps, steps), axis=-1).reshape(-1, 2) * (high - low)
    target = list(scene.names).index(where)
    body = np.vstack([voxel_means(scene.clouds[name], CELL, ahead=0.0), sample(solids[name], CELL)])
    centre = centre_in(scene, name, solids[name])
    found: list[Placement] = []
    for rest in resting_poses(scene.clouds[name], solids[name], up, scene.centres.get(name)):
        for k in range(YAWS):
            rotation = about(up, 2.0 * np.pi * k / YAWS) @ rest.rotation
            turned = (body - centre) @ rotation.T
            level, height = underside(turned @ axes.T, turned @ up)
            landings = _landings(level, height, middle + offsets, heights, target)
            for offset, landing in zip(offsets, landings, strict=True):
                if landing is None:
                    continue
                score = _score(landing, how, rest, offset, outline - middle, level)
                for drop in () if score is None else DROPS.get(how, (PLACEMENT_TOLERANCES.drop,)):
                    after = axes.T @ (middle + offset) + up * (landing.height + drop)
                    pose = np.eye(4)
                    pose[:3, :3], pose[:3, 3] = rotation, after - rotation @ centre
                    turn = np.degrees(rest.turn)
                    words = f"{how} {where}, turned {turn:.0f} deg onto a face"
                    value = (score or 0.0) - 0.01 * min(k, YAWS - k) - 3.0 * drop
                    found.append(Placement(pose, value, words, drop, where, how))
    return _vary_headings(found, centre, limit)


def _vary_headings(found: list[Placement], centre: FloatArray, limit: int) -> list[Placement]:
    """Best first, a few headings at a spot each: a hand that finds no room at one may find it at another."""
    kept: list[Placement] = []
    spots: list[FloatArray] = []
    for placement in sorted(found, key=lambda placement: -placement.score):
        spot = placement.pose_before_to_after[:3, :3] @ centre + placement.pose_before_to_after[:3, 3]
        if sum(bool(np.linalg.norm(other - spot) < SPOT) for other in spots) < HEADINGS:
            kept.append(placement)
            spots.append(spot)
        if len(kept) >= limit:
            break
    return kept


def heights_of(scene: Scene, up: FloatArray, leave_out: str, ceiling: float = np.inf) -> Heights:
    """Map the upper surface of everything but one object.

    Args:
        scene: The scene.
        up: (3,) unit vector.
        leave_out: The object that does not count.
        ceiling: Height above which nothing that is fixed counts: boards of a shelf with room below [m].

    Returns:
        The map; tops count as planes, gaps narrower than 3 cells are closed.
    """
    axes = np.stack(level_axes(up))
    everything = np.vstack([cloud for name, cloud in scene.clouds.items() if name != leave_out]) @ axes.T
    origin = everything.min(axis=0)
    shape = np.floor((everything.max(axis=0) - origin) / CELL).astype(int) + 1
    top, owner = np.full(tuple(shape), -np.inf), np.full(tuple(shape), -1, dtype=np.int64)
    for number, (name, cloud) in enumerate(scene.clouds.items()):
        if name == leave_out:
            continue
        level = cloud @ up
        if name in scene.fixed:
            found = tops_of(cloud, up)
            cloud = np.vstack([*(each.points for each in found.tops), found.rest])
            level = np.concatenate(
                [*(np.full(len(each.points), each.height) for each in found.tops), found.rest @ up]
            )
            cloud, level = cloud[level < ceiling], level[level < ceiling]
        index = np.floor((cloud @ axes.T - origin) / CELL).astype(np.int64)
        own = np.full(tuple(shape), -np.inf)
        np.maximum.at(own, (index[:, 0], index[:, 1]), level)
        own = _close_gaps(own)
        higher = own > top
        top[higher], owner[higher] = own[higher], number
    return Heights(origin, top, owner)


def _close_gaps(own: FloatArray) -> FloatArray:
    """Fill empty cells between cells of one object with their neighbours' mean height."""
    known = np.isfinite(own)
    wide, inner = GAPS + 1, slice(GAPS + 1, -GAPS - 1)
    gaps = binary_closing(np.pad(known, wide), iterations=GAPS)[inner, inner] & ~known
    if gaps.any():
        nearest = distance_transform_edt(~known, return_distances=False, return_indices=True)
        assert nearest is not None
        own = np.where(gaps, own[nearest[0], nearest[1]], own)
    return own


@dataclass(frozen=True, eq=False)
class _Landing:
    """Where a turned object, its centre over a place, comes to lie."""

    height: float  # of its centre along up
    carried: FloatArray  # (K, 2) level offsets from the centre of the points that carry it
    on_target: float  # share of them that lie on the target
    depth: float  # of its lowest point below the target's highest


def underside(level: FloatArray, height: FloatArray) -> tuple[FloatArray, FloatArray]:
    """The lowest of an object's points in each cell of the grid.

    Args:
        level: (N, 2) level offsets of points from its centre [m].
        height: (N,) their heights over it [m].

    Returns:
        (M, 2) level offsets and (M,) heights.
    """
    cells, index = np.unique(np.round(level / CELL), axis=0, return_inverse=True)
    lowest = np.full(len(cells), np.inf)
    np.minimum.at(lowest, index.reshape(-1), height)
    return cells * CELL, lowest


def _landings(
    level: FloatArray, height: FloatArray, places: FloatArray, heights: Heights, target: int
) -> list[_Landing | None]:
    """Where an object lowered over each of (N, 2) places comes to lie; None where nothing is below."""
    top, owner = heights.look_up((places[:, None, :] + level[None, :, :]).reshape(-1, 2))
    top, owner = top.reshape(len(places), -1), owner.reshape(len(places), -1)
    highest = float(heights.top[heights.owner == target].max(initial=-np.inf))
    found: list[_Landing | None] = []
    for gap, owners in zip(height - top, owner, strict=True):
        least = float(gap.min())
        if not np.isfinite(least):
            found.append(None)
            continue
        touching = gap < least + CONTACT
        on_target = float(np.mean(owners[touching] == target))
        depth = highest - (float(height.min()) - least)
        found.append(_Landing(-least, level[touching], on_target, depth))
    return found


def _score(
    landing: _Landing,
    how: PlaceRelation,
    rest: Rest,
    offset: FloatArray,
    outline: FloatArray,
    level: FloatArray,
) -> float | None:
    """0..1, or None where it would not stay.

    Args:
        landing: Where it comes to lie.
        how: On or within.
        rest: Its attitude.
        offset: (2,) from the target's middle.
        outline: (K, 2) level points of the target around that middle.
        level: (N, 2) level points of the object around its centre.
    """
    half = float(np.ptp(outline, axis=0).min()) / 2.0
    central = 1.0 - min(1.0, float(np.linalg.norm(offset)) / half)
    if how is PlaceRelation.WITHIN:
        inside = inset(outline, level + offset).min()
        if inside < 0.0 or landing.depth <= 0.0:
            return None
        return 0.5 * min(1.0, landing.depth / 0.03) + 0.3 * central + 0.2 * (1.0 - rest.turn / np.pi)
    width = float(np.ptp(level, axis=0).min()) / 2.0
    steady = float(inset(landing.carried, np.zeros((1, 2)))[0]) / max(width, 1e-6)
    if steady < INSET or landing.on_target < 0.5:
        return None
    return 0.4 * min(1.0, steady) + 0.4 * central + 0.2 * (1.0 - rest.turn / np.pi)


def over(situation: Situation, upper: str, lower: str) -> bool:
    """Whether the middle of what leans on an object is over it: it is then on it, not at its side.

    Args:
        situation: Where they are.
        upper: What leans.
        lower: On what.
    """
    axes, clouds = np.stack(level_axes(situation.up)), situation.scene.clouds
    middle, outline = clouds[upper].mean(axis=0) @ axes.T, clouds[lower] @ axes.T
    return inset(outline, middle[None])[0] > 0.0
