"""Another arm as something in the way: its links where it stands, a little larger than they are."""

from collections.abc import Sequence
from itertools import product

import numpy as np

from topple.planner.motion.tolerances import GIVES_WAY
from topple.robots.arm.arm import Arm
from topple.robots.arm.gripper import ToolState
from topple.topology.arrays import FloatArray
from topple.topology.bodies.solids import Solids
from topple.topology.geometry.rigid import transformed

_CORNERS = GIVES_WAY * np.array(list(product((-1.0, 1.0), repeat=3)))


def arm_bodies(
    whose: str, arm: Arm, pose_base_to_world: FloatArray, q: FloatArray, hands: Sequence[ToolState]
) -> Solids:
    """Bodies to keep clear of while another arm stands still.

    One arm moves at a time, so a motion that is certified against these bodies is certified against the other
    arm: it may be `GIVES_WAY` off, as the hand gives way when it closes.

    Args:
        whose: Begins their names, for messages.
        arm: The other arm.
        pose_base_to_world: (4, 4) where it stands.
        q: (n,) its joint values [rad].
        hands: How its hand may stand: what the fingers sweep between these is in the way.

    Returns:
        Vertices (V, 3) of convex parts in the world [m], by name.
    """
    poses = [pose_base_to_world @ arm.forward(q, hand)[0] for hand in hands]
    return {
        f"{whose} {link}": [
            _grown(np.concatenate([transformed(part, places[number]) for places in poses])) for part in parts
        ]
        for number, (link, parts) in enumerate(zip(arm.links, arm.parts, strict=True))
        if parts
    }


def _grown(points: FloatArray) -> FloatArray:
    """Points (8 V, 3) whose hull holds everything within `GIVES_WAY` of the hull of (V, 3)."""
    return (points[:, None] + _CORNERS).reshape(-1, 3)
