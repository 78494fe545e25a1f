"""Compliance of a closing hand: it gives way to the pad that comes first, and turns until both lie flat."""

from dataclasses import dataclass

import numpy as np

from topple.robots.arm.arm import Arm
from topple.robots.arm.gripper import FINGERS
from topple.robots.poses import angle_between, inverse
from topple.topology.base.arrays import FloatArray


@dataclass
class Compliance:
    """Moves a hand while its jaw closes gently: across itself, and about its middle.

    An arm under impedance control does so by itself. From when one pad presses the hand goes across as fast
    as a pad closes, so that this pad stands still, until the other one is there. Once both press, it turns
    about its approach and about the pads' breadth against the torque, so that pads that meet a face or a wall
    askew turn themselves and not the object.

    Attributes:
        arm: An arm with fingers.
        pose_base_to_world: (4, 4) where it stands.
        start: (n,) joint values when the hand begins to close.
        stride: How far a pad closes in a step [m].
        turn: Angle by which the hand turns in a step under a torque of 1 N m [rad].
        force: By which one pad presses more than the other when the hand gives way [N]: what joint torque
            sensors tell from nothing, and less than moves a bowl.
        distance: How far it gives way at most [m]: objects are seen better than that.
        friction: Between pads and object at most: by it a hand that turns would take along what is wide.
        angle: How far it turns at most [rad]: a wall's slope is seen better than that.
        leading: Along the hand's y, which way the pad that came first is pressed: 1 or -1; 0 while none is.
        held: Whether both pads have pressed.
    """

    arm: Arm
    pose_base_to_world: FloatArray
    start: FloatArray
    stride: float
    turn: float
    force: float = 0.5
    distance: float = 0.015
    friction: float = 0.5
    angle: float = 0.2
    leading: float = 0.0
    held: bool = False

    def after(
        self, q: FloatArray, pose_tool_to_world: FloatArray, places: FloatArray, forces: FloatArray
    ) -> FloatArray:
        """The joint values to hold next.

        Args:
            q: (n,) those held now.
            pose_tool_to_world: (4, 4) measured.
            places: (k, 3) where something presses on the pads, in the tool's frame [m].
            forces: (k, 3) how it presses, in the tool's frame [N].

        Returns:
            (n,) the same where nothing is uneven, or the hand has given way far enough.
        """
        across = forces[:, 1]
        self.held = self.held or bool(across.min(initial=0.0) < 0.0 < across.max(initial=0.0))
        twist = np.zeros(6)
        if self.held:
            torque = np.cross(places, forces).sum(axis=0)
            torque[1] = 0.0  # about the line through the pads nothing lies flatter
            dragging = self.friction * float(np.abs(places[:, 1] * across).sum())
            twist[3:] = self.turn * np.where(np.abs(torque) > dragging, torque, 0.0)
        else:
            if self.leading == 0.0 and abs(across.sum()) >= self.force:
                self.leading = float(np.sign(across.sum()))
            twist[1] = self.leading * self.stride
        if not twist.any():
            return q
        pose_tool_to_base = inverse(self.pose_base_to_world) @ pose_tool_to_world
        frames = self.arm.chain.frames(q[None])
        jacobian = self.arm.chain.jacobian(frames, pose_tool_to_base[None, :3, 3])[0]
        in_base = (twist.reshape(2, 3) @ pose_tool_to_base[:3, :3].T).reshape(-1)
        moved = q + np.linalg.lstsq(jacobian, in_base, rcond=1e-2)[0]
        there, here = self.arm.tool_pose(np.stack([moved, self.start]), FINGERS)
        near = np.linalg.norm(there[:3, 3] - here[:3, 3]) < self.distance
        return moved if near and angle_between(there, here) < self.angle else q
