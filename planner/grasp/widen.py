"""Coming in with the fingers further apart: room for an object that is larger than what was seen of it."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from topple.planner.grasp.grasp import PINCH, Grasp
from topple.planner.grasp.hand import HandShape
from topple.planner.grasp.shape import Sought
from topple.planner.grasp.tolerances import SHARES
from topple.topology.base.arrays import BoolArray, FloatArray


def widen_pinches(grasps: Sequence[Grasp], sought: Sought, hand: HandShape) -> list[Grasp]:
    """Open the hand of each pinch as far as there is room.

    Args:
        grasps: Grasps of one object.
        sought: The object and what is around it; neighbours are kept off by `side_clearance`.
        hand: The hand.

    Returns:
        The same grasps in their order, those with room beside their fingers with a larger opening.
    """
    found: list[Grasp] = []
    for grasp in grasps:
        wider = [grasp.opening + share * (hand.max_opening - grasp.opening) for share in SHARES]
        free = (opening for opening in wider if _free(grasp, opening, sought, hand))
        opening = next(free, None) if grasp.kind == PINCH else None
        found.append(grasp if opening is None else replace(grasp, opening=opening))
    return found


def _free(grasp: Grasp, opening: float, sought: Sought, hand: HandShape) -> bool:
    """Whether the fingers come in so far apart, and close, without meeting anything."""
    surface, around, up, tolerances = sought.surface, sought.around, sought.up, sought.tolerances
    pose = grasp.pose_tool_to_world
    own, others = ((points - pose[:3, 3]) @ pose[:3, :3] for points in (surface.points, around.points))
    fingers = hand.footprints(opening)[: 2 * len(hand.finger)]
    between = (np.abs(others[:, 0]) < hand.pad_width / 2.0) & (np.abs(others[:, 1]) < opening / 2.0)
    if np.count_nonzero(between & (others[:, 2] < hand.tip)) > tolerances.stray_points:
        return False
    x, y, z = up @ pose[:3, :3]
    for x0, x1, y0, y1, front in fingers:
        lowest = float(pose[:3, 3] @ up) + min(x * x0, x * x1) + min(y * y0, y * y1) + z * front
        if lowest < around.floor + tolerances.under_clearance:
            return False
        for points, margin in ((own, 0.0), (others, tolerances.side_clearance)):
            met = _within(points, np.array([x0, y0]), np.array([x1, y1]), margin)
            met &= points[:, 2] < front + margin
            if np.count_nonzero(met) > tolerances.stray_points:
                return False
    return True


def _within(points: FloatArray, lower: FloatArray, upper: FloatArray, margin: float) -> BoolArray:
    """Which points (N, 3) are in a rectangle across the approach, or within a margin of it."""
    aside = np.abs(points[:, :2] - (lower + upper) / 2.0) - (upper - lower) / 2.0
    return np.asarray((aside < margin).all(axis=1))
