"""Where the open hands of grasps are: in what an object fills, and on their way in where no camera saw."""

from collections.abc import Sequence
from itertools import product

import numpy as np

from topple.planner.grasp.grasp import Grasp
from topple.planner.grasp.hand import HandShape
from topple.planner.grasp.prisms import Prism
from topple.planner.grasp.suction import CupShape
from topple.planner.grasp.tolerances import GRASP_TOLERANCES, SHARES_ASKED, WAY_LAYERS, GraspTolerances
from topple.robots.arm.gripper import ToolName
from topple.topology.base.arrays import BoolArray, FloatArray
from topple.topology.geometry.hull import Hull
from topple.topology.situation.situation import Situation


def standing_in(
    grasps: Sequence[Grasp],
    hand: HandShape,
    parts: Sequence[Hull],
    tolerances: GraspTolerances = GRASP_TOLERANCES,
) -> BoolArray:
    """Tell whose open fingers would stand in a body: its cloud may have a hole where it has none.

    Args:
        grasps: By fingers, in the world.
        hand: The fingers.
        parts: The convex parts of the body.
        tolerances: How deep a finger is in it.

    Returns:
        (G,) whether they would.
    """
    found = np.zeros(len(grasps), dtype=np.bool_)
    if not grasps:
        return found
    points = _in_world(grasps, _fingers(grasps, hand, hand.pad_length, 3)).swapaxes(0, 1)
    for layer, hull in product(range(SHARES_ASKED), parts):
        rows = np.flatnonzero(~found)  # most of those that stand in it do so with the first points asked
        asked = points[layer::SHARES_ASKED, rows]
        inside = np.logical_and.reduce(
            [
                (asked[..., axis] > hull.lower[axis]) & (asked[..., axis] < hull.upper[axis])
                for axis in range(3)
            ]
        )
        deep = (asked[inside] @ hull.normals.T + hull.offsets).max(axis=1, initial=-np.inf)
        found[rows[np.nonzero(inside)[1][deep < -tolerances.into_solid]]] = True
    return found


def coming_unseen(
    grasps: Sequence[Grasp],
    situation: Situation,
    hand: HandShape | None,
    cup: CupShape | None,
    tolerances: GraspTolerances = GRASP_TOLERANCES,
) -> BoolArray:
    """Tell whose hands come in through space that no camera saw to be empty.

    Asked is where the fingers are at the grasp and on their straight way there, or what is around the cup.
    Where both fingers are seen to be free, what is between them is bounded on both sides.

    Args:
        grasps: In the world.
        situation: What was seen, and what was moved since.
        hand: The fingers, where any grasp is by them.
        cup: The suction cup, likewise.
        tolerances: Length of the way, and how far behind a surface a place is hidden.

    Returns:
        (G,) whether they do; nobody does where no camera is known.
    """
    found = np.zeros(len(grasps), dtype=np.bool_)
    for tool, shape in ((ToolName.FINGERS, hand), (ToolName.SUCTION, cup)):
        rows = [row for row, grasp in enumerate(grasps) if grasp.tool == tool]
        if not rows or shape is None:
            continue
        some = [grasps[row] for row in rows]
        if isinstance(shape, HandShape):
            local = _fingers(some, shape, tolerances.way, WAY_LAYERS)
        else:
            local = np.tile(_filled(shape.body, tolerances.way, WAY_LAYERS), (len(rows), 1, 1))
        places = _in_world(some, local)
        seen = situation.shown(places.reshape(-1, 3), tolerances.into_solid).reshape(places.shape[:2])
        found[rows] = np.count_nonzero(~seen, axis=1) > tolerances.stray_points
    return found


def _fingers(grasps: Sequence[Grasp], hand: HandShape, length: float, layers: int) -> FloatArray:
    """Points (G, N, 3) in both open fingers and some metres behind their fronts, in the tool frames [m]."""
    half = np.array([grasp.opening / 2.0 for grasp in grasps])[:, None, None] * np.array([0.0, 1.0, 0.0])
    right = _filled(hand.finger, length, layers) + half
    return np.concatenate([right, right * np.array([1.0, -1.0, 1.0])], axis=1)


def _filled(prisms: Sequence[Prism], length: float, layers: int) -> FloatArray:
    """Points (N, 3) in prisms, from their fronts some metres back [m]."""
    grids = [
        np.meshgrid(
            np.linspace(*prism.x, 3),
            np.linspace(*prism.y, 3),
            prism.front - np.linspace(0.0, length, layers),
        )
        for prism in prisms
    ]
    return np.vstack([np.column_stack([axis.ravel() for axis in grid]) for grid in grids])


def _in_world(grasps: Sequence[Grasp], points: FloatArray) -> FloatArray:
    poses = np.stack([grasp.pose_tool_to_world for grasp in grasps])
    return points @ poses[:, :3, :3].swapaxes(1, 2) + poses[:, None, :3, 3]
