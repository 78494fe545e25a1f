"""Watches what stays while something is lifted: depth that changes outside of the shadow of arm and load."""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Protocol, runtime_checkable

import numpy as np
from scipy.ndimage import maximum_filter, minimum_filter
from scipy.spatial import ConvexHull, QhullError

from topple.planner.decide.arrange import Order
from topple.planner.decide.dependency import DependencyGraph, Reason
from topple.planner.execution.tolerances import HINT, TILE
from topple.planner.tolerances import DISTURBED
from topple.planner.transfer.transfer import Transfer
from topple.robots.driver import Driver
from topple.topology.base.arrays import BoolArray, FloatArray, IntArray
from topple.topology.kernels.tolerances import BORDER
from topple.topology.situation.situation import Situation
from topple.topology.statics.tolerances import FARTHEST
from topple.topology.views.image import DepthImage


@runtime_checkable
class CameraStream(Protocol):
    """What delivers pictures all the time, besides the looks."""

    def glimpse(self) -> Sequence[DepthImage]:
        """The pictures that came since the last time; none where none did."""
        ...


@dataclass(frozen=True, eq=False)
class LiftMonitor:
    """What a lift is watched with.

    Attributes:
        stream: What delivers pictures.
        images: Of the look before.
        situation: What was seen in them.
        named: Names of what is watched.
    """

    stream: CameraStream
    images: Sequence[DepthImage]
    situation: Situation
    named: Collection[str]

    def detector(self, transfer: Transfer, robot: Driver, path: FloatArray) -> "ChangeDetector":
        """Make the detector of changes while an arm with an object goes along a path (k, n)."""
        carried = (transfer.object, *transfer.riding)
        load = [part for name in carried for part in self.situation.solids.get(name, ())]
        moving = swept_parts(robot, path, transfer.grasp.tool, load)
        return ChangeDetector(self.images, self.stream, moving, self.named)


class ChangeDetector:
    """What of the things that stay is seen to move.

    Pictures are compared with one from before the lift, in tiles of a few pixels of one object each: the
    median of a tile is known to a sixth of what one pixel is.

    Args:
        before: Pictures of the last look: their masks say whose a pixel is.
        stream: What delivers pictures.
        moving: Convex parts (V, 3) of arm and load over all of the motion [m]: pixels before, in or behind
            them are left out.
        named: Names of what is watched.
    """

    def __init__(
        self,
        before: Sequence[DepthImage],
        stream: CameraStream,
        moving: Sequence[FloatArray],
        named: Collection[str],
    ) -> None:
        self._stream, self._moving = stream, moving
        self._masks = {_place(image): image for image in before}
        self._named = frozenset(named)
        self._views: dict[bytes, _View] = {}
        self.moved: Mapping[str, float] = {}

    def take_reference(self) -> bool:
        """Take the pictures that came as those from before the lift; True while a camera's is wanted."""
        for image in self._stream.glimpse():
            if (mask := self._masks.get(key := _place(image))) is not None:
                self._views[key] = _View.of(image, mask, self._moving, self._named)
        return len(self._views) < len(self._masks)

    def still(self) -> bool:
        """Whether nothing is seen to move; `moved` has what is, with how far its surface is off [m]."""
        for image in self._stream.glimpse():
            if (view := self._views.get(_place(image))) is not None:
                self.moved = {**self.moved, **view.offsets(image.depth)}
        return not self.moved


@dataclass(eq=False)
class _View:
    """One camera's part of it: tiles of pixels (H, W), numbered from 1, and whose each tile is."""

    tiles: IntArray
    names: tuple[str, ...]
    before: FloatArray

    def __post_init__(self) -> None:
        self._last, self._covered = np.zeros(len(self.names)), np.zeros(len(self.names), dtype=bool)

    @staticmethod
    def of(
        image: DepthImage, seen: DepthImage, moving: Sequence[FloatArray], named: Collection[str]
    ) -> "_View":
        """The tiles of a picture, by the masks of a look of as many rows and columns, or a multiple."""
        every = round(seen.depth.shape[0] / image.depth.shape[0])
        label = seen.label[::every, ::every]
        alone = (minimum_filter(label, 3) == label) & (maximum_filter(label, 3) == label)
        left = [n for n, name in seen.names.items() if name in named]
        alone &= np.isin(label, left) & ~shadow(image, moving)
        rows, columns = np.indices(label.shape) // TILE
        numbered = (label * (rows.max() + 1) + rows) * (columns.max() + 1) + columns
        found, tiles = np.unique(np.where(alone, numbered, -1), return_inverse=True)
        tiles = tiles.reshape(label.shape) + int(found[0] != -1)
        whose = found[found >= 0] // ((rows.max() + 1) * (columns.max() + 1))
        return _View(tiles, tuple(seen.names[int(number)] for number in whose), image.depth)

    def offsets(self, depth: FloatArray) -> dict[str, float]:
        """Names of what is off its place in a picture (H, W), by how far [m]."""
        off = np.where((depth > 0) & (self.before > 0), depth - self.before, np.inf)
        pixels, middle = self._per_tile(off, np.abs(off) < 4 * DISTURBED)  # what is further off came between
        self._covered |= np.abs(middle - self._last) > DISTURBED  # and what jumps: nothing moves so fast
        self._last = middle
        wrong = (pixels >= TILE**2 // 4) & (np.abs(middle) > HINT) & ~self._covered
        found: dict[str, float] = {}
        for tile in np.flatnonzero(wrong):
            found[self.names[tile]] = max(found.get(self.names[tile], 0.0), abs(float(middle[tile])))
        return found

    def _per_tile(self, values: FloatArray, counts: BoolArray) -> tuple[IntArray, FloatArray]:
        """(tiles,) pixels that count, and the median of their values (H, W): some may be covered by now."""
        counts &= self.tiles > 0
        tiles, values = self.tiles[counts], values[counts]
        values = values[np.lexsort((values, tiles))]
        pixels = np.bincount(tiles, minlength=len(self.names) + 1)[1:]
        middle = np.cumsum(pixels) - (pixels + 1) // 2
        return pixels, np.append(values, 0.0)[middle]


def neighbours_to_watch(situation: Situation, order: Order, name: str) -> set[str]:
    """Find objects with boxes near one to be lifted, which may move with it and could go before it."""
    boxes = {other: np.stack([cloud.min(0), cloud.max(0)]) for other, cloud in situation.surfaces.items()}
    low, high = boxes[name] + [[-FARTHEST], [FARTHEST]]
    near = {other for other, box in boxes.items() if (box[0] < high).all() and (box[1] > low).all()}
    reasoned = [edge for edge in order.graph.dependencies if edge.reason is not Reason.MEASURED]
    graph = DependencyGraph(order.graph.names, tuple(reasoned))
    return {other for other in near.intersection(graph.names) - {name} if name not in graph.before(other)}


def shadow(image: DepthImage, parts: Sequence[FloatArray]) -> BoolArray:
    """Pixels (H, W) whose rays meet one of some convex parts (V, 3) [m], or pass close by."""
    found = np.zeros(image.depth.shape, dtype=bool)
    for part in parts:
        local = (part - image.viewpoint) @ image.pose_camera_to_world[:3, :3]
        local = local[local[:, 2] > 0.0]
        if len(local) < 3:
            continue
        places = (local @ image.K.T / local[:, 2:])[:, :2]
        try:
            sides = ConvexHull(places).equations
        except QhullError:
            continue
        low = np.maximum(np.floor(places.min(axis=0)) - BORDER, 0).astype(int)
        high = np.minimum(np.ceil(places.max(axis=0)) + BORDER + 1, found.shape[::-1]).astype(int)
        if (high <= low).any():
            continue
        x, y = np.meshgrid(np.arange(low[0], high[0]), np.arange(low[1], high[1]))
        beyond = np.max([a * x + b * y + c for a, b, c in sides], axis=0)
        found[low[1] : high[1], low[0] : high[0]] |= beyond < BORDER
    return found


def swept_parts(robot: Driver, path: FloatArray, tool: str, load: Sequence[FloatArray]) -> list[FloatArray]:
    """Convex parts (V, 3) of an arm and its load over a straight path of joint values (k, n) [m]."""
    few = path[[0, len(path) // 2, -1]]
    state, base = replace(robot.tool_state, opening=robot.opening), robot.pose_base_to_world
    stands = zip(*(robot.arm.bodies(q, base, state) for q in few), strict=True)
    places = robot.arm.tool_pose(few, tool)[:, :3, 3] @ base[:3, :3].T
    carried = [[part + place - places[0] for place in places] for part in load]
    return [np.concatenate(each) for each in (*stands, *carried)]


def _place(image: DepthImage) -> bytes:
    """Which camera a picture is of: where it stands."""
    return image.pose_camera_to_world.tobytes()
