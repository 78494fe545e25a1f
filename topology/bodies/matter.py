"""Matter: surfaces that no mask names and that reach beyond the objects, as plates to be kept clear of."""

import numpy as np
from scipy.spatial import ConvexHull

from topple.topology.base.arrays import BoolArray, FloatArray
from topple.topology.bodies.tolerances import BRIDGED, PLATE_BACK, PLATE_FLAT, PLATE_STRAYS, PLATE_SUNK
from topple.topology.scene.tolerances import LEAST_PLATE, MATTER_SPACING

MATTER = "something without a name"
"""What messages and plans call it: it is in the way, and no object."""


def plates_along(points: FloatArray, viewpoints: FloatArray) -> tuple[FloatArray, ...]:
    """Lay plates along surfaces, none of which reaches over a gap.

    What is not flat, or has a hole, is halved across its longest extent until it is as small as
    `LEAST_PLATE`. Halves share the points at the cut, so that their plates meet.

    Args:
        points: (N, 3) points of surfaces, `MATTER_SPACING` apart [m].
        viewpoints: (k, 3) from where they were seen, k >= 1 [m]: plates are thick on the side away.

    Returns:
        (V, 3) corners of each plate [m].
    """
    plates: list[FloatArray] = []
    left = [points] if len(points) else []
    while left:
        some = left.pop()
        middle = some.mean(axis=0)
        axes = np.linalg.eigh((some - middle).T @ (some - middle))[1]  # the thinnest first
        local = (some - middle) @ axes
        size = np.ptp(some, axis=0)
        if size.max() <= LEAST_PLATE or _is_plate(local):
            eye = viewpoints[np.linalg.norm(viewpoints - middle, axis=1).argmin()]
            plates.append(_plate(local, float((eye - middle) @ axes[:, 0])) @ axes.T + middle)
            continue
        along = some[:, size.argmax()]
        cut = (along.min() + along.max()) / 2.0
        left += [some[along <= cut + MATTER_SPACING], some[along >= cut - MATTER_SPACING]]
    return tuple(plates)


def _is_plate(local: FloatArray) -> bool:
    """Whether points (N, 3) along their axes, the thinnest first, are flat and fill their outline."""
    low, high = np.quantile(local[:, 0], PLATE_STRAYS)
    if high - low > PLATE_FLAT:
        return False
    cells = np.floor(local[:, 1:] / BRIDGED).astype(np.int64)
    corner = cells.min(axis=0)
    filled = np.zeros(cells.max(axis=0) - corner + 1, dtype=np.bool_)
    filled[tuple((cells - corner).T)] = True
    middles = (np.argwhere(~filled) + corner + 0.5) * BRIDGED
    return not _within(middles, local[:, 1:]).any()


def _within(places: FloatArray, points: FloatArray) -> BoolArray:
    """Which of (P, 2) places lie half a spacing and more within the outline of (N, 2) points."""
    sides = ConvexHull(_spread(points)).equations
    return np.asarray((places @ sides[:, :2].T + sides[:, 2] < -MATTER_SPACING).all(axis=1))


def _plate(local: FloatArray, eye: float) -> FloatArray:
    """The plate (V, 3) around points (N, 3) along their axes; `eye`: on which side it was seen from [m]."""
    spread = _spread(local[:, 1:])
    outline = spread[ConvexHull(spread).vertices]
    low, high = np.quantile(local[:, 0], PLATE_STRAYS) - PLATE_SUNK * np.array([-1.0, 1.0])
    low, high = (min(low, high - PLATE_BACK), high) if eye > 0.0 else (low, max(high, low + PLATE_BACK))
    faces = [np.insert(outline, 0, level, axis=1) for level in (low, high)]
    return np.concatenate(faces)


def _spread(points: FloatArray) -> FloatArray:
    """Corners (4 N, 2) of the squares that points (N, 2) stand for."""
    corners = MATTER_SPACING * (np.indices((2, 2)).reshape(2, -1).T - 0.5)
    return (points[:, None] + corners).reshape(-1, 2)
