"""A jaw of which one finger turns against a fixed one: measured on a URDF of boxes, and used."""

import sys
from itertools import combinations
from pathlib import Path

import numpy as np
import pytest

from topple.robots.arm.gripper import ToolState
from topple.robots.arm.hinged import HingedJaw
from topple.robots.arm.tolerances import BESIDE
from topple.robots.catalog import robot

sys.path.insert(0, str(Path(__file__).parents[1] / "catalog"))
from own_urdf import linked, written

GAP = 0.02  # between the hinge and the fixed finger's face [m]
PALM = (
    "<link name='palm'>"
    "<collision><origin xyz='0 0 0.005'/><geometry><box size='0.04 0.06 0.01'/></geometry></collision>"
    f"<collision><origin xyz='0 {-GAP - 0.005} 0.055'/><geometry><box size='0.02 0.01 0.09'/></geometry>"
    "</collision></link>"
    "<joint name='palm_fixed' type='fixed'><parent link='tool0'/><child link='palm'/></joint>"
)
HINGE = (
    "<joint name='turn' type='revolute'><parent link='palm'/><child link='turned'/><origin xyz='0 0 0.02'/>"
    "<axis xyz='-1 0 0'/><limit lower='0' upper='1.4' effort='3'/></joint>"
)


def _hinged(folder: Path, finger: str = "0.02 0.01 0.08", middle: str = "0 0.005 0.04") -> Path:
    """The arm of boxes with a finger on its palm, and one that turns away from it."""
    path = written(folder)
    turned = linked("turned", f"<box size='{finger}'/>", middle)
    path.write_text(path.read_text().replace("<drake:tag/>", PALM + turned + HINGE + "<drake:tag/>"))
    return path


def test_a_finger_that_turns_against_a_fixed_one_is_a_jaw(tmp_path):
    arm = robot(_hinged(tmp_path))
    tool = arm.tools["fingers"]
    jaw = tool.gripper
    assert isinstance(jaw, HingedJaw)
    assert arm.joints == tuple(f"j{k}" for k in range(6)) and jaw.joints == ("turn",)
    assert jaw.links == ("turned", "palm")
    pose = tool.pose_tool_to_link  # on the fixed finger's face, y towards the other one
    assert pose[1, 3] == pytest.approx(-GAP, abs=1e-6)
    assert pose[:3, :3] == pytest.approx(np.eye(3), abs=1e-9)
    assert jaw.force == pytest.approx(3.0 / (pose[2, 3] - 0.02))  # a torque on its lever
    assert jaw.pads(0.03)[:3, 3] == pytest.approx([0.0, 0.015 + BESIDE, 0.0])


def test_openings_are_how_near_the_turned_finger_is_to_the_face_of_the_fixed_one(tmp_path):
    arm = robot(_hinged(tmp_path))
    jaw = arm.jaw
    assert jaw is not None
    assert jaw.openings[0] == pytest.approx(GAP, abs=1e-4)  # parallel as they are shut
    to_tool = np.linalg.inv(arm.tool_pose(arm.home)[0])
    index = arm.links.index("turned")
    (part,) = arm.parts[index]
    share = np.linspace(0.0, 1.0, 400)[:, None]
    edges = np.concatenate([a + share * (b - a) for a, b in combinations(part, 2)])
    for opening in np.linspace(jaw.openings[0], jaw.max_opening, 5):
        pose = to_tool @ arm.forward(arm.home, ToolState(float(opening)))[0, index]
        points = edges @ pose[:3, :3].T + pose[:3, 3]
        beside = points[points[:, 2] >= -jaw.pad_size[1] / 2.0]
        assert beside[:, 1].min() == pytest.approx(opening, abs=1e-3)
    assert jaw.max_opening > 0.045


def test_a_link_that_turns_beside_none_is_a_wrist(tmp_path):
    path = _hinged(tmp_path)
    path.write_text(path.read_text().replace(f"xyz='0 {-GAP - 0.005} 0.055'", "xyz='0 0 -0.055'"))
    assert not robot(path).tools


@pytest.mark.slow
def test_an_arm_of_five_joints_with_a_hinged_jaw_takes_a_block():
    from topple.planner.execution.examine import examine
    from topple.robots.catalog.described import find_urdf

    if find_urdf("so100") is None:
        pytest.skip("example-robot-data belongs to the arms extra")
    arm = robot("so100")
    assert len(arm.joints) == 5 and isinstance(arm.jaw, HingedJaw)
    found = examine(arm)
    assert found.ok and found.grasped is not None and found.grasped.success, found.grasped
