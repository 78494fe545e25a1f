import sys
from pathlib import Path

import numpy as np

from topple.planner.motion.cartesian import straight_lines
from topple.robots.catalog import robot

sys.path.insert(0, str(Path(__file__).parent))
from scenes import densely, top_down


def test_the_tool_stays_on_the_line_between_the_waypoints_too():
    arm = robot("panda")
    start = arm.inverse(top_down(0.5, 0.1, 0.1, 0.3))[0][0]
    goal = top_down(0.5, 0.1, 0.25, 0.3)
    (path,) = straight_lines(arm, start[None], goal[None])
    assert path is not None
    assert np.abs(arm.tool_pose(path[-1])[0] - goal).max() < 1e-5
    poses = arm.tool_pose(densely(path, 0.005))
    assert np.abs(poses[:, :2, 3] - goal[:2, 3]).max() < 2e-4
    assert np.abs(poses[:, :3, :3] - goal[:3, :3]).max() < 2e-3


def test_the_tool_turns_evenly_on_the_way():
    arm = robot("panda")
    start = arm.inverse(top_down(0.5, 0.0, 0.2, 0.0))[0][0]
    goal = top_down(0.5, 0.1, 0.2, 0.6)
    (path,) = straight_lines(arm, start[None], goal[None])
    assert path is not None
    yaws = np.arctan2(arm.tool_pose(path)[:, 1, 0], arm.tool_pose(path)[:, 0, 0])
    steps = np.diff(np.unwrap(yaws))
    assert np.ptp(np.abs(steps)) < 1e-3


def test_beyond_reach_there_is_no_line():
    arm = robot("panda")
    start = arm.inverse(top_down(0.5, 0.0, 0.3))[0][0]
    assert straight_lines(arm, start[None], top_down(1.5, 0.0, 0.3)[None]) == [None]
