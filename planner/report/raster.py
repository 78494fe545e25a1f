"""Pixels: clouds projected into an image with a depth buffer, and images as PNG."""

import io
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from topple.planner.report.drawing import Drawing
from topple.topology.arrays import BoolArray, FloatArray
from topple.topology.errors import InvalidInput

if TYPE_CHECKING:
    from PIL import Image

Pixels = NDArray[np.uint8]


def picture(rgb: Pixels) -> bytes:
    """Write an image as PNG.

    Args:
        rgb: (H, W, 3) uint8.

    Returns:
        The bytes of the PNG file.

    Raises:
        InvalidInput: If the array is no such image.
    """
    from PIL import Image

    rgb = np.ascontiguousarray(rgb)
    if rgb.ndim != 3 or rgb.shape[2] != 3 or rgb.dtype != np.uint8 or rgb.size == 0:
        raise InvalidInput(f"a picture needs (H, W, 3) uint8, got shape {rgb.shape} of {rgb.dtype}")
    return png(Image.fromarray(rgb))


def png(image: "Image.Image") -> bytes:
    """The bytes of an image as a PNG file."""
    buffer = io.BytesIO()
    image.save(buffer, format="PNG", optimize=True)
    return buffer.getvalue()


class Projection:
    """The pinhole view of a drawing from where it is first looked at.

    Attributes:
        width: Width of the image [px].
        height: Height of the image [px].
    """

    def __init__(self, drawing: Drawing, width: int, height: int) -> None:
        self.width, self.height = width, height
        self._eye = drawing.eye
        forward = drawing.centre - drawing.eye
        self._forward = forward / np.linalg.norm(forward)
        right = np.cross(self._forward, drawing.up)
        self._right = right / np.linalg.norm(right)
        self._down = np.cross(self._forward, self._right)
        self._focal = 1.5 * min(width, height)
        self._near = float(np.linalg.norm(forward)) * 0.02

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

    def size(self, length: float, depth: FloatArray) -> FloatArray:
        """Pixels a length [m] takes at (N,) depths [m]."""
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
    depth = np.full(height * width, np.inf)
    owner = np.full(height * width, -1, dtype=np.int64)
    for number, drawn in enumerate(drawing.objects):
        cells, depths = _splats(projection, drawn.points, drawn.spacing)
        nearest = np.full(height * width, np.inf)
        np.minimum.at(nearest, cells, depths)
        won = nearest < depth
        depth[won] = nearest[won]
        owner[won] = number
    colours = np.array([drawn.colour for drawn in drawing.objects], dtype=np.float64)
    fixed = np.array([drawn.fixed for drawn in drawing.objects], dtype=np.bool_)
    return _shaded(
        depth.reshape(height, width), owner.reshape(height, width), colours, fixed, drawing.radius, paper
    )


def _splats(
    projection: Projection, points: FloatArray, spacing: float
) -> tuple[NDArray[np.int64], FloatArray]:
    """Pixels covered by the square dots of a cloud, and their depths."""
    places, depth = projection.pixels(points)
    ahead = np.isfinite(depth)
    places, depth = places[ahead], depth[ahead]
    half = np.clip(projection.size(spacing * 1.2, depth), 1.5, 14.0) / 2
    cells: list[NDArray[np.int64]] = []
    depths: list[FloatArray] = []
    reach = int(np.ceil(half.max())) if len(half) else 0
    for dy in range(-reach, reach + 1):
        for dx in range(-reach, reach + 1):
            covered = (abs(dx) <= half) & (abs(dy) <= half)
            x = np.round(places[covered, 0]).astype(np.int64) + dx
            y = np.round(places[covered, 1]).astype(np.int64) + dy
            inside = (x >= 0) & (x < projection.width) & (y >= 0) & (y < projection.height)
            cells.append(y[inside] * projection.width + x[inside])
            depths.append(depth[covered][inside])
    if not cells:
        return np.zeros(0, dtype=np.int64), np.zeros(0)
    return np.concatenate(cells), np.concatenate(depths)


def _shaded(
    depth: FloatArray,
    owner: NDArray[np.int64],
    colours: FloatArray,
    fixed: BoolArray,
    radius: float,
    paper: tuple[int, int, int],
) -> Pixels:
    """Colour each pixel by its object, darker the more its neighbours stand in front of it."""
    fold = np.zeros_like(depth)
    seen = owner >= 0
    behind = np.where(seen, depth, 0.0)
    reach = 2
    for axis in (0, 1):
        for step in (-reach, reach):
            beside = np.roll(depth, step, axis=axis)
            fold += np.clip(behind - np.where(np.isfinite(beside), beside, np.inf), 0.0, 0.03)
    light = np.clip(1.08 - fold * (14 / radius), 0.45, 1.08)[..., None]
    background = np.array(paper, dtype=np.float64)
    image = np.minimum(colours[owner] * light, 255.0)
    image = np.where(fixed[owner][..., None], image + (background - image) * 0.45, image)
    return np.where(seen[..., None], image, background).round().astype(np.uint8)
