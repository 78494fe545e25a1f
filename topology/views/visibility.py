"""What the cameras saw: whether a place was empty in their sight, or hidden behind something."""

from collections.abc import Mapping
from copy import copy

import numpy as np

from topple.topology.arrays import BoolArray, FloatArray, IntArray
from topple.topology.image import DepthImage

CELL = 0.01
"""Width of a line of sight where only clouds and camera centres are known [rad]: 1 cm at 1 m."""
MARGIN = 0.006
"""How far behind the first surface a place must lie to count as hidden [m]: noise of a depth camera."""


class Visibility:
    """The free space of a scene, from its depth images or, without them, from clouds and camera centres."""

    def __init__(
        self, clouds: Mapping[str, FloatArray], viewpoints: FloatArray, images: tuple[DepthImage, ...] = ()
    ) -> None:
        """Remember how far each line of sight goes.

        Args:
            clouds: Points (N, 3) [m] by name.
            viewpoints: (k, 3) camera centres [m].
            images: Depth images, each with its own camera; they replace the camera centres.
        """
        self._images = images
        self._viewpoints = viewpoints if not images else np.zeros((0, 3))
        self._seen = {
            name: tuple(_nearest(cloud, viewpoint) for viewpoint in self._viewpoints)
            for name, cloud in clouds.items()
        }
        self._tables = self._ranges()

    def after(self, name: str, cloud: FloatArray) -> "Visibility":
        """The free space once one object's cloud is another; depth images stay what they are.

        Args:
            name: Name of the object.
            cloud: (N, 3) its new points [m].
        """
        if self._images:
            return self
        changed = copy(self)
        changed._seen = {**self._seen, name: tuple(_nearest(cloud, each) for each in self._viewpoints)}
        changed._tables = changed._ranges()
        return changed

    def _ranges(self) -> list[FloatArray]:
        """How far each camera sees in each direction; without end where no point is."""
        tables = [np.full((int(np.pi / CELL) + 2) * _columns(), np.inf) for _ in self._viewpoints]
        for views in self._seen.values():
            for table, (cells, reach) in zip(tables, views, strict=True):
                table[cells] = np.minimum(table[cells], reach)
        return tables

    @property
    def viewpoints(self) -> FloatArray:
        """(k, 3) centres of all cameras [m]."""
        return np.array([image.viewpoint for image in self._images]) if self._images else self._viewpoints

    @property
    def known(self) -> bool:
        """Whether any camera is known."""
        return bool(self._images) or len(self._viewpoints) > 0

    def free(self, places: FloatArray) -> BoolArray:
        """Which places some camera saw to be empty.

        Args:
            places: (N, 3) places [m].

        Returns:
            (N,) True: a line of sight went past the place. False: every camera's was blocked before, or the
            place is on a surface.
        """
        seen = np.zeros(len(places), dtype=np.bool_)
        for image in self._images:
            seen |= image.depth_past(places) > MARGIN
        for viewpoint, table in zip(self._viewpoints, self._tables, strict=True):
            key, reach = _directions(places, viewpoint)
            seen |= table[key] > reach - MARGIN
        return seen


def _directions(points: FloatArray, viewpoint: FloatArray) -> tuple[IntArray, FloatArray]:
    """Cell of the direction in which a camera sees each point, and how far away."""
    offset = points - viewpoint
    reach = np.linalg.norm(offset, axis=1)
    unit = offset / np.maximum(reach, 1e-12)[:, None]
    # Two angles: cells narrow towards the poles, where a depth camera hardly ever looks along y.
    row = ((np.arcsin(np.clip(unit[:, 1], -1, 1)) + np.pi / 2) / CELL).astype(np.int64)
    column = ((np.arctan2(unit[:, 0], unit[:, 2]) + np.pi) / CELL).astype(np.int64)
    return row * _columns() + column, reach


def _columns() -> int:
    return int(2 * np.pi / CELL) + 1


def _nearest(points: FloatArray, viewpoint: FloatArray) -> tuple[IntArray, FloatArray]:
    """Directions in which a camera has points before it, each once, and how far away the nearest one is."""
    key, reach = _directions(points, viewpoint)
    first = int(key.min())
    table = np.full(int(key.max()) - first + 1, np.inf)
    np.minimum.at(table, key - first, reach)
    cells = np.flatnonzero(np.isfinite(table))
    return cells + first, table[cells]
