"""The scene as gravity sees it: turned so that up is +z, cut to the objects, thinned to one spacing."""

from collections.abc import Collection, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from topple.topology.base.arrays import (
    FloatArray,
    bounds,
    freeze,
    median_of,
    middle_of,
    round_off,
    within_corners,
)
from topple.topology.base.errors import InvalidInput
from topple.topology.base.remembered import remember
from topple.topology.base.tolerances import KEPT_AROUND, VOXEL
from topple.topology.base.values import FrozenDict
from topple.topology.bodies.tolerances import KEPT_BODIES, KEPT_FRAMES, SUNK
from topple.topology.bodies.tops import Tops, tops_of
from topple.topology.geometry.axes import level_axes
from topple.topology.geometry.outline import least_rectangle
from topple.topology.geometry.thin import voxel_means
from topple.topology.scene.scene import Scene

_Box = tuple[FloatArray, FloatArray]
"""Least and greatest corner, (3,) each [m]."""


@dataclass(frozen=True, eq=False)
class Upright:
    """Clouds in a frame whose z axis is up, and nothing in them that statics does not need.

    Attributes:
        rotation: (3, 3) rows are the frame's axes in the scene's frame, so `p @ rotation.T` turns a
            scene point upright and `q @ rotation` turns it back.
        clouds: name -> (N, 3) points [m], one per voxel of `VOXEL`, the mean of what lay in it.
        fixed: Names that never move.
        viewpoints: (k, 3) camera centres, or None where the clouds are not said to be partial.
        floor: Height [m] of the surface everything stands on: of several tops the lowest one in use.
        tops: Fixed name -> (N, 3) points of each of its tops [m], thinned as the cloud is.
        rest: Fixed name -> (M, 3) points of it that lie on no top [m].
        friction: name -> coefficient of its surface, where it has been tried.
        whole: Names of what is a known model, of which nothing is hidden.
        centres: name -> (3,) centre of mass [m], where it is known.
    """

    rotation: FloatArray
    clouds: Mapping[str, FloatArray]
    fixed: frozenset[str]
    viewpoints: FloatArray | None
    floor: float
    tops: Mapping[str, tuple[FloatArray, ...]]
    rest: Mapping[str, FloatArray]
    friction: Mapping[str, float] = field(default_factory=lambda: FrozenDict({}))
    whole: frozenset[str] = frozenset()
    centres: Mapping[str, FloatArray] = field(default_factory=lambda: FrozenDict({}))

    @property
    def movable(self) -> tuple[str, ...]:
        """Names that can move, in the scene's order."""
        return tuple(name for name in self.clouds if name not in self.fixed)

    def among(self, names: Collection[str]) -> "Upright":
        """The fixed objects, and of the movable ones only those named."""
        kept = {name: cloud for name, cloud in self.clouds.items() if name in self.fixed or name in names}
        return replace(self, clouds=FrozenDict(kept))

    def floor_under(self, points: FloatArray) -> float:
        """Height [m] of the highest top below the middle of an object, (N, 3) points; else the floor."""
        (lower, upper), middle = bounds(points), float(points[:, 2].mean())
        found = (
            height
            for least, most, height in self._levels
            if height < middle and (lower < most)[:2].all() and (upper > least)[:2].all()
        )
        return max(found, default=self.floor)

    @cached_property
    def _levels(self) -> list[tuple[FloatArray, FloatArray, float]]:
        """Least and greatest corner and height [m] of each top: with more objects they grow, too."""
        return [(*bounds(top), median_of(top[:, 2])) for tops in self.tops.values() for top in tops]

    @staticmethod
    def of(scene: Scene, rotation: FloatArray | None = None) -> "Upright":
        """Turn a scene upright.

        Args:
            scene: A scene that knows where up is.
            rotation: The frame of a scene with the same fixed things, where there is one.

        Returns:
            The upright scene. Without a fixed object the floor is the lowest point of any object.

        Raises:
            InvalidInput: The scene has no `up`.
        """
        if scene.up is None:
            cure = "give it with up=[0, 0, 1] (or the array 'up' in the file)"
            if scene.images:  # there 0 0 1 would be the camera's viewing axis
                cure = "name the table by its label, fixed=LABEL: its plane then tells"
            raise InvalidInput(
                f"the scene does not say where up is, so nothing can be said about gravity: {cure}"
            )
        rotation = _axes(scene, scene.up) if rotation is None else rotation
        movable = [name for name in scene.clouds if name not in scene.fixed]
        clouds = {name: _rotate_and_thin(scene.clouds[name], rotation) for name in movable}
        near = _surroundings(list(clouds.values()))
        tops: dict[str, tuple[FloatArray, ...]] = {}
        rest: dict[str, FloatArray] = {}
        for name, cloud in scene.clouds.items():
            if name in scene.fixed:
                turned = _rotate(cloud, rotation)
                cut = _crop(turned, near)
                clouds[name] = cut if len(cut) else voxel_means(turned, 2 * VOXEL)
                tops[name], rest[name] = _taken_apart(turned, clouds[name], near)
        lowest = min((float(clouds[name][:, 2].min()) for name in movable), default=np.inf)
        views = None if len(scene.viewpoints) == 0 else scene.viewpoints @ rotation.T
        return Upright(
            rotation=freeze(rotation),
            clouds=FrozenDict({name: freeze(clouds[name]) for name in scene.clouds}),
            fixed=frozenset(scene.fixed),
            viewpoints=None if views is None else freeze(views),
            floor=_floor(clouds, tops, lowest),
            tops=FrozenDict(tops),
            rest=FrozenDict(rest),
            friction=scene.friction,
            whole=scene.whole,
            centres=FrozenDict({name: round_off(rotation @ at) for name, at in scene.centres.items()}),
        )


def _rotate(cloud: FloatArray, rotation: FloatArray) -> FloatArray:
    """A cloud (N, 3) in a frame whose axes are the rows of a rotation."""
    return round_off(cloud @ rotation.T)


@remember(KEPT_BODIES)
def _rotate_and_thin(cloud: FloatArray, rotation: FloatArray) -> FloatArray:
    """The same with one point a voxel."""
    return freeze(voxel_means(_rotate(cloud, rotation), VOXEL))


def _axes(scene: Scene, up: FloatArray) -> FloatArray:
    """(3, 3) upright axes that turn with the scene: x is along a side of the widest fixed thing.

    Of the four sides it is the one towards the longer tail of its points. What is fixed tells whatever else
    comes into the scene; where nothing is, the widest object does.
    """
    level = np.stack(level_axes(up))
    telling = [scene.clouds[name] for name in scene.names if name in scene.fixed or not scene.fixed]
    if len(telling) > 1:
        telling = [max(telling, key=lambda cloud: float((cloud @ level.T).var(axis=0).sum()))]
    return _along(telling[0] if telling else np.zeros((1, 3)), up)


@remember(KEPT_FRAMES)
def _along(cloud: FloatArray, up: FloatArray) -> FloatArray:
    """(3, 3) upright axes that turn with a cloud (N, 3)."""
    level = np.stack(level_axes(up))
    widest = cloud @ level.T
    side = least_rectangle(widest)
    sides = np.stack([side, [-side[1], side[0]]])
    far = (widest - middle_of(widest)) @ sides.T
    tails = np.einsum("ni->i", far * far * far)
    most = int(np.argmax(np.abs(tails)))
    along = sides[most] * (1.0 if tails[most] >= 0 else -1.0) @ level
    return freeze(np.stack([along, np.cross(up, along), up]))


def _surroundings(clouds: list[FloatArray]) -> list[_Box]:
    """Boxes around clouds near each other, grown by `KEPT_AROUND`; all there is where there is no cloud."""
    if not clouds:
        return [(np.full(3, -np.inf), np.full(3, np.inf))]
    found: list[_Box] = []
    for lower, upper in map(bounds, clouds):
        lower, upper = lower - KEPT_AROUND, upper + KEPT_AROUND
        while meeting := [box for box in found if _meet(box, (lower, upper))]:
            found = [box for box in found if all(box is not other for other in meeting)]
            lower = np.min([lower, *(box[0] for box in meeting)], axis=0)
            upper = np.max([upper, *(box[1] for box in meeting)], axis=0)
        found.append((lower, upper))
    for lower, _ in found:
        lower[2] = -np.inf  # what lies far below still catches what falls
    return found


def _meet(one: _Box, other: _Box) -> bool:
    """Whether two boxes overlap in plan."""
    return bool((one[0] <= other[1])[:2].all() and (other[0] <= one[1])[:2].all())


def _crop(points: FloatArray, boxes: list[_Box]) -> FloatArray:
    """The points inside of boxes, thinned in each by itself: what is far away moves no cell."""
    inside = [points[within_corners(points, lower, upper)] for lower, upper in boxes]
    return np.concatenate([voxel_means(part, 2 * VOXEL) for part in inside])


def _taken_apart(
    points: FloatArray, near: FloatArray, boxes: list[_Box]
) -> tuple[tuple[FloatArray, ...], FloatArray]:
    """The tops of a fixed cloud and its other points, both cut to boxes and thinned as `near` is."""
    found = tops_of(points, np.array([0.0, 0.0, 1.0]))
    if found.flat:
        return (near,), np.empty((0, 3))
    *tops, rest = (_crop(piece, boxes) for piece in _pieces(found))
    kept = tuple(freeze(top) for top in tops if len(top))
    return kept, freeze(rest) if kept else near


def _pieces(found: Tops) -> list[FloatArray]:
    return [*(top.points for top in found.tops), found.rest]


def _floor(
    clouds: Mapping[str, FloatArray], tops: Mapping[str, tuple[FloatArray, ...]], lowest: float
) -> float:
    """Height of the largest fixed cloud's highest top that no object reaches below.

    The median of a fixed cloud without tops; the lowest point of all where nothing is fixed.
    """
    if not tops:
        return float(min((c[:, 2].min() for c in clouds.values()), default=0.0))
    name = max(tops, key=lambda name: len(clouds[name]))
    heights = [float(np.median(surface[:, 2])) for surface in tops[name] or (clouds[name],)]
    return max((height for height in heights if height < lowest + SUNK), default=min(heights))
