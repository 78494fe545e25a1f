import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from topple.robots.arm.cup import SuctionCup, lip_plane
from topple.robots.arm.gripper import ToolState
from topple.robots.catalog import names, robot


@pytest.mark.parametrize("name", names())
@given(share=st.floats(0.0, 1.0))
def test_opening_and_joint_values_are_inverse(name, share):
    jaw = robot(name).jaw
    assert jaw is not None
    opening = jaw.openings[0] + share * (jaw.max_opening - jaw.openings[0])
    assert jaw.opening(jaw.values(ToolState(opening))) == pytest.approx(opening, abs=1e-9)


@pytest.mark.parametrize("name", names())
def test_finger_links_move_along_the_closing_direction(name):
    arm = robot(name)
    jaw = arm.jaw
    assert jaw is not None
    tool = arm.tools["fingers"]
    q = arm.home
    to_tool = np.linalg.inv(arm.tool_pose(q)[0])
    index = [arm.links.index(link) for link in jaw.links]

    def middles(opening: float) -> np.ndarray:
        poses = arm.forward(q, ToolState(opening))[0, index]
        centres = [
            pose[:3, :3] @ np.vstack(arm.parts[i]).mean(axis=0) + pose[:3, 3]
            for i, pose in zip(index, poses, strict=True)
        ]
        return np.array([to_tool[:3, :3] @ c + to_tool[:3, 3] for c in centres])

    shut, wide = middles(float(jaw.openings[0])), middles(jaw.max_opening)
    moved = wide - shut
    assert tool.name == "fingers"
    assert np.sign(moved[0, 1]) == -np.sign(moved[1, 1])
    assert abs(abs(moved[:, 1]).sum() - (jaw.max_opening - jaw.openings[0])) < 0.004
    assert np.abs(moved[:, 0]).max() < 1e-6


@pytest.mark.parametrize("name", names())
def test_tips_are_as_far_beyond_the_pads_at_every_opening(name):
    arm = robot(name)
    jaw, tool = arm.jaw, arm.tools["fingers"]
    assert jaw is not None
    ends = list[float]()
    for opening in np.linspace(jaw.openings[0], jaw.max_opening, 9):
        to_pads = np.linalg.inv(arm.tool_pose(arm.home)[0] @ tool.pads(float(opening)))
        poses = arm.forward(arm.home, ToolState(float(opening)))[0]
        fingers = [(to_pads @ poses[i], arm.parts[i]) for i in map(arm.links.index, jaw.links)]
        tips = [(np.vstack(parts) @ pose[2, :3]).max() + pose[2, 3] for pose, parts in fingers]
        ends += tips
    assert ends[0] > 0.005, "they reach beyond the pads' centres"
    assert np.ptp(ends) < 5e-4
    slides = name != "xarm6"
    assert (tool.pads(0.0) == np.eye(4)).all() == slides, "only a linkage swings its pads"


def test_beyond_its_stroke_a_jaw_stays_at_the_end():
    jaw = robot("panda").jaw
    assert jaw is not None
    assert jaw.values(ToolState(1.0)) == jaw.values(jaw.limits)
    assert jaw.values(ToolState(-1.0)) == jaw.values(ToolState())


def test_a_fixed_cup_has_no_joint_and_a_retractable_one_is_clipped():
    assert SuctionCup("cup", None, 0.0, 0.015, 42.0).values(ToolState(0.0, 0.1)) == {}
    assert SuctionCup("cup", "push", 0.05, 0.015, 42.0).values(ToolState(0.0, 0.1)) == {"push": 0.05}


def test_a_lip_follows_a_slope_and_has_to_bridge_what_no_plane_has():
    turn = np.arange(16) * np.pi / 8
    ring = 0.015 * np.column_stack([np.cos(turn), np.sin(turn)])
    slope = 0.001 + ring @ np.array([0.1, -0.2])
    plane, uneven = lip_plane(ring, slope)
    np.testing.assert_allclose(plane, [0.1, -0.2, 0.001], atol=1e-12)
    assert uneven < 1e-12
    _, uneven = lip_plane(ring, slope + 0.003 * np.cos(2 * turn))  # a saddle
    assert uneven == pytest.approx(0.003)
