"""Inverse kinematics of arms that reach next to no pose exactly."""

from pathlib import Path

import numpy as np
import pytest
from few_joints import written
from scipy.spatial.transform import Rotation

from topple.robots.catalog import robot
from topple.robots.poses import angle_between


@pytest.mark.parametrize("name", ["scara", "gantry"])
def test_an_arm_of_four_joints_comes_as_near_as_it_can(name: str, tmp_path: Path) -> None:
    arm = robot(written(name, tmp_path))
    pose = arm.tool_pose(np.array([0.1, 0.2, 0.1, 0.3]))[0]
    for tilt, reached in ((0.0, True), (0.03, True), (0.1, False)):
        wanted = pose.copy()
        wanted[:3, :3] = Rotation.from_euler("x", tilt).as_matrix() @ pose[:3, :3]
        (states,) = arm.inverse(wanted)
        assert (len(states) > 0) == reached
        assert arm.reaches(wanted[None, None])[0] == reached
        for at in arm.tool_pose(states) if reached else ():
            assert np.linalg.norm(at[:3, 3] - wanted[:3, 3]) < 1e-4
            assert angle_between(at, wanted) == pytest.approx(tilt, abs=1e-3)
