"""Pixels: surfaces projected into an image with a depth buffer."""

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import binary_fill_holes, maximum_filter, minimum_filter

from topple.planner.formats.pictures import Pixels
from topple.planner.report.drawing import Drawing, DrawnObject
from topple.planner.report.limits import LIMITS
from topple.topology.base.arrays import FloatArray


class Projection:
    """The pinhole view of a drawing from where it is first looked at, in an image of some size [px]."""

    def __init__(self, drawing: Drawing, width: int, height: int) -> None:
        self.width, self.height = width, height
        forward = drawing.centre - drawing.eye
        self._forward = forward / np.linalg.norm(forward)
        right = np.cross(self._forward, drawing.up)
        self._right = right / np.linalg.norm(right)
        self._down = np.cross(self._forward, self._right)
        lamp = 0.9 * drawing.up - self._forward - 0.5 * self._right  # over the viewer's shoulder
        self._lamp = lamp / np.linalg.norm(lamp)
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
        """Where points (N, 3) [m] fall: (N, 2) pixels (x, y) and (N,) depths [m], infinite behind the eye."""
        away = np.atleast_2d(points) - self._eye
        depth = away @ self._forward
        behind = depth < self._near
        scale = self._focal / np.where(behind, 1.0, depth)
        x = self.width / 2 + scale * (away @ self._right)
        y = self.height / 2 + scale * (away @ self._down)
        return np.stack([x, y], axis=1), np.where(behind, np.inf, depth)

    def size(self, depth: FloatArray) -> FloatArray:
        """Pixels that a metre takes at some depths [m]."""
        return self._focal / depth

    def lit(self, normals: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Light (N,), 0 to 1, on surfaces of unit normals (N, 3), and how depth grows by pixel (N, 2)."""
        facing = normals @ self._forward
        steep = np.where(facing < 0, -1.0, 1.0) * np.maximum(np.abs(facing), 0.3)
        slopes = -np.stack([normals @ self._right, normals @ self._down], axis=1) / steep[:, None]
        return np.abs(normals @ self._lamp), slopes


def render_clouds(drawing: Drawing, projection: Projection, paper: tuple[int, int, int]) -> Pixels:
    """Draw surfaces (H, W, 3) as the pages do: points are lit discs that lie in them; guesses are hatched."""
    height, width = projection.height, projection.width
    depth = np.full(height * width, np.inf)
    owner = np.full(height * width, -1, dtype=np.int64)
    light = np.ones(height * width)
    for number, drawn in enumerate(drawing.objects):
        pixel, far, shine = _discs(projection, drawn)
        np.minimum.at(depth, pixel, far)
        won = far == depth[pixel]
        owner[pixel[won]], light[pixel[won]] = number, shine[won]
    tables = [n for n, drawn in enumerate(drawing.objects) if drawn.fixed]
    hidden = _fill(owner.reshape(height, width), tables).ravel()
    colours = np.array([drawn.colour for drawn in drawing.objects], dtype=np.float64)
    fixed = np.array([drawn.fixed for drawn in drawing.objects], dtype=np.bool_)[owner]
    spacing = np.array([drawn.spacing for drawn in drawing.objects])[owner]
    fold = _edge(depth.reshape(height, width), np.where(fixed, np.inf, 2 * spacing).reshape(height, width))
    bright = np.maximum(np.abs(light) - fold.ravel() * (10 / drawing.radius), 0.4)
    row, column = np.divmod(np.arange(height * width), width)
    stripe = (row + column) // max(height // 150, 2) % 2 == 0
    table = np.where(hidden & stripe, 0.85, 0.7)
    faint = np.where(fixed, table, np.where(light < 0, np.where(stripe, 0.72, 0.3), 0.0))[:, None]
    image = np.minimum(colours[owner] * bright[:, None], 255.0)
    image = np.where((owner >= 0)[:, None], image + (np.array(paper) - image) * faint, paper)
    return image.round().astype(np.uint8).reshape(height, width, 3)


def _discs(projection: Projection, drawn: DrawnObject) -> tuple[NDArray[np.int64], FloatArray, FloatArray]:
    """The pixels that an object's discs cover: their number, depth [m], and light, below 0 where guessed."""
    places, depth = projection.pixels(drawn.points)
    side, slopes = projection.lit(drawn.normals)
    shine = (0.5 + 0.55 * side) * np.where(np.arange(len(depth)) < drawn.seen, 1.0, -1.0)
    scale = projection.size(depth)
    half = np.clip(scale * max(drawn.spacing * 1.15, 8e-4), 0.8, projection.height / LIMITS.largest)
    order = np.argsort(-half)  # the largest first, so that those that reach an offset come first
    order = order[np.isfinite(depth[order])]
    places, depth, shine = places[order], depth[order], shine[order]
    slopes, half, scale = slopes[order], half[order], scale[order]
    cells = np.rint(places).astype(np.int64)
    pixel, far, shines = [np.zeros(0, dtype=np.int64)], [np.zeros(0)], [np.zeros(0)]
    reach = int(np.ceil(half.max(initial=0.0)))
    for offset in np.ndindex(2 * reach + 1, 2 * reach + 1):
        step = np.array(offset) - reach
        count = int(np.searchsorted(-half, 0.71 - np.hypot(*step)))  # the middle may be that far off its cell
        cell = cells[:count] + step
        off = cell - places[:count]
        inside = ((off**2).sum(axis=1) <= half[:count] ** 2) & (cell >= 0).all(axis=1)
        at = np.nonzero(inside & (cell < (projection.width, projection.height)).all(axis=1))[0]
        pixel.append(cell[at, 1] * projection.width + cell[at, 0])
        far.append(depth[at] + (slopes[at] * off[at]).sum(axis=1) / scale[at])
        shines.append(shine[at])
    return np.concatenate(pixel), np.concatenate(far), np.concatenate(shines)


def _fill(owner: NDArray[np.int64], tables: list[int]) -> NDArray[np.bool_]:
    """Close the holes of a table in place, whose points lie too far apart for discs of bounded size.

    Returns:
        (H, W) what is left of holes in it: the table where something stood that has been taken away.
    """
    if not tables:
        return np.zeros(owner.shape, dtype=np.bool_)
    size = owner.shape[0] // 10
    covered = np.asarray(minimum_filter(maximum_filter(np.isin(owner, tables), size), size), dtype=np.bool_)
    owner[covered & (owner < 0)] = tables[0]
    hidden = np.asarray(binary_fill_holes(owner >= 0), dtype=np.bool_) & (owner < 0)
    owner[hidden] = tables[0]
    return hidden


def _edge(depth: FloatArray, slack: FloatArray) -> FloatArray:
    """By how much [m] the neighbours of a pixel stand in front of it: edges."""
    deep = np.where(np.isfinite(depth), depth, 1e9)  # nothing stands before nothing
    near = [np.roll(deep, step, axis=axis) for axis in (0, 1) for step in (-2, 2)]
    return np.sum([np.clip(deep - beside - slack, 0.0, 0.03) for beside in near], axis=0)
