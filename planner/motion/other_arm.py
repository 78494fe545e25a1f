"""Another arm as something in the way: its links where it stands, a little larger than they are."""

from collections.abc import Sequence
from itertools import product

import numpy as np

from topple.planner.motion.tolerances import GIVES_WAY, SPREAD
from topple.robots.arm.arm import Arm
from topple.robots.arm.gripper import ToolState
from topple.topology.base.arrays import FloatArray
from topple.topology.bodies.solids import Solids
from topple.topology.geometry.rigid import move_points
from topple.topology.geometry.samples import sample

_CORNERS = GIVES_WAY * np.array(list(product((-1.0, 1.0), repeat=3)))


def arm_bodies(
    prefix: str, arm: Arm, pose_base_to_world: FloatArray, q: FloatArray, hands: Sequence[ToolState]
) -> Solids:
    """Bodies to keep clear of while another arm stands still.

    One arm moves at a time, so a motion that is certified against these bodies is certified against the other
    arm: it may be `GIVES_WAY` off, as the hand gives way when it closes.

    Args:
        prefix: Begins their names, for messages.
        arm: The other arm.
        pose_base_to_world: (4, 4) where it stands.
        q: (n,) its joint values [rad].
        hands: How its hand may stand: what the fingers sweep between these is in the way.

    Returns:
        Vertices (V, 3) of convex parts in the world [m], by name.
    """
    poses = [pose_base_to_world @ arm.forward(q, hand)[0] for hand in hands]
    return {
        f"{prefix} {link}": [
            _grow(np.concatenate([move_points(part, places[number]) for places in poses])) for part in parts
        ]
        for number, (link, parts) in enumerate(zip(arm.links, arm.parts, strict=True))
        if parts
    }


def surface_points(arm: Arm, pose_base_to_world: FloatArray, q: FloatArray) -> FloatArray:
    """Points on an arm's links in many states at once, where telling roughly what is near is enough.

    Args:
        arm: The arm.
        pose_base_to_world: (4, 4) where it stands.
        q: (m, n) joint values [rad]; its hand is fully open.

    Returns:
        (m, P, 3) points in the world [m], about `SPREAD` apart.
    """
    poses = pose_base_to_world @ arm.forward(q)
    rows = [
        _at(poses[:, number], _thin(sample(parts, SPREAD))) for number, parts in enumerate(arm.parts) if parts
    ]
    return np.concatenate(rows, axis=1)


def _at(poses: FloatArray, points: FloatArray) -> FloatArray:
    """Points (m, P, 3) that points (P, 3) are in poses (m, 4, 4)."""
    return points @ poses[:, :3, :3].swapaxes(1, 2) + poses[:, None, :3, 3]


def _thin(points: FloatArray) -> FloatArray:
    """One point of (P, 3) of each cube with an edge of `SPREAD`."""
    cells = np.floor(points / SPREAD).astype(np.int64)
    return points[np.unique(cells, axis=0, return_index=True)[1]]


def _grow(points: FloatArray) -> FloatArray:
    """Points (8 V, 3) whose hull holds everything within `GIVES_WAY` of the hull of (V, 3)."""
    return (points[:, None] + _CORNERS).reshape(-1, 3)
