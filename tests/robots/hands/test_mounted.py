"""A hand with a URDF of its own on the flange of an arm."""

import sys
from pathlib import Path

import numpy as np
import pytest

from topple.planner.formats.plan_robot import arm_data, arm_from
from topple.robots.arm.gripper_file import GripperFile, Hand
from topple.robots.arm.jaw import ParallelJaw
from topple.robots.catalog import robot
from topple.topology.base.errors import InvalidInput

sys.path.insert(0, str(Path(__file__).parents[1] / "catalog"))
from own_urdf import linked, written


def hand(folder: Path) -> Path:
    """Two sliding fingers on a palm; its link `link0` is called as one of the arm's."""
    text = "<robot name='hand'>" + linked("link0", "<box size='0.08 0.1 0.04'/>", "0 0 0.02")
    for side, sign in (("left", 1), ("right", -1)):
        text += linked(side, "<box size='0.02 0.01 0.06'/>", f"0 {0.005 * sign} 0.03")
        text += f"<joint name='{side}_slide' type='prismatic'><parent link='link0'/><child link='{side}'/>"
        text += f"<origin xyz='0 0 0.04'/><axis xyz='0 {sign} 0'/>"
        text += "<limit lower='0' upper='0.03' velocity='0.1' effort='40'/></joint>"
    (folder / "hand.urdf").write_text(text + "</robot>")
    return folder / "hand.urdf"


def test_a_hand_is_mounted_on_tool0_and_measured(tmp_path):
    arm = robot(written(tmp_path), hand(tmp_path))
    tool = arm.tools["fingers"]
    jaw = tool.gripper
    assert isinstance(jaw, ParallelJaw)
    assert jaw.max_opening == pytest.approx(0.06) and jaw.force == pytest.approx(40.0)
    assert len(arm.joints) == 6
    pads = arm.tool_pose(arm.home)[0]
    flange = arm.forward(arm.home)[0, arm.links.index("tool0")]
    relative = np.linalg.inv(flange) @ pads
    assert relative[:2, 3] == pytest.approx([0.0, 0.0], abs=1e-6)
    assert 0.07 < relative[2, 3] < 0.1  # in the outer part of fingers from 0.04 to 0.1 m
    assert relative[2, 2] == pytest.approx(1.0)


def test_an_offset_moves_and_turns_it(tmp_path):
    path, given = written(tmp_path), tmp_path / "tool.toml"
    hand(tmp_path)
    given.write_text('[hand]\nurdf = "hand.urdf"\nlink = "tool0"\noffset = [0.1, 0, 0, 0, 1.5707963, 0]\n')
    arm = robot(path, given)
    flange = arm.forward(arm.home)[0, arm.links.index("tool0")]
    relative = np.linalg.inv(flange) @ arm.tool_pose(arm.home)[0]
    assert relative[:3, 2] == pytest.approx([1.0, 0.0, 0.0], abs=1e-6)
    assert 0.17 < relative[0, 3] < 0.2


def test_a_plan_finds_the_hand_again_but_no_other_one(tmp_path):
    arm = robot(written(tmp_path), hand(tmp_path))
    data = arm_data(arm)
    again = arm_from(data, arm.name)
    assert again.tools["fingers"].pose_tool_to_link == pytest.approx(arm.tools["fingers"].pose_tool_to_link)
    path = tmp_path / "hand.urdf"
    path.write_text(path.read_text().replace("0.03'", "0.02'"))
    with pytest.raises(InvalidInput, match=r"hand\.urdf is not the hand that was meant"):
        arm_from(data, arm.name)


def test_what_cannot_be_mounted_is_refused(tmp_path):
    path = written(tmp_path)
    with pytest.raises(InvalidInput, match=r"no\.urdf: cannot be read"):
        robot(path, tmp_path / "no.urdf")
    with pytest.raises(InvalidInput, match=r"`\$\.hand\.link` names 'flange': arm\.urdf has world, foot"):
        robot(path, GripperFile(hand=Hand(urdf=str(hand(tmp_path)), link="flange")))
    two = tmp_path / "two.urdf"
    two.write_text("<robot name='two'><link name='a'/><link name='b'/></robot>")
    with pytest.raises(InvalidInput, match=r"two\.urdf: expected one root link"):
        robot(path, two)


def test_the_hand_that_comes_with_pybullet_goes_by_its_name(tmp_path):
    arm = robot(written(tmp_path), "wsg50")
    jaw = arm.tools["fingers"].gripper
    assert isinstance(jaw, ParallelJaw) and jaw.max_opening == pytest.approx(0.104, abs=1e-3)
