"""Whether a wall stands around places, or above them."""

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

from topple.topology.kernels.compiled import address, kernels
from topple.topology.kernels.tolerances import LOOKED_ALONG

if TYPE_CHECKING:
    from topple.topology.base.arrays import BoolArray, FloatArray


def wall_around(
    places: "FloatArray", wall: "FloatArray", height: float, slope: float, sectors: int, least: int
) -> "BoolArray":
    """Tell around which places a wall stands higher.

    Args:
        places: (N, 3) places [m], z upward.
        wall: (M, 3) points of the wall [m].
        height: How much higher they are at least [m].
        slope: How much higher at least in shares of their distance in plan.
        sectors: Into how many directions a turn is cut, at most 64.
        least: In how many of them a point has to be.

    Returns:
        (N,) True for those places; kernel and twin differ at most by points on the edge of two sectors.
    """
    found, compiled = np.zeros(len(places), dtype=np.bool_), kernels()
    if compiled is not None:
        compiled.cavity_walled(
            *_arrays(places, wall), height, slope, sectors, least, address(found.view(np.uint8))
        )
        return found
    for block, along, across, rise in _lines(places, wall):
        place, point = np.nonzero(
            (rise >= height) & (rise * rise >= slope**2 * (along * along + across * across))
        )
        turn = np.arctan2(across[place, point], along[place, point]) / (2 * np.pi) + 0.5
        seen = np.zeros((len(rise), sectors), dtype=np.bool_)
        seen[place, np.minimum((turn * sectors).astype(np.int64), sectors - 1)] = True
        found[block] = seen.sum(axis=1) >= least
    return found


def wall_above(places: "FloatArray", wall: "FloatArray", height: float, aside: float) -> "BoolArray":
    """Tell above which places there is a wall.

    Args:
        places: (N, 3) places [m], z upward.
        wall: (M, 3) points of the wall [m].
        height: How far above at least [m].
        aside: How far beside the vertical at most [m].

    Returns:
        (N,) True for those places; kernel and twin give the same.
    """
    found, compiled = np.zeros(len(places), dtype=np.bool_), kernels()
    if compiled is not None:
        compiled.cavity_roofed(*_arrays(places, wall), height, aside, address(found.view(np.uint8)))
        return found
    for block, along, across, rise in _lines(places, wall):
        found[block] = ((rise > height) & (along * along + across * across < aside**2)).any(axis=1)
    return found


def _arrays(places: "FloatArray", wall: "FloatArray") -> tuple[int, int, int, int]:
    """Arguments of both kernels; the caller holds arrays that are contiguous."""
    return address(places), len(places), address(wall), len(wall)


def _lines(
    places: "FloatArray", wall: "FloatArray"
) -> "Iterator[tuple[slice, FloatArray, FloatArray, FloatArray]]":
    """From blocks of places to the points of a wall, (n, M) each along x, y and z [m]."""
    step = max(1, LOOKED_ALONG // max(len(wall), 1))
    for start in range(0, len(places), step):
        block = slice(start, start + step)
        away = wall.T[:, None] - places[block].T[:, :, None]
        yield block, away[0], away[1], away[2]
