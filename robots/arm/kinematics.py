"""Forward kinematics and Jacobians of a serial chain, for many states at once."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from topple.robots.arm.tolerances import ROUNDING
from topple.robots.arm.urdf import Joint, Model
from topple.topology.base.arrays import BoolArray, FloatArray, freeze
from topple.topology.base.errors import InvalidInput
from topple.topology.geometry.axes import cross
from topple.topology.kernels.compiled import address, kernels


@dataclass(frozen=True, eq=False)
class Chain:
    """Driven joints in series, each with the fixed transform before it.

    The transform of joint k is T_k(q) = K0 + cos(q) K1 + sin(q) K2 when it turns and K0 + q K1 when it
    slides, so that many states cost a few array operations.

    Attributes:
        k0: (n, 4, 4) constant part.
        k1: (n, 4, 4) part that goes with cos(q), or with q for a sliding joint.
        k2: (n, 4, 4) part that goes with sin(q), zero for a sliding joint.
        axes: (n, 3) unit joint axes in the frame behind the joint.
        revolute: (n,) whether the joint turns.
        lower: (n,) lower limits in [rad] or [m].
        upper: (n,) upper limits in [rad] or [m].
    """

    k0: FloatArray
    k1: FloatArray
    k2: FloatArray
    axes: FloatArray
    revolute: BoolArray
    lower: FloatArray
    upper: FloatArray

    @property
    def size(self) -> int:
        """Number of joints."""
        return len(self.axes)

    @cached_property
    def reach(self) -> float:
        """A distance from the base that the last frame's origin never exceeds [m]."""
        sizes = [np.linalg.norm(k[:, :3, 3], axis=1) for k in (self.k0, self.k1, self.k2)]
        most = np.where(self.revolute, 1.0, np.maximum(np.abs(self.lower), np.abs(self.upper)))
        return float(np.sum(sizes[0] + most * sizes[1] + sizes[2])) + ROUNDING

    @staticmethod
    def of(
        joints: tuple[Joint, ...], before: tuple[FloatArray, ...], lower: FloatArray, upper: FloatArray
    ) -> "Chain":
        """Build a chain.

        Args:
            joints: The driven joints, base first.
            before: For each joint the (4, 4) pose of its frame at value zero in the previous joint's frame.
            lower: (n,) lower limits.
            upper: (n,) upper limits.
        """
        k0, k1, k2 = (np.zeros((len(joints), 4, 4)) for _ in range(3))
        for i, (joint, fixed) in enumerate(zip(joints, before, strict=True)):
            constant, cosine, sine = _joint_terms(joint)
            k0[i], k1[i], k2[i] = fixed @ constant, fixed @ cosine, fixed @ sine
        revolute = np.array([joint.kind != "prismatic" for joint in joints], dtype=np.bool_)
        revolute.setflags(write=False)
        axes = np.array([joint.axis for joint in joints]).reshape(-1, 3)
        return Chain(freeze(k0), freeze(k1), freeze(k2), freeze(axes), revolute, freeze(lower), freeze(upper))

    def frames(self, q: FloatArray) -> FloatArray:
        """Poses of all joint frames.

        Args:
            q: (m, n) joint values in [rad] or [m].

        Returns:
            (m, n + 1, 4, 4) poses of the joint frames in the base; index 0 is the base itself.
        """
        frames = np.empty((len(q), self.size + 1, 4, 4))
        frames[:, :, :3] = self.poses(q).transpose(3, 0, 1, 2)
        frames[:, :, 3] = (0, 0, 0, 1)
        return frames

    @cached_property
    def terms(self) -> FloatArray:
        """(n, 12, 3) the rows of k0, k1 and k2, but the last one, side by side."""
        terms: FloatArray = np.stack([k[:, :3] for k in (self.k0, self.k1, self.k2)], axis=-1)
        return np.ascontiguousarray(terms.reshape(self.size, 12, 3))

    def poses(self, q: FloatArray) -> FloatArray:
        """Poses of all joint frames, states last, so that what follows runs over contiguous numbers.

        Args:
            q: (m, n) joint values in [rad] or [m].

        Returns:
            (n + 1, 3, 4, m) rotations beside translations in the base; index 0 is the base itself.
        """
        count, compiled = len(q), kernels()
        if compiled is not None:
            states, found = np.ascontiguousarray(q, dtype=float), np.empty((self.size + 1, 3, 4, count))
            given = address(self.terms), address(self.revolute), self.size, address(states), count
            compiled.chain_poses(*given, address(found))
            return found
        values = np.ascontiguousarray(q.T, dtype=float)
        weights = np.ones((self.size, 3, count))
        weights[:, 1] = np.where(self.revolute[:, None], np.cos(values), values)
        weights[:, 2] = np.sin(values)
        local = np.matmul(self.terms, weights).reshape(self.size, 3, 4, count)
        poses = np.empty((self.size + 1, 3, 4, count))
        poses[0] = np.eye(3, 4)[:, :, None]
        poses[1] = local[0]
        for k in range(1, self.size):
            np.einsum("ijm,jkm->ikm", poses[k, :, :3], local[k], out=poses[k + 1])
            poses[k + 1, :, 3] += poses[k, :, 3]
        return poses

    def jacobian(self, frames: FloatArray, points: FloatArray) -> FloatArray:
        """Jacobians of points carried by the last frame.

        Args:
            frames: (m, n + 1, 4, 4) as returned by `frames`.
            points: (m, 3) in the base frame.

        Returns:
            (m, 6, n): linear velocity of the point above angular velocity of the frame.
        """
        axes = np.matmul(frames[:, 1:, :3, :3], self.axes[:, :, None])[..., 0]
        arms = points[:, None, :] - frames[:, 1:, :3, 3]
        turning = self.revolute[:, None]
        linear = np.where(turning, cross(axes, arms), axes)
        angular = np.where(turning, axes, 0.0)
        return np.concatenate([linear, angular], axis=2).transpose(0, 2, 1)


def driven_joints(
    model: Model, tool_frame: str, named: str
) -> tuple[tuple[Joint, ...], tuple[FloatArray, ...]]:
    """Find the joints that move a link, base first, each with its pose in the one before, as `Chain.of` asks.

    Raises:
        InvalidInput: There are none; `named` is what the message calls the model.
    """
    joints: list[Joint] = []
    before: list[FloatArray] = []
    fixed = np.eye(4)
    for joint in model.path_to(tool_frame):
        fixed = fixed @ joint.pose_child_to_parent
        if joint.kind != "fixed":
            joints.append(joint)
            before.append(fixed)
            fixed = np.eye(4)
    if not joints:
        raise InvalidInput(f"{named}: no joint moves {tool_frame!r}: expected an arm, with joints that move")
    return tuple(joints), tuple(before)


def _joint_terms(joint: Joint) -> tuple[FloatArray, FloatArray, FloatArray]:
    constant, cosine, sine = np.eye(4), np.zeros((4, 4)), np.zeros((4, 4))
    x, y, z = joint.axis
    if joint.kind == "prismatic":
        cosine[:3, 3] = joint.axis
        return constant, cosine, sine
    along = np.outer(joint.axis, joint.axis)
    constant[:3, :3] = along  # Rodrigues: R = a a^T + cos q (I - a a^T) + sin q [a]x
    cosine[:3, :3] = np.eye(3) - along
    sine[:3, :3] = [[0, -z, y], [z, 0, -x], [-y, x, 0]]
    return constant, cosine, sine


def rotation_vectors(rotations: FloatArray) -> FloatArray:
    """Axis times angle of rotation matrices.

    Args:
        rotations: (m, 3, 3).

    Returns:
        (m, 3) in [rad], angles up to pi.
    """
    r = rotations
    twice = np.stack([r[:, 2, 1] - r[:, 1, 2], r[:, 0, 2] - r[:, 2, 0], r[:, 1, 0] - r[:, 0, 1]], axis=1)
    sine = np.linalg.norm(twice, axis=1) / 2
    cosine = (np.trace(r, axis1=1, axis2=2) - 1) / 2
    angle = np.arctan2(sine, cosine)
    vectors = twice * (angle / np.maximum(2 * sine, 1e-12))[:, None]
    # near pi the antisymmetric part vanishes; the axis is then the largest column of R + I
    for i in np.flatnonzero((sine < 1e-6) & (cosine < 0)):
        column = np.argmax(np.diag(r[i]))
        axis = r[i, :, column] + np.eye(3)[column]
        vectors[i] = axis / np.linalg.norm(axis) * angle[i]
    return vectors


def joint_value(joint: Joint, values: Mapping[str, float]) -> float:
    """Value of a joint: the given one, that of the joint it mimics, or 0 [rad] or [m]."""
    if joint.name in values:
        return values[joint.name]
    if joint.mimic is not None and joint.mimic.joint in values:
        return joint.mimic.multiplier * values[joint.mimic.joint] + joint.mimic.offset
    return 0.0


def pose_of_joint(joint: Joint, value: float) -> FloatArray:
    """Pose (4, 4) of a joint's child link in its parent at a value in [rad] or [m]."""
    if joint.kind == "fixed":
        return joint.pose_child_to_parent
    chain = Chain.of(
        (joint,), (joint.pose_child_to_parent,), np.array([joint.lower]), np.array([joint.upper])
    )
    return chain.frames(np.array([[value]]))[0, 1]
