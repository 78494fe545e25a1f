"""How far an object reaches in plan: what was seen of it, and the whole circle where that is an arc.

Of a plate under another a camera sees a crescent of its rim. What lies on the plate has its middle beside the
crescent, but over the circle the crescent is part of.
"""

import numpy as np
from scipy import ndimage

from topple.topology.base.arrays import BoolArray, FloatArray, bounds, lengths
from topple.topology.geometry.axes import level_axes
from topple.topology.geometry.hull import Hull
from topple.topology.geometry.sides import beyond, sides_of
from topple.topology.geometry.tolerances import FEWEST, INSIDE, OPENED, ROUND
from topple.topology.kernels.outline import outline_corners
from topple.topology.kernels.spheres import sphere_through

CORNERS = np.arange(24) * (2 * np.pi / 24)
"""Directions in which a circle gets a corner: its area is a hundredth too small."""


def outline(points: FloatArray, up: FloatArray) -> FloatArray:
    """Points whose hull is what an object covers in plan.

    Args:
        points: (N, 3) seen points [m].
        up: (3,) unit vector upward.

    Returns:
        (M, 2) points [m] in the plane across `up`, the seen ones first.
    """
    flat = points @ np.stack(level_axes(up), axis=1)
    circle = _circle(flat)
    if circle is None:
        return flat
    centre, radius = circle
    return np.concatenate([flat, centre + radius * np.stack([np.cos(CORNERS), np.sin(CORNERS)], axis=1)])


def least_rectangle(flat: FloatArray) -> FloatArray:
    """Direction of a side of the least rectangle around points in a plane.

    One of its sides lies along an edge of the points' hull, so only these directions are tried.

    Args:
        flat: (N, 2) points [m], N >= 1.

    Returns:
        (2,) unit vector; along the points where they lie in one line.
    """
    corners = flat[outline_corners(flat)]
    if len(corners) == 0:
        middle = flat - flat.mean(axis=0)
        return np.asarray(np.linalg.eigh(middle.T @ middle)[1][:, 1], dtype=np.float64)
    sides = np.roll(corners, -1, axis=0) - corners
    sides /= np.linalg.norm(sides, axis=1, keepdims=True)
    across = np.stack([-sides[:, 1], sides[:, 0]], axis=1)
    areas = np.ptp(corners @ sides.T, axis=0) * np.ptp(corners @ across.T, axis=0)
    return sides[int(np.argmin(areas))]


def in_openings(flat: FloatArray, feet: FloatArray, places: FloatArray, cell: float) -> BoolArray:
    """Which places lie in openings: gaps that points enclose and in which something stands.

    Args:
        flat: (N, 2) points [m], at most `cell` apart.
        feet: (K, 2) where other things stand [m].
        places: (M, 2) places [m].
        cell: [m].

    Returns:
        (M,) True for those in a gap with feet in it.
    """
    lower, upper = bounds(flat)
    shape = np.floor((upper - lower) / cell).astype(np.int64) + 3  # a cell around all is outside
    walls, under, over = (
        tuple(np.clip(np.floor((each - lower) / cell).astype(np.int64) + 1, 0, shape - 1).T)
        for each in (flat, feet, places)
    )
    free = np.ones(shape, dtype=np.bool_)
    free[walls] = False
    gaps = np.zeros(shape, dtype=np.int32)
    ndimage.label(free, output=gaps)
    return np.isin(gaps[over], np.setdiff1d(gaps[under], [0, gaps[0, 0]]))


def amid(flat: FloatArray, place: FloatArray) -> bool:
    """Whether a place (2,) lies inside the hull of points (N, 2), by more than rounding may take away."""
    sides = sides_of(flat)
    return sides is not None and float(beyond(sides, place)) < -INSIDE


def covers(outlines: list[FloatArray], place: FloatArray, slack: float) -> bool:
    """Whether a place (2,) lies in the hull of some outlines together, or within `slack` [m] of it."""
    together = np.concatenate(outlines)
    hull = Hull.of(np.column_stack([together, np.zeros(len(together))]))
    return bool(hull.facet_distance(np.append(place, 0.0)[None])[0] <= slack)


def _circle(flat: FloatArray) -> tuple[FloatArray, float] | None:
    """Centre and radius of the circle of which points (N, 2) are an arc, if they are one."""
    if len(flat) < FEWEST:
        return None
    fit = sphere_through(flat)
    if fit is None:
        return None
    centre, radius = fit
    lower, upper = bounds(flat)
    chord = float(np.linalg.norm(upper - lower))
    if radius > OPENED * chord:
        return None
    off = lengths(flat - centre) - radius
    return None if float(np.sqrt(np.mean(off**2))) > ROUND * radius else (centre, radius)
