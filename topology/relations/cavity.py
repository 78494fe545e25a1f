"""What a hollow object holds: places inside its hull with its wall standing higher all around."""

import numpy as np

from topple.topology.base.arrays import BoolArray, FloatArray, bounds, within_corners
from topple.topology.base.tolerances import TOLERANCES
from topple.topology.geometry.axes import perpendiculars
from topple.topology.kernels import cavity
from topple.topology.relations.tolerances import AZIMUTHS


def is_surrounded(places: FloatArray, wall: FloatArray, up: FloatArray, height: float) -> BoolArray:
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
    least = int(np.ceil(TOLERANCES.wall_azimuths * AZIMUTHS))
    return cavity.wall_around(places @ axes, wall @ axes, height, TOLERANCES.wall_slope, AZIMUTHS, least)


def is_roofed(places: FloatArray, wall: FloatArray, up: FloatArray, height: float, aside: float) -> BoolArray:
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
    if len(places) == 0:
        return np.zeros(0, dtype=np.bool_)
    axes = np.stack([*perpendiculars(up), up], axis=1)
    local, standing = places @ axes, wall @ axes
    lower, upper = bounds(local[:, :2])
    near = within_corners(standing[:, :2], lower - aside, upper + aside)
    return cavity.wall_above(local, standing[near], height, aside)
