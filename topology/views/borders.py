"""Borders of masks that are a pixel or two off, put where the depth says they are.

A segmentation's edge wanders beside the object's. What it takes in of a neighbour then lies on the neighbour,
and looks like a contact, or like a part of the object that leans on it.
"""

from dataclasses import replace
from typing import cast

import numpy as np
from scipy import ndimage

from topple.topology.arrays import BoolArray, FloatArray, IntArray
from topple.topology.image import DepthImage
from topple.topology.views.tolerances import BORDER, CLOSER, NARROW, OFF, OFF_BORDERS, PATCH


def mend_masks(image: DepthImage) -> tuple[DepthImage, str | None]:
    """Give pixels at borders of masks to the neighbour whose surface they are of, where many are.

    Args:
        image: Depth and labels.

    Returns:
        The image with other labels, and a sentence that says so; or, where no more pixels are another's than
        flying ones of exact masks are, the same image and None.
    """
    share, label = border_share(image)
    if share <= OFF_BORDERS:
        return image, None
    said = (
        f"masks are off by a pixel or more: {100 * share:.0f} % of the pixels at their borders lie on a "
        "neighbour by depth, and count as its own"
    )
    return replace(image, label=label), said


def border_share(image: DepthImage) -> tuple[float, IntArray]:
    """How much of the borders of masks lies on the surface of a neighbour, and labels that put it right.

    Args:
        image: Depth and labels.

    Returns:
        Share of the pixels within `BORDER` pixels of a border that lie on another mask's surface, continued
        as a plane from its inside, and off their own; and labels (H, W) in which these are the other's.
        What is too narrow to have an inside keeps its pixels.
    """
    wide = cast(BoolArray, ndimage.binary_dilation(_changes(image.label), iterations=BORDER))
    rim = wide & (image.depth > 0)
    rows, columns = np.nonzero(rim)
    if len(rows) == 0:
        return 0.0, image.label
    margin = 2 * BORDER + PATCH
    part = tuple(slice(max(0, int(at.min()) - margin), int(at.max()) + margin + 1) for at in (rows, columns))
    label, depth, rim = image.label[part], image.depth[part], rim[part]
    rows, columns = np.nonzero(rim)
    there, now = depth[rows, columns], label[rows, columns]
    own, best, whose = np.full(len(rows), np.inf), np.full(len(rows), np.inf), now.copy()
    inside = ~rim & (depth > 0)
    numbers, flat = np.unique(label, return_inverse=True)
    boxes = ndimage.find_objects(flat.reshape(label.shape) + 1)
    for number, box in zip(numbers.tolist(), boxes, strict=True):
        around = tuple(slice(max(0, side.start - margin), side.stop + margin) for side in box)
        corner = np.array([side.start for side in around])
        close = np.nonzero(
            (rows >= around[0].start) & (rows < around[0].stop)
            & (columns >= around[1].start) & (columns < around[1].stop)
        )[0]  # fmt: skip
        core = inside[around] & (label[around] == number)
        if len(close) == 0 or not core.any():
            continue
        places = np.stack([rows[close], columns[close]]) - corner[:, None]
        error = np.abs(_continued(depth[around], core, places) - there[close])
        mine = now[close] == number
        own[close[mine]] = error[mine]
        better = error < best[close]
        whose[close[better]], best[close[better]] = number, error[better]
    off = OFF * np.maximum(1.0, there) ** 2
    wrong = (whose != now) & np.isfinite(own) & (own > off) & (best < np.minimum(CLOSER * own, off))
    labels = image.label.copy()
    labels[part][rows[wrong], columns[wrong]] = whose[wrong]
    return float(wrong.mean()), labels


def _changes(label: IntArray) -> BoolArray:
    """Pixels (H, W) on either side of a border between two labels."""
    found = np.zeros(label.shape, dtype=bool)
    down, right = label[1:] != label[:-1], label[:, 1:] != label[:, :-1]
    found[1:] |= down
    found[:-1] |= down
    found[:, 1:] |= right
    found[:, :-1] |= right
    return found


def _continued(depth: FloatArray, core: BoolArray, places: IntArray) -> FloatArray:
    """Depth (k,) [m] at pixels (2, k) of the surface seen in a core, inf where the core is too far away.

    The surface is continued as the plane that fits it best around the core's nearest pixel: planes are linear
    in the inverse of depth.
    """
    found = ndimage.distance_transform_edt(~core, return_indices=True)
    away, nearest = cast(tuple[FloatArray, IntArray], found)
    close = away[places[0], places[1]] <= 2 * BORDER + 1
    row, column = (along[close].astype(np.float64) for along in places)
    at = tuple(nearest[:, places[0, close], places[1, close]])
    rows, columns = (np.arange(side, dtype=np.float64) for side in core.shape)
    rows = rows[:, None]
    weight = core.astype(np.float64)
    inverse = np.where(core, 1.0 / np.maximum(depth, 1e-6), 0.0)  # [1/m], of depths beyond a micrometre

    def mean_of(values: FloatArray) -> FloatArray:
        return ndimage.uniform_filter(values, PATCH)[at]

    count = mean_of(weight)
    row_mean, column_mean = mean_of(weight * rows) / count, mean_of(weight * columns) / count
    level = mean_of(inverse) / count
    across_rows = mean_of(weight * rows**2) / count - row_mean**2 + NARROW
    across_columns = mean_of(weight * columns**2) / count - column_mean**2 + NARROW
    both = mean_of(weight * rows * columns) / count - row_mean * column_mean
    down = mean_of(inverse * rows) / count - level * row_mean
    right = mean_of(inverse * columns) / count - level * column_mean
    area = across_rows * across_columns - both**2
    slope_down = (down * across_columns - right * both) / area
    slope_right = (right * across_rows - down * both) / area
    plane = level + slope_down * (row - row_mean) + slope_right * (column - column_mean)
    continued = np.full(places.shape[1], np.inf)
    continued[close] = 1.0 / np.maximum(plane, 1e-6)
    return continued
