"""Poses to and from PyBullet's position and quaternion."""

import numpy as np
from scipy.spatial.transform import Rotation

from topple.robots.poses import pose_from, position_and_quaternion


def test_a_quaternion_of_any_length_turns_as_scipy_has_it_to_the_last_bit():
    rng = np.random.default_rng(0)
    for quaternion in rng.normal(size=(500, 4)):
        pose = pose_from([1.0, 2.0, 3.0], quaternion.tolist())
        assert (pose[:3, :3] == Rotation.from_quat(quaternion).as_matrix()).all()
        assert pose[:3, 3].tolist() == [1.0, 2.0, 3.0]
        assert pose[3].tolist() == [0.0, 0.0, 0.0, 1.0]


def test_a_pose_comes_back_from_position_and_quaternion():
    pose = np.eye(4)
    pose[:3, :3], pose[:3, 3] = Rotation.from_rotvec([0.3, -1.2, 2.0]).as_matrix(), [0.1, -0.2, 0.3]
    np.testing.assert_allclose(pose_from(*position_and_quaternion(pose)), pose, atol=1e-15)
