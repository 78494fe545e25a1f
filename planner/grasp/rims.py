"""Hand directions around the edge of a sheet, a plate's rim for one: one finger above it and one below."""

import numpy as np

from topple.planner.grasp.frames import Frames
from topple.planner.grasp.hand import HandShape
from topple.planner.grasp.shape import Sought
from topple.planner.grasp.tolerances import (
    DIRECTIONS,
    FEWEST,
    LEANS,
    PATCH,
    RIMS_FLAT,
    STEEPEST,
    GraspTolerances,
)
from topple.topology.base.arrays import FloatArray
from topple.topology.geometry.axes import cross


def rim_frames(sought: Sought, hand: HandShape) -> list[Frames]:
    """Lay out hand directions that come in along a sheet from outside its edge.

    The hand leans with the sheet, a little steeper at most, so that the pads meet it square: hands from above
    close across sides, of which a flat sheet has none to speak of. An edge closer to the ground than the
    lower finger and the hand behind it need is left out, and the reason says by how much.

    Args:
        sought: The object and the ground; takes down what is left out and why.
        hand: The hand.

    Returns:
        The directions, edge point by edge point. Deterministic.
    """
    surface, up = sought.surface, sought.up
    found: list[Frames] = []
    low: list[tuple[float, float]] = []
    for place, outward, normal in _edges(surface.points[: surface.seen], up):
        turned = np.array([_leaning_frame(outward, normal, lean) for lean in LEANS])
        needed = np.array([_height(rotation, up, hand, sought.tolerances) for rotation in turned])
        height = float(place @ up) - sought.around.floor
        high = needed <= height
        if high.any():
            tilts = np.arccos(np.clip(-turned[high, :, 2] @ up, -1.0, 1.0))
            found.append(Frames(place, turned[high], tilts))
        else:
            low.append((height, float(needed.min())))
    if low:
        height, needed_there = max(low, key=lambda pair: pair[0] - pair[1])
        sought.dropped.note(
            f"its rim is {1e3 * height:.0f} mm off the ground, a finger below it and the hand behind take "
            f"{1e3 * needed_there:.0f} mm",
            len(low),
        )
    return found


def _edges(points: FloatArray, up: FloatArray) -> list[tuple[FloatArray, FloatArray, FloatArray]]:
    """Outermost points where a sheet ends, with the way out along it and its normal, turned up."""
    east = cross(up, np.eye(3)[int(np.argmin(np.abs(up)))])
    east /= np.linalg.norm(east)
    north = cross(up, east)
    found: list[tuple[FloatArray, FloatArray, FloatArray]] = []
    for angle in np.arange(DIRECTIONS) * 2.0 * np.pi / DIRECTIONS:
        out = np.cos(angle) * east + np.sin(angle) * north
        place = points[int(np.argmax(points @ out))]
        near = points[np.linalg.norm(points - place, axis=1) < PATCH]
        if len(near) < FEWEST:
            continue
        values, vectors = np.linalg.eigh(np.cov(near.T))
        normal = vectors[:, 0] * np.sign(vectors[:, 0] @ up)
        if values[0] < RIMS_FLAT * values[1] and normal @ up > STEEPEST:
            along = out - normal * float(out @ normal)
            found.append((place, along / np.linalg.norm(along), normal))
    return found


def _leaning_frame(outward: FloatArray, normal: FloatArray, lean: float) -> FloatArray:
    """A hand's rotation: it comes in along the sheet, `lean` [rad] steeper, and closes across it."""
    approach = -np.cos(lean) * outward - np.sin(lean) * normal
    closing = np.cos(lean) * normal - np.sin(lean) * outward
    return np.column_stack([cross(closing, approach), closing, approach])


def _height(rotation: FloatArray, up: FloatArray, hand: HandShape, tolerances: GraspTolerances) -> float:
    """Height over the ground that a thin sheet's edge has at least for a hand to come in below it [m]."""
    x, y, z = up @ rotation
    back = hand.tip - tolerances.depths[0]  # from the edge to the pads' middle, the tips as shallow as can be
    corners = (
        min(x * x0, x * x1) + min(y * y0, y * y1) + z * (front - back)
        for x0, x1, y0, y1, front in hand.footprints(2.0 * tolerances.side_clearance)
    )
    return tolerances.under_clearance - float(min(corners))
