"""Compliance of a closing hand: it gives way to the pad that comes first."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from topple.robots.arm import Arm
from topple.robots.poses import inverse
from topple.topology.arrays import FloatArray


@dataclass
class Compliance:
    """Moves a hand across itself, as fast as a pad closes, while one pad alone presses.

    An arm under impedance control does so by itself. Once both pads press there is nothing to give way to.

    Attributes:
        arm: An arm with fingers.
        pose_base_to_world: (4, 4) where it stands.
        start: (n,) joint values when the hand begins to close.
        stride: How far a pad closes in a step [m].
        force: By which one pad presses more than the other when the hand gives way [N]: what joint torque
            sensors tell from nothing, and less than moves a bowl.
        distance: How far it gives way at most [m]: objects are seen better than that.
        held: Whether both pads have pressed.
    """

    arm: Arm
    pose_base_to_world: FloatArray
    start: FloatArray
    stride: float
    force: float = 0.5
    distance: float = 0.015
    held: bool = False

    def after(self, q: FloatArray, pose_tool_to_world: FloatArray, pressing: Sequence[float]) -> FloatArray:
        """The joint values to hold next.

        Args:
            q: (n,) those held now.
            pose_tool_to_world: (4, 4) measured.
            pressing: Forces on the pads along the tool's y [N].

        Returns:
            (n,) the same where nothing presses on one side, or it has given way far enough.
        """
        push = sum(pressing)
        self.held = self.held or min(pressing, default=0.0) < 0.0 < max(pressing, default=0.0)
        if self.held or abs(push) < self.force:
            return q
        pose_tool_to_base = inverse(self.pose_base_to_world) @ pose_tool_to_world
        frames = self.arm.chain.frames(q[None])
        jacobian = self.arm.chain.jacobian(frames, pose_tool_to_base[None, :3, 3])[0]
        twist = np.concatenate([np.sign(push) * self.stride * pose_tool_to_base[:3, 1], np.zeros(3)])
        moved = q + np.linalg.lstsq(jacobian, twist, rcond=1e-2)[0]
        there, here = self.arm.tool_pose(np.stack([moved, self.start]))[:, :3, 3]
        return moved if np.linalg.norm(there - here) < self.distance else q
