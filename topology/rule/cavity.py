"""What a hollow object holds: places inside its hull with its wall standing higher all around."""

import numpy as np

from topple.topology.arrays import BoolArray, FloatArray, bounds, within_corners
from topple.topology.geometry.axes import perpendiculars
from topple.topology.rule.tolerances import AZIMUTHS
from topple.topology.tolerances import TOLERANCES

BLOCK = 1 << 14
"""Lines of sight looked along at once (1 MB): they stay in a core's own cache."""


def surrounded(places: FloatArray, wall: FloatArray, up: FloatArray, height: float) -> BoolArray:
    """Whether a wall stands higher than a place in nearly every direction around it.

    Args:
        places: (N, 3) places [m].
        wall: (M, 3) points of the wall [m].
        up: (3,) unit vector upward.
        height: How much higher the wall must stand [m]; noise alone reaches a deviation or two.

    Returns:
        (N,) True where the wall rises by `height` and by `wall_slope` in `wall_azimuths` of the directions.
    """
    axes = np.stack([*perpendiculars(up), up], axis=1)
    local, standing = places @ axes, wall @ axes
    found = np.zeros(len(places), dtype=np.bool_)
    step = max(1, BLOCK // max(len(wall), 1))
    for start in range(0, len(places), step):
        block = local[start : start + step]
        along = standing[:, 0] - block[:, None, 0]
        across = standing[:, 1] - block[:, None, 1]
        rise = standing[:, 2] - block[:, None, 2]
        place, point = np.nonzero(
            (rise >= height) & (rise * rise >= TOLERANCES.wall_slope**2 * (along * along + across * across))
        )
        turn = np.arctan2(across[place, point], along[place, point]) / (2 * np.pi) + 0.5
        seen = np.zeros((len(block), AZIMUTHS), dtype=np.bool_)
        seen[place, np.minimum((turn * AZIMUTHS).astype(np.int64), AZIMUTHS - 1)] = True
        found[start : start + step] = seen.mean(axis=1) >= TOLERANCES.wall_azimuths
    return found


def roofed(places: FloatArray, wall: FloatArray, up: FloatArray, height: float, aside: float) -> BoolArray:
    """Whether there is wall straight above a place.

    Args:
        places: (N, 3) places [m].
        wall: (M, 3) points of the wall [m].
        up: (3,) unit vector upward.
        height: How far above the place at least [m].
        aside: How far beside the vertical at most [m]; not less than the spacing of the points.

    Returns:
        (N,) True where a point of the wall is there.
    """
    found = np.zeros(len(places), dtype=np.bool_)
    if len(places) == 0:
        return found
    wall = _beside(places, wall, up, aside)
    step = max(1, BLOCK // max(len(wall), 1))
    for start in range(0, len(places), step):
        offset = wall[None] - places[start : start + step, None]
        rise = offset @ up
        beside = np.einsum("nmi,nmi->nm", offset, offset) - rise**2
        found[start : start + step] = ((rise > height) & (beside < aside**2)).any(axis=1)
    return found


def _beside(places: FloatArray, wall: FloatArray, up: FloatArray, aside: float) -> FloatArray:
    """The wall over and under the places' box in plan, in its order: the rest of a room is beside them."""
    level = np.stack(perpendiculars(up), axis=1)
    lower, upper = bounds(places @ level)
    margin = aside * (1 + 1e-6) + 1e-9  # more than rounding takes away
    flat = wall @ level
    return wall[within_corners(flat, lower - margin, upper + margin)]
