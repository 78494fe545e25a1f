"""Rigid poses as 4x4 matrices, to and from PyBullet's position and quaternion."""

from collections.abc import Sequence

import numpy as np
from scipy.spatial.transform import Rotation

from topple.topology.arrays import FloatArray


def pose_from(position: Sequence[float], quaternion: Sequence[float]) -> FloatArray:
    """(4, 4) pose from a position (3,) in [m] and a quaternion (4,), x y z w."""
    pose = np.eye(4)
    pose[:3, :3] = Rotation.from_quat(quaternion).as_matrix()
    pose[:3, 3] = position
    return pose


def position_and_quaternion(pose: FloatArray) -> tuple[list[float], list[float]]:
    """Position (3,) in [m] and quaternion (4,), x y z w, of a (4, 4) pose."""
    return pose[:3, 3].tolist(), Rotation.from_matrix(pose[:3, :3]).as_quat().tolist()


def inverse(pose: FloatArray) -> FloatArray:
    """(4, 4) inverse of a rigid pose."""
    turned = np.eye(4)
    turned[:3, :3] = pose[:3, :3].T
    turned[:3, 3] = -pose[:3, :3].T @ pose[:3, 3]
    return turned


def angle_between(a: FloatArray, b: FloatArray) -> float:
    """Angle in [rad] of the rotation from pose a to pose b, both (4, 4)."""
    return float(Rotation.from_matrix(a[:3, :3].T @ b[:3, :3]).magnitude())
