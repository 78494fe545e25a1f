import numpy as np
import pytest

from topple.robots.arm.gripper import ToolState
from topple.robots.catalog import names, robot
from topple.topology.base.errors import InvalidInput


@pytest.mark.parametrize("name", names())
def test_every_arm_is_complete(name):
    arm = robot(name)
    assert arm.name == name
    assert (arm.lower < arm.upper).all()
    assert (arm.velocity > 0).all()
    assert (arm.acceleration > 0).all()
    assert ((arm.home >= arm.lower) & (arm.home <= arm.upper)).all()
    assert len(arm.links) == len(arm.parts)
    assert arm.jaw is not None
    assert robot(name) is arm


def test_an_unknown_name_lists_the_known_ones():
    with pytest.raises(
        InvalidInput, match=r"'pander': did you mean 'panda'\? expected panda, panda-suction, iiwa, xarm6"
    ):
        robot("pander")


def test_the_cup_stands_out_beyond_the_fingers_and_goes_back_behind_them():
    arm = robot("panda-suction")
    cup = arm.cup
    assert cup is not None
    assert cup.max_force == pytest.approx(42.4, abs=0.1)

    def ends(extension: float) -> tuple[float, float]:
        poses = arm.forward(arm.home, ToolState(0.08, extension))[0]
        approach = arm.tool_pose(arm.home)[0, :3, 2]

        def end(link: str) -> float:
            i = arm.links.index(link)
            return float(((np.vstack(arm.parts[i]) @ poses[i, :3, :3].T + poses[i, :3, 3]) @ approach).max())

        return end("suction_cup"), end("panda_leftfinger")

    out, tips = ends(cup.stroke)
    drawn_in, _ = ends(0.0)
    assert out - tips == pytest.approx(0.020, abs=1e-3)
    assert drawn_in < tips - 0.04


def test_the_suction_frame_lies_on_the_extended_lip():
    arm = robot("panda-suction")
    cup = arm.cup
    assert cup is not None
    link = arm.links.index("suction_cup")
    lip = arm.forward(arm.home, ToolState(0.08, cup.stroke))[0, link]
    assert np.abs(lip - arm.tool_pose(arm.home, "suction")[0]).max() < 1e-9


def test_the_cup_passes_between_open_fingers():
    arm = robot("panda-suction")
    cup = arm.cup
    assert cup is not None
    poses = arm.forward(arm.home, ToolState(0.08, cup.stroke))[0]
    closing = arm.tool_pose(arm.home)[0, :3, 1]

    def extent(link: str) -> tuple[float, float]:
        i = arm.links.index(link)
        along = (np.vstack(arm.parts[i]) @ poses[i, :3, :3].T + poses[i, :3, 3]) @ closing
        return float(along.min()), float(along.max())

    cup_low, cup_high = extent("suction_cup")
    sides = sorted([extent("panda_leftfinger"), extent("panda_rightfinger")])
    assert sides[0][1] < cup_low - 0.01
    assert sides[1][0] > cup_high + 0.01


def test_an_arm_and_a_hand_come_by_the_names_of_urdfs_that_packages_ship():
    airo = pytest.importorskip("airo_models", reason="airo-models belongs to the arms extra")
    named = robot("ur5e", "robotiq_2f_85")
    by_path = robot(airo.get_urdf_path("ur5e"), airo.get_urdf_path("robotiq_2f_85"))
    assert named.joints == by_path.joints and len(named.joints) == 6
    (tool,) = named.tools.values()
    assert tool.gripper.max_opening == pytest.approx(0.086, abs=0.002)
    for wrong in ("ur99", "../ur5e", "ur5*"):
        with pytest.raises(InvalidInput, match=r"unknown robot .*airo-models or example-robot-data"):
            robot(wrong)
