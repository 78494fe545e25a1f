"""Pixels: clouds projected into an image with a depth buffer."""

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from topple.planner.pictures import Pixels
from topple.planner.report.drawing import Drawing
from topple.topology.arrays import FloatArray

if TYPE_CHECKING:
    pass


class Projection:
    """The pinhole view of a drawing from where it is first looked at.

    Attributes:
        width: Width of the image [px].
        height: Height of the image [px].
    """

    def __init__(self, drawing: Drawing, width: int, height: int) -> None:
        self.width, self.height = width, height
        forward = drawing.centre - drawing.eye
        self._forward = forward / np.linalg.norm(forward)
        right = np.cross(self._forward, drawing.up)
        self._right = right / np.linalg.norm(right)
        self._down = np.cross(self._forward, self._right)
        self._focal = 1.5 * min(width, height)
        distance = self._fit(drawing)
        self._eye = drawing.centre - self._forward * distance
        self._near = distance * 0.02

    def _fit(self, drawing: Drawing) -> float:
        """Nearest the eye may come [m] for every corner of what can be taken to stay in sight."""
        shown = [drawn for drawn in drawing.objects if not drawn.fixed] or drawing.objects
        corners = np.concatenate([drawn.corners for drawn in shown]) - drawing.centre
        across = np.abs(corners @ self._right) / (0.42 * self.width)
        along = np.abs(corners @ self._down) / (0.38 * self.height)
        distance = np.maximum(across, along) * self._focal - corners @ self._forward
        return max(float(distance.max()), drawing.radius * 1.5)

    def pixels(self, points: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Where points fall.

        Args:
            points: (N, 3) points [m].

        Returns:
            (N, 2) pixel coordinates (x, y) and (N,) depths [m]; a depth is infinite behind the eye.
        """
        away = np.atleast_2d(points) - self._eye
        depth = away @ self._forward
        behind = depth < self._near
        scale = self._focal / np.where(behind, 1.0, depth)
        x = self.width / 2 + scale * (away @ self._right)
        y = self.height / 2 + scale * (away @ self._down)
        return np.stack([x, y], axis=1), np.where(behind, np.inf, depth)

    def size(self, length: float, depth: float) -> float:
        """Pixels a length [m] takes at a depth [m]."""
        return length * self._focal / depth


def render_clouds(drawing: Drawing, projection: Projection, paper: tuple[int, int, int]) -> Pixels:
    """Draw the clouds, near points over far ones, folds and edges darkened.

    Args:
        drawing: The scene as it is drawn.
        projection: The view.
        paper: Background colour.

    Returns:
        (H, W, 3) uint8.
    """
    height, width = projection.height, projection.width
    depth = np.full((height, width), np.inf)
    owner = np.full((height, width), -1, dtype=np.int64)
    for number, drawn in enumerate(drawing.objects):
        rows, columns, near = _patch(
            projection, drawn.points, drawn.spacing, height / (150 if drawn.fixed else 40)
        )
        won = near < depth[rows, columns]
        depth[rows, columns][won] = near[won]
        owner[rows, columns][won] = number
    colours = np.array([drawn.colour for drawn in drawing.objects], dtype=np.float64)
    fixed = np.array([drawn.fixed for drawn in drawing.objects], dtype=np.bool_)
    spacing = np.array([drawn.spacing for drawn in drawing.objects])
    slack = np.where(fixed, 1e9, 1.5 * spacing)  # dots stand in steps on a slanted surface
    image = _shaded(depth, owner, colours, slack, drawing.radius)
    background = np.array(paper, dtype=np.float64)
    image = np.where(fixed[owner][..., None], image + (background - image) * 0.6, image)
    return np.where((owner >= 0)[..., None], image, background).round().astype(np.uint8)


def _patch(
    projection: Projection, points: FloatArray, spacing: float, largest: float
) -> tuple[slice, slice, FloatArray]:
    """The part of the image a cloud covers, and the depth of its nearest point at each pixel there."""
    from scipy.ndimage import minimum_filter

    places, depth = projection.pixels(points)
    cells = np.round(places).astype(np.int64)
    inside = np.isfinite(depth) & (cells >= 0).all(axis=1)
    inside &= (cells[:, 0] < projection.width) & (cells[:, 1] < projection.height)
    cells, depth = cells[inside], depth[inside]
    if not len(cells):
        return slice(0, 0), slice(0, 0), np.zeros((0, 0))
    dot = int(np.clip(projection.size(spacing * 1.9, float(np.median(depth))), 2, largest))
    lower = np.maximum(cells.min(axis=0) - dot, 0)
    upper = np.minimum(cells.max(axis=0) + dot + 1, [projection.width, projection.height])
    near = np.full((int(upper[1] - lower[1]), int(upper[0] - lower[0])), np.inf)
    np.minimum.at(near, (cells[:, 1] - lower[1], cells[:, 0] - lower[0]), depth)
    near = np.asarray(minimum_filter(near, size=dot, mode="constant", cval=np.inf))
    return slice(int(lower[1]), int(upper[1])), slice(int(lower[0]), int(upper[0])), near


def _shaded(
    depth: FloatArray, owner: NDArray[np.int64], colours: FloatArray, slack: FloatArray, radius: float
) -> FloatArray:
    """Colour each pixel by its object, darker the more its neighbours stand in front of it."""
    fold = np.zeros_like(depth)
    limit = np.where(owner >= 0, depth, -np.inf) - slack[owner]
    for axis in (0, 1):
        for step in (-2, 2):
            beside = np.roll(depth, step, axis=axis)
            fold += np.clip(np.where(np.isfinite(beside), limit - beside, 0.0), 0.0, 0.03)
    light = np.clip(1.08 - fold * (14 / radius), 0.45, 1.08)[..., None]
    return np.minimum(colours[owner] * light, 255.0)
