"""Rigid poses as 4x4 matrices, to and from PyBullet's position and quaternion."""

import math
from collections.abc import Sequence

import numpy as np
from scipy.spatial.transform import Rotation

from topple.topology.base.arrays import FloatArray, round_off


def pose_from(position: Sequence[float], quaternion: Sequence[float]) -> FloatArray:
    """(4, 4) pose from a position (3,) in [m] and a quaternion (4,), x y z w.

    A simulated arm asks for poses in every time step, and scipy takes ten times as long for one quaternion.
    """
    x, y, z, w = quaternion
    size = math.sqrt(x * x + y * y + z * z + w * w)
    x, y, z, w = x / size, y / size, z / size, w / size
    xx, yy, zz, ww = x * x, y * y, z * z, w * w
    xy, zw, xz, yw, yz, xw = x * y, z * w, x * z, y * w, y * z, x * w
    a, b, c = position
    return np.array(
        [
            [xx - yy - zz + ww, 2 * (xy - zw), 2 * (xz + yw), a],
            [2 * (xy + zw), -xx + yy - zz + ww, 2 * (yz - xw), b],
            [2 * (xz - yw), 2 * (yz + xw), -xx - yy + zz + ww, c],
            [0.0, 0.0, 0.0, 1.0],
        ]
    )


def position_and_quaternion(pose: FloatArray) -> tuple[list[float], list[float]]:
    """Position (3,) [m] and quaternion (4,), x y z w, of a (4, 4) pose, for engines, by `round_off`."""
    return round_off(pose[:3, 3]).tolist(), round_off(Rotation.from_matrix(pose[:3, :3]).as_quat()).tolist()


def inverse(pose: FloatArray) -> FloatArray:
    """(4, 4) inverse of a rigid pose."""
    turned = np.eye(4)
    turned[:3, :3] = pose[:3, :3].T
    turned[:3, 3] = -pose[:3, :3].T @ pose[:3, 3]
    return turned


def angle_between(a: FloatArray, b: FloatArray) -> float:
    """Angle in [rad] of the rotation from pose a to pose b, both (4, 4)."""
    return float(Rotation.from_matrix(a[:3, :3].T @ b[:3, :3]).magnitude())


def looking_at(
    eye: Sequence[float] | FloatArray,
    target: Sequence[float] | FloatArray,
    up: Sequence[float] | FloatArray = (0.0, 0.0, 1.0),
) -> FloatArray:
    """(4, 4) pose of a camera at a place that looks at another one: x right, y down, z forward.

    Args:
        eye: (3,) where it is [m].
        target: (3,) what is in the middle of its picture [m], another place.
        up: (3,) what points up in the picture; another direction is taken if it is the viewing direction.
    """
    forward = np.subtract(target, eye)
    forward = forward / np.linalg.norm(forward)
    right = np.cross(forward, up)
    if np.linalg.norm(right) < 1e-3:
        right = np.cross(forward, [0.0, 1.0, 0.0] if abs(forward[1]) < 0.9 else [1.0, 0.0, 0.0])
    right /= np.linalg.norm(right)
    pose = np.eye(4)
    pose[:3, :3] = np.stack([right, np.cross(forward, right), forward], axis=1)
    pose[:3, 3] = eye
    return pose
