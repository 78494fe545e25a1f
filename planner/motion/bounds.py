"""How far the arm's parts can move while the joints stay within an interval around a state."""

import numpy as np

from topple.planner.motion.model import CollisionModel
from topple.robots.arm.kinematics import Chain
from topple.robots.collision.separation import Float32Array, Frames
from topple.topology.arrays import IntArray


class MotionBounds:
    """Bounds on the motion of every part relative to every frame nearer the base.

    Turning joint j by at most d moves a point at distance r from its axis by at most r d. Taking the joints
    from the part towards the base, the axis of each is where it is in the middle state while the farther
    joints have moved the point by what they can, so the bound is a sum of d (r + the bound so far).
    """

    def __init__(self, model: CollisionModel, chain: Chain) -> None:
        self._sets = model.sets
        self._revolute = chain.revolute
        self._axes = chain.axes.astype(np.float32)
        self._beyond = [np.flatnonzero(model.sets.frame > j) for j in range(chain.size)]

    def of(self, frames: Frames, spans: Float32Array, centres: Float32Array) -> Float32Array:
        """Bounds in m states.

        Args:
            frames: Where the frames are in the m middle states.
            spans: (m, n) by how much each joint may differ from the middle state.
            centres: (3, P, m) sphere centres of all parts in the base.

        Returns:
            (n + 1, P, m) in [m]: entry f bounds the motion of a part as seen from frame f, 0 where the part
            is carried by that frame or one nearer the base.
        """
        count, joints = spans.shape
        result = np.zeros((joints + 1, len(self._sets.frame), count), dtype=np.float32)
        axes = np.einsum("jabm,jb->jam", frames.poses[1:, :, :3], self._axes)
        for j in range(joints - 1, -1, -1):
            # parts are not sorted by frame: those beyond the joint are picked
            beyond = self._beyond[j]
            span = spans[:, j]
            moved = result[j + 1, beyond]
            if self._revolute[j]:
                arms = centres[:, beyond] - frames.poses[j + 1, :, 3][:, None]
                along = np.einsum("apm,am->pm", arms, axes[j])
                squared = np.einsum("apm,apm->pm", arms, arms) - along * along
                radius = np.sqrt(np.maximum(squared, 0)) + self._sets.radius[beyond, None]
                moved += span * (radius + moved)
            else:
                moved += span
            result[j, beyond] = moved
        return result

    def relative(self, bounds: Float32Array, state: IntArray, a: IntArray, b: IntArray) -> Float32Array:
        """Bounds (T,) on how much the distance of parts a and b changes, from `of`'s result."""
        near = np.minimum(self._sets.frame[a], self._sets.frame[b])
        far = np.where(self._sets.frame[a] > self._sets.frame[b], a, b)
        return bounds[near, far, state]
