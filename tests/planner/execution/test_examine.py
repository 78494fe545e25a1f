"""Arms of fewer than six joints, tried: the table is where their hand gets to."""

import numpy as np
import pytest
from few_joints import written

from topple.planner import plan
from topple.planner.execution.examine import examine
from topple.planner.execution.trial import trial
from topple.robots.catalog import robot

pytest.importorskip("pybullet")


@pytest.mark.parametrize("name", ["scara", pytest.param("gantry", marks=pytest.mark.slow)])
def test_an_arm_that_only_points_down_has_a_verified_plan(name, tmp_path):
    arm = robot(written(name, tmp_path))
    tried = trial(arm, "fingers")
    assert tried is not None
    scene = tried.scene()
    found = plan(scene, [tried.name], arm, pose_base_to_world=np.eye(4))
    assert found.certified and found.verify(scene).ok


@pytest.mark.slow
@pytest.mark.parametrize("name", ["scara", "gantry"])
def test_it_takes_the_block_by_friction_from_what_cameras_see(name, tmp_path):
    found = examine(robot(written(name, tmp_path)))
    assert found.solved == found.poses > 0
    assert found.grasped is not None and found.grasped.success, found.grasped
    assert found.ok
