"""From where to look next: the place that shows most of what no camera saw and the order depends on."""

from collections.abc import Collection, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from topple.planner.decide.arrange import Order
from topple.planner.decide.words import side_of
from topple.planner.planning.order import order as order_of
from topple.planner.planning.tolerances import (
    AZIMUTHS,
    CELL_ANGLE,
    DEPTH_MARGIN,
    ELEVATIONS,
    FIELD_OF_VIEW,
    LEAST_WORTH,
    MEETING_GAP,
    STANDOFF,
    UNSEEN,
)
from topple.robots.poses import looking_at
from topple.topology.base.arguments import checked_arguments
from topple.topology.base.arrays import BoolArray, FloatArray, IntArray, bounds
from topple.topology.base.checks import as_points
from topple.topology.base.values import ByValue
from topple.topology.io.load import AnyScene
from topple.topology.kernels.neighbours import PointTree
from topple.topology.situation.situation import Situation


@dataclass(frozen=True, eq=False)
class Shown(ByValue):
    """What a view would tell of two objects.

    Attributes:
        a: One of them.
        b: The other one.
        doubt: How doubtful it is by now which of them has to go first, 0..0.5 (the variance of both answers).
        hidden: Share, 0..1, of the places where they may meet that no camera saw.
        shown: Share of those that the view shows.
    """

    a: str
    b: str
    doubt: float
    hidden: float
    shown: float


@dataclass(frozen=True, eq=False)
class View(ByValue):
    """A place to look from.

    Attributes:
        eye: (3,) of the camera in the scene's frame [m].
        target: (3,) of what shall be in the middle of the picture [m].
        pose_camera_to_scene: (4, 4); x right, y down, z forward.
        worth: How much of all doubt about hidden places the view shows, 0..1.
        shows: What it tells, the most telling first.
    """

    eye: FloatArray
    target: FloatArray
    pose_camera_to_scene: FloatArray
    worth: float
    shows: tuple[Shown, ...]

    def to_json(self) -> dict[str, Any]:
        """As JSON data: part of what `topple order --next-view --json` prints."""
        return {
            "eye": self.eye.round(4).tolist(),
            "target": self.target.round(4).tolist(),
            "pose_camera_to_scene": self.pose_camera_to_scene.round(6).tolist(),
            "worth": round(self.worth, 3),
            "shows": [
                {"a": one.a, "b": one.b, "doubt": round(one.doubt, 3), "hidden": round(one.hidden, 3),
                 "shown": round(one.shown, 3)}
                for one in self.shows
            ],
        }  # fmt: skip


@checked_arguments
def next_view(
    scene: AnyScene | Situation,
    targets: Collection[str] | str | None = None,
    *,
    viewpoints: FloatArray | None = None,
    found: Order | None = None,
) -> View | None:
    """The view that shows most of what is hidden and matters; see `next_views`.

    Args:
        scene: A scene that knows where up is and from where it was seen, or the situation it was read as.
        targets: Names to free; none clears everything.
        viewpoints: (k, 3) places to choose from, in the scene's frame [m]; all around above where None.
        found: The order of the scene, where it is known.

    Returns:
        The best view; None where nothing that matters is hidden, or no place shows any of it.

    Raises:
        InvalidInput: As `order`, or the viewpoints are no points.

    Examples:
        >>> next_view(scene, "book") is None  # no camera is known
        True
    """
    views = next_views(scene, targets, viewpoints=viewpoints, found=found)
    return views[0] if views else None


def with_next_view(
    asked: Situation, targets: Collection[str] | str | None, found: Order | None = None
) -> dict[str, Any]:
    """The document of an order with the place to look from next, and its side as the first camera has it.

    Args:
        asked: What the order is of.
        targets: Names to free; none clears everything.
        found: The order, where it is known.
    """
    found = order_of(asked, targets, check_gravity=False) if found is None else found
    view, scene = next_view(asked, targets, found=found), asked.scene
    if view is None:
        return {**found.to_json(), "next_view": None}
    seen = scene.images[0].pose_camera_to_world[:3, 0] if scene.images else None
    right = np.cross(view.target - scene.viewpoints[0], asked.up) if seen is None else seen
    told = {**view.to_json(), "from": side_of(view.eye - view.target, right, asked.up)}
    return {**found.to_json(), "next_view": told}


def next_views(
    scene: AnyScene | Situation,
    targets: Collection[str] | str | None = None,
    *,
    viewpoints: FloatArray | None = None,
    found: Order | None = None,
) -> tuple[View, ...]:
    """Views by what they show of the places on which the order hangs and that no camera saw, best first.

    Two objects whose order is doubtful may meet where their completed bodies are close. Of these places,
    those that no camera saw are looked at along rays that the completed bodies stop. A view is worth the
    doubt that it shows: the variance p (1 - p) of each dependency's chance, spread over its hidden places.

    Args:
        scene: As for `next_view`.
        targets: As for `next_view`.
        viewpoints: As for `next_view`.
        found: As for `next_view`.

    Returns:
        The views that are worth anything.

    Raises:
        InvalidInput: As `order`, or the viewpoints are no points.
    """
    situation = Situation.of(scene)
    if not len(situation.scene.viewpoints):
        return ()  # all surfaces are whole where nobody says from where they were seen
    found = order_of(situation, targets, check_gravity=False) if found is None else found
    asked = _questions(situation, found)
    if not asked:
        return ()
    rotation = situation.statics.upright.rotation
    bodies = np.concatenate(list(situation.surfaces.values()))
    places = np.concatenate([one.places for one in asked])
    lower, upper = bounds(places)
    middle = (lower + upper) / 2.0
    if viewpoints is None:
        tried = _around(middle, float(np.linalg.norm(upper - lower)) / 2.0)
    else:
        tried = as_points(viewpoints, "viewpoints") @ rotation.T
    views: list[View] = []
    total, ends = sum(one.weight for one in asked), np.cumsum([len(one.places) for one in asked])[:-1]
    for eye in tried:
        shares = [float(part.mean()) for part in np.split(_visible(places, bodies, eye, middle), ends)]
        worth = sum(one.weight * share for one, share in zip(asked, shares, strict=True)) / total
        if worth < LEAST_WORTH:
            continue
        shows = [
            Shown(one.a, one.b, one.doubt, one.hidden, share)
            for one, share in zip(asked, shares, strict=True)
            if share > 0.0
        ]
        shows.sort(key=lambda one: -one.doubt * one.hidden * one.shown)
        pose = looking_at(eye, middle)
        world = np.eye(4)
        world[:3, :3], world[:3, 3] = rotation.T @ pose[:3, :3], rotation.T @ pose[:3, 3]
        views.append(View(eye @ rotation, middle @ rotation, world, worth, tuple(shows)))
    return tuple(sorted(views, key=lambda view: -round(view.worth, 6)))


@dataclass(frozen=True, eq=False)
class _Question:
    """Two objects whose order is doubtful, and the (N, 3) upright places [m] that nobody saw."""

    a: str
    b: str
    doubt: float
    hidden: float
    places: FloatArray

    @property
    def weight(self) -> float:
        return self.doubt * self.hidden


def _questions(situation: Situation, found: Order) -> list[_Question]:
    """The pairs on which the order hangs and that may meet where no camera looked."""
    concerned = set(found.order)
    doubts: dict[tuple[str, str], float] = {}
    for (first, then), chance in found.chances.items():
        if then in concerned:
            pair = (min(first, then), max(first, then))
            doubts[pair] = doubts.get(pair, 0.0) + chance * (1.0 - chance)
    surfaces, seen = situation.surfaces, situation.statics.upright.clouds
    trees = {name: PointTree(surfaces[name]) for pair in doubts for name in pair}
    views = {name: PointTree(seen[name]) for name in trees}
    asked: list[_Question] = []
    for (a, b), doubt in sorted(doubts.items()):
        near = _meeting_places(a, b, surfaces, trees)
        if near is None:
            continue
        known = np.min([views[name].query(near, distance_upper_bound=UNSEEN)[0] for name in (a, b)], axis=0)
        unseen = near[~(known < UNSEEN)]
        if len(unseen):
            asked.append(_Question(a, b, doubt, len(unseen) / len(near), unseen))
    return asked


def _meeting_places(
    a: str, b: str, surfaces: Mapping[str, FloatArray], trees: Mapping[str, PointTree]
) -> FloatArray | None:
    """(N, 3) places of two surfaces where they may meet; None where they are nowhere close."""
    parts: list[FloatArray] = []
    for one, other in ((a, b), (b, a)):
        gaps = trees[other].query(surfaces[one], distance_upper_bound=MEETING_GAP)[0]
        parts.append(surfaces[one][gaps < MEETING_GAP])
    places = np.concatenate(parts)
    return places if len(places) else None


def _around(middle: FloatArray, radius: float) -> FloatArray:
    """(k, 3) places around and above what lies about a middle, from where all of it is in the picture."""
    far = max(STANDOFF, radius / np.sin(FIELD_OF_VIEW / 2.0))
    turn = np.arange(AZIMUTHS) * 2.0 * np.pi / AZIMUTHS
    eyes = [
        middle + far * np.array([np.cos(up) * np.cos(one), np.cos(up) * np.sin(one), np.sin(up)])
        for up in ELEVATIONS
        for one in turn
    ]
    return np.array([*eyes, middle + np.array([0.0, 0.0, far])])


def _visible(places: FloatArray, bodies: FloatArray, eye: FloatArray, target: FloatArray) -> BoolArray:
    """(N,) whether nothing of the bodies (M, 3) is before a place as seen from an eye."""
    axes = looking_at(eye, target)[:3, :3]

    def pixels(points: FloatArray) -> tuple[IntArray, FloatArray]:
        local = (points - eye) @ axes
        angle = np.arctan2(local[:, :2], np.maximum(local[:, 2:], 1e-6))
        return np.floor(angle / CELL_ANGLE).astype(np.int64), np.linalg.norm(local, axis=1)

    (cells, far), (asked, way) = pixels(bodies), pixels(places)
    lower = np.minimum(cells.min(axis=0), asked.min(axis=0))
    size = np.maximum(cells.max(axis=0), asked.max(axis=0)) - lower + 1
    nearest = np.full(int(size[0] * size[1]), np.inf)
    np.minimum.at(nearest, (cells[:, 0] - lower[0]) * size[1] + cells[:, 1] - lower[1], far)
    before = nearest[(asked[:, 0] - lower[0]) * size[1] + asked[:, 1] - lower[1]]
    return np.asarray(way <= before + DEPTH_MARGIN)
