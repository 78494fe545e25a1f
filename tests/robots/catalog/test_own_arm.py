"""Arms from a URDF of one's own: jaws recognised, cups added, nothing left to PyBullet's guesses."""

import os
import pickle
import re
import sys
from pathlib import Path

import numpy as np
import pybullet
import pytest

from topple.planner.motion.collision import Checker
from topple.robots.arm.arm import Arm
from topple.robots.arm.cup import SuctionCup
from topple.robots.arm.gripper import ToolState
from topple.robots.arm.gripper_file import Cup, GripperFile, Jaw
from topple.robots.arm.jaw import ParallelJaw
from topple.robots.catalog import data_path, robot
from topple.robots.catalog.own_arm import check_tool
from topple.robots.world.simulated_arm import SimulatedArm
from topple.robots.world.world import World
from topple.topology.base.errors import InvalidInput

sys.path.insert(0, str(Path(__file__).parent))
from own_urdf import linked, written

PANDA = data_path() / "franka_panda" / "panda.urdf"
XARM = data_path() / "xarm" / "xarm6_with_gripper.urdf"
CUPPED = '[cup]\nlink = "tool0"\noffset = [0,0,0.1]\nradius = '
CUP = Cup(link="tool0", offset=[0.0, 0.0, 0.08], radius=0.015)


@pytest.mark.parametrize(
    ("path", "name", "off"),
    [(PANDA, "panda", 0.001), (XARM, "xarm6", 0.009), (robot("iiwa").urdf, "iiwa", 0.011)],
)
def test_a_jaw_is_recognised_as_the_catalog_has_it_from_data_sheets(path, name, off):
    found, known = robot(path).tools["fingers"], robot(name).tools["fingers"]
    jaw, other = found.gripper, known.gripper
    assert isinstance(jaw, ParallelJaw) and isinstance(other, ParallelJaw)
    assert found.link == known.link
    assert set(jaw.joints) == set(other.joints)
    assert set(jaw.links) == set(other.links)
    assert np.abs(found.pose_tool_to_link[:3, 3] - known.pose_tool_to_link[:3, 3]).max() < off
    assert found.pose_tool_to_link[:3, 2] @ known.pose_tool_to_link[:3, 2] == pytest.approx(1.0)
    assert abs(found.pose_tool_to_link[:3, 1] @ known.pose_tool_to_link[:3, 1]) == pytest.approx(1.0)
    assert jaw.max_opening == pytest.approx(other.max_opening, abs=1e-3)
    for opening in np.linspace(0.1, 0.9, 5) * other.max_opening:
        values, wanted = jaw.values(ToolState(opening)), other.values(ToolState(opening))
        assert all(abs(values[joint] - wanted[joint]) < 0.01 for joint in values)


def test_fingers_with_pads_fixed_to_them_become_one_body_each(tmp_path):
    arm = robot(written(tmp_path, fingers=True))
    tool = arm.tools["fingers"]
    jaw = tool.gripper
    assert isinstance(jaw, ParallelJaw)
    assert set(jaw.links) == {"left", "right"}
    assert jaw.openings[[0, -1]] == pytest.approx([0.0, 0.08], abs=1e-6)  # pads stand 2 mm before the fingers
    assert tool.pose_tool_to_link[:3, 3] == pytest.approx([0.0, 0.0, 0.07], abs=0.003)
    assert arm.parts[arm.links.index("left_pad")] == ()
    assert np.vstack(arm.parts[arm.links.index("left")])[:, 1].min() == pytest.approx(-0.002)


def test_a_urdf_that_says_little_makes_an_arm_and_says_what_was_assumed(tmp_path):
    arm = robot(written(tmp_path), gripper=CUP)
    assert arm.upper == pytest.approx([2.6, 2.6, 2.6, 2 * np.pi, 2.6, 2 * np.pi])
    assert (arm.velocity > 0).all()
    words = "; ".join(arm.assumptions)
    for what in ("no masses", "no velocity limits", "no efforts", "no accelerations"):
        assert what in words
    assert arm.source == (tmp_path / "my_arm" / "arm.urdf").resolve()
    assert pickle.loads(pickle.dumps(arm)).home == pytest.approx(arm.home)


def test_home_has_the_hand_in_front_pointing_down_and_free(tmp_path):
    for arm in (robot(written(tmp_path), gripper=CUP), robot(PANDA), robot(XARM)):
        tool = next(iter(arm.tools))
        pose = arm.tool_pose(arm.home, tool)[0]
        assert pose[2, 2] < -0.99
        assert pose[0, 3] > 0.15 and abs(pose[1, 3]) < 0.05
        assert ((arm.home >= arm.lower) & (arm.home <= arm.upper)).all()
        assert Checker(arm, np.eye(4), {}).free(arm.home)[0]


def test_pybullet_loads_what_was_read(tmp_path):
    arm = robot(written(tmp_path, fingers=True), gripper=CUP)
    client = pybullet.connect(pybullet.DIRECT)
    try:
        body = pybullet.loadURDF(str(arm.urdf), useFixedBase=True, physicsClientId=client)
        state = ToolState(0.05, 0.01)
        values = arm.joint_values(arm.home, state)
        infos = [
            pybullet.getJointInfo(body, j, physicsClientId=client)
            for j in range(pybullet.getNumJoints(body, physicsClientId=client))
        ]
        for info in infos:
            pybullet.resetJointState(body, info[0], values.get(info[1].decode(), 0.0), physicsClientId=client)
        poses = arm.forward(arm.home, state)[0]
        assert len(infos) >= len(arm.joints)
        for info in infos:
            link = info[12].decode()
            found = pybullet.getLinkState(
                body, info[0], computeForwardKinematics=True, physicsClientId=client
            )
            assert found[4] == pytest.approx(poses[arm.links.index(link)][:3, 3], abs=1e-6)
            shapes = pybullet.getCollisionShapeData(body, info[0], physicsClientId=client)
            assert bool(shapes) == bool(arm.parts[arm.links.index(link)]), link
            assert (
                pybullet.getDynamicsInfo(body, info[0], physicsClientId=client)[0] < 3.0
            )  # not 1 kg a screw
    finally:
        pybullet.disconnect(client)


def test_a_cup_gives_way_when_it_is_pressed_and_comes_out_again(tmp_path):
    arm = robot(written(tmp_path), gripper=CUP)
    cup = arm.cup
    assert isinstance(cup, SuctionCup) and cup.joint is not None
    assert cup.max_force == pytest.approx(60e3 * np.pi * 0.015**2)
    assert arm.open_hand.cup_extension == cup.stroke  # a sprung plunger stands out on the way
    lip = arm.forward(arm.home)[0, arm.links.index(cup.link)]
    assert lip == pytest.approx(arm.tool_pose(arm.home, "suction")[0], abs=1e-9)
    with World() as world:
        hand = SimulatedArm(world, arm, np.eye(4))
        hand.wait(0.2)

        def extension() -> float:
            index = hand._index[cup.joint or ""]
            return float(pybullet.getJointState(hand.id, index, physicsClientId=world.client)[0])

        assert np.abs(hand.q - arm.home).max() < 5e-3
        assert extension() == pytest.approx(cup.stroke, abs=1e-3)
        at = hand.link_pose(cup.link)[:3, 3]
        shape = pybullet.createCollisionShape(
            pybullet.GEOM_BOX, halfExtents=[0.1, 0.1, 0.05], physicsClientId=world.client
        )
        slab = pybullet.createMultiBody(
            0.0, shape, basePosition=[at[0], at[1], at[2] - 0.05 + 0.008], physicsClientId=world.client
        )
        hand.wait(0.5)
        assert 0.004 < extension() < cup.stroke - 0.005
        pybullet.removeBody(slab, physicsClientId=world.client)
        hand.wait(0.5)
        assert extension() == pytest.approx(cup.stroke, abs=1e-3)


def test_without_a_tool_the_arm_is_there_and_the_refusal_can_be_used_as_it_stands(tmp_path):
    path = written(tmp_path)
    arm = robot(path)
    assert arm.tools == {}
    with pytest.raises(InvalidInput, match=r"arm.urdf: beyond 'j5', .* no finger moves, so") as refusal:
        check_tool(arm)
    words = str(refusal.value)
    line = words[words.index("cup = ") : words.index("}") + 1]
    (tmp_path / "tool.toml").write_text(line)
    assert set(robot(path, gripper=tmp_path / "tool.toml").tools) == {"suction"}


def test_what_the_file_gives_goes_before_what_is_measured(tmp_path):
    (tmp_path / "jaw.toml").write_text(
        '[jaw]\njoints = ["panda_finger_joint1"]\nlinks = ["panda_leftfinger", "panda_rightfinger"]\n'
        "closed = [0.0]\nopen = [0.03]\nopening = [0, 0.06]\nforce = 35\npads = [0.02, 0.018]\n"
        'link = "panda_link8"\noffset = [0, 0, 0.1034, 0, 0, -0.785398]\n'
    )
    tool = robot(PANDA, gripper=tmp_path / "jaw.toml").tools["fingers"]
    jaw = tool.gripper
    assert isinstance(jaw, ParallelJaw)
    assert (tool.link, jaw.force, jaw.pad_size, jaw.max_opening) == ("panda_link8", 35.0, (0.02, 0.018), 0.06)
    assert jaw.values(ToolState(0.06)) == pytest.approx(
        {"panda_finger_joint1": 0.03, "panda_finger_joint2": 0.03}
    )
    measured = robot(PANDA, gripper=Jaw(joints=["panda_finger_joint1"], link="panda_link8")).tools["fingers"]
    assert measured.pose_tool_to_link[:3, 3] == pytest.approx([0.0, 0.0, 0.1], abs=0.006)


def test_a_cup_beside_recognised_fingers_is_drawn_in_on_the_way():
    arm = robot(
        PANDA, gripper=GripperFile(cup=Cup(link="panda_hand", offset=[0, 0, 0.13], radius=0.012, stroke=0.07))
    )
    assert list(arm.tools) == ["fingers", "suction"]
    assert arm.open_hand.cup_extension == 0.0
    assert arm.tools["suction"].ready.opening == arm.jaw.max_opening if arm.jaw else False


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("", "no tool in it: write"),
        ("[cup", "not TOML"),
        pytest.param("a = " + "[" * 9999, "not TOML", id="nested without end"),
        pytest.param("a = " + "9" * 9999, "not TOML", id="a number without end"),
        pytest.param("a." * 99999 + "b = 1", "more than 32768 bytes", id="a key without end"),
        ("[clamp]\nforce = 3", "unknown field `clamp`"),
        ('[cup]\nlink = "tool0"\nradius = 0.01', "missing required field `offset` - at `$.cup`"),
        (CUPPED + '"wide"', "Expected `float`, got `str` - at `$.cup.radius`"),
        (CUPPED + "-1", "`$.cup.radius` is -1.0, expected"),
        (CUPPED + "nan", "`$.cup.radius` is nan, expected"),
        (CUPPED.replace("0,0.1", "0") + "0.01", "`$.cup.offset` is [0.0, 0.0], expected 3 or 6"),
        (CUPPED + "0.01\nsize = 1", "unknown field `size` - at `$.cup`"),
        (CUPPED.replace("tool0", "hand") + "0.01", "`$.cup.link` names 'hand': arm.urdf has world,"),
        ('[jaw]\njoints = ["grip"]', "`$.jaw.joints` names 'grip': arm.urdf moves j0,"),
        ('[jaw]\njoints = ["left_slide"]\nlinks = ["left"]', "`$.jaw.links` is ['left'], expected the two"),
        ('[jaw]\njoints = ["left_slide"]\nlinks = ["left", "link2"]', "do not move 'link2'"),
        (
            '[jaw]\njoints = ["left_slide", "right_slide"]\nopening = [0.1, 0.0]',
            "expected 0 <= closed < open",
        ),
        ('[jaw]\njoints = ["left_slide", "right_slide"]\nopen = [0.0]', "`$.jaw.open` is [0.0], expected 2"),
        ('[jaw]\njoints = ["left_slide"]', "'left' alone, which closes on nothing that moves: add the other"),
    ],
)
def test_a_bad_gripper_file_is_refused_in_one_line_by_its_path(tmp_path, text, words):
    place = tmp_path / "tool.toml"
    place.write_text(text)
    with pytest.raises(InvalidInput) as refusal:
        robot(written(tmp_path, fingers=True), gripper=place)
    assert words in str(refusal.value)


def test_an_arm_of_the_catalog_takes_no_gripper_and_an_absent_file_is_named(tmp_path):
    with pytest.raises(InvalidInput, match="panda has a hand of its own"):
        robot("panda", gripper=CUP)
    with pytest.raises(InvalidInput, match=r"no\.toml: cannot be read"):
        robot(written(tmp_path), gripper=tmp_path / "no.toml")


def test_what_cannot_be_an_arm_is_refused_by_the_users_file(tmp_path):
    path = written(tmp_path)
    text = path.read_text()
    path.write_text(text.replace("package://my_arm/meshes/link2.stl", "package://elsewhere/link2.stl"))
    with pytest.raises(
        InvalidInput, match=r"arm\.urdf: missing or unreadable collision meshes: package://elsewhere"
    ):
        robot(path, gripper=CUP)
    path.write_text(text.replace("<limit lower='-2.6' upper='2.6'/>", "", 1))
    with pytest.raises(InvalidInput, match=r"arm\.urdf: joints without limits: j0"):
        robot(path, gripper=CUP)
    path.write_text(text.replace("<axis xyz='0 1 0'/>", "<axis xyz='0 1 0'/><mimic joint='j0'/>", 1))
    with pytest.raises(InvalidInput, match=r"arm\.urdf: the arm's joints j1 mimic others"):
        robot(path, gripper=CUP)
    path.write_text(
        '<robot name="r" xmlns:xacro="http://www.ros.org/wiki/xacro"><xacro:include filename="a"/></robot>'
    )
    with pytest.raises(InvalidInput, match="this is xacro"):
        robot(path)


@pytest.mark.parametrize("way", ["workspace", "ROS_PACKAGE_PATH", "AMENT_PREFIX_PATH"])
def test_meshes_of_another_package_are_found(tmp_path, monkeypatch, way):
    package = {"workspace": "src/makers/my_arm", "AMENT_PREFIX_PATH": "share/my_arm"}.get(way, "my_arm")
    written(tmp_path)
    urdf = tmp_path / "ws" / "src" / "cell" / "urdf" / "arm.urdf"
    urdf.parent.mkdir(parents=True)
    (tmp_path / "my_arm" / "arm.urdf").rename(urdf)
    place = tmp_path / ("ws" if way == "workspace" else "elsewhere") / package
    place.parent.mkdir(parents=True, exist_ok=True)
    (tmp_path / "my_arm").rename(place)
    if way != "workspace":
        with pytest.raises(InvalidInput, match=r"set ROS_PACKAGE_PATH to the folder that holds my_arm$"):
            robot(urdf, gripper=CUP)
        monkeypatch.setenv(way, f"/nowhere{os.pathsep}{tmp_path / 'elsewhere'}")
    assert robot(urdf, gripper=CUP).bodies(np.zeros(6), np.eye(4))


def test_a_joint_that_mimics_none_and_fingers_of_no_shape_are_named(tmp_path):
    path = written(tmp_path, fingers=True)
    text = path.read_text()
    path.write_text(text.replace("<axis xyz='0 -1 0'/>", "<axis xyz='0 -1 0'/><mimic joint='slide'/>"))
    with pytest.raises(InvalidInput, match=r"mimics 'slide', which is none that moves: .*j0"):
        robot(path)
    path.write_text(re.sub("(<link name='left(_pad)?'>).*?</link>", r"\1</link>", text))
    with pytest.raises(InvalidInput, match=r"has no shape, .*: add <collision> to left$"):
        robot(path)


def test_an_arm_without_velocities_made_directly_is_still_refused(tmp_path):
    with pytest.raises(InvalidInput, match="without a velocity limit"):
        Arm.from_urdf(written(tmp_path), "tool0")


def test_a_file_of_more_links_than_a_robot_has_is_refused(tmp_path):
    path = tmp_path / "swarm.urdf"
    links = "".join(f'<link name="{number}"/>' for number in range(2001))
    path.write_text(f'<robot name="r">{links}</robot>')
    with pytest.raises(InvalidInput, match="2001 links and shapes; expected those of a robot, 2000 at most"):
        robot(str(path))


def test_what_is_only_drawn_is_as_it_is_drawn_and_an_arm_without_shapes_is_refused(tmp_path):
    path = written(tmp_path)
    parts = robot(path).parts
    text = path.read_text()
    drawn = text.replace("<collision>", "<visual>").replace("</collision>", "</visual>")
    path.write_text(drawn)
    arm = robot(path)
    for before, now in zip(parts, arm.parts, strict=True):
        assert [each.tolist() for each in before] == [each.tolist() for each in now]
    (said,) = [words for words in arm.assumptions if "drawn" in words]
    assert said == (
        "links of arm.urdf that are drawn and have no collision geometry have the shapes that they are drawn "
        "with: foot, link0, link1, link2, link3, link4 and 1 more"
    )
    path.write_text(
        re.sub("<geometry>.*?</geometry>", '<geometry><mesh filename="none.stl"/></geometry>', drawn)
    )
    with pytest.raises(InvalidInput, match=r"none of its links has collision geometry, .* <collision> in"):
        robot(path)


def test_a_finger_that_closes_on_nothing_that_moves_is_no_jaw(tmp_path):
    path = written(tmp_path, fingers=True)
    text = path.read_text().replace("right_slide' type='prismatic'", "right_slide' type='fixed'")
    path.write_text(text)
    message = r"arm\.urdf: .* moved by left_slide are 'left' alone, which closes on nothing that moves"
    with pytest.raises(InvalidInput, match=message):
        robot(path, Jaw(joints=["left_slide"]))
    with pytest.raises(InvalidInput, match="the finger 'left', moved by 'left_slide', has none to close"):
        check_tool(robot(path))


STROKE = "<limit lower='0.002' upper='0.042'/>"
FOLLOWS = "<mimic joint='left_slide'/>"
THIRD = (
    linked("third", "<box size='0.01 0.02 0.08'/>", "0.005 0 0.04")
    + "<joint name='third_slide' type='prismatic'><parent link='tool0'/><child link='third'/>"
    + f"<axis xyz='1 0 0'/>{STROKE}%s</joint><drake:tag/>"
)


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("<axis xyz='0 -1 0'/>", f"<axis xyz='0 1 0'/>{FOLLOWS}",
         r"left_slide \(left, right\) keep their distance: turn the <axis> or the <mimic> of 'right_slide'"),
        (STROKE, "<limit lower='0' upper='0'/>", r"'left_slide' has limits of 0 and 0, so 'left' can"),
        (STROKE, "", r"'left_slide' has limits of 0 and 0, so 'left' cannot move: expected how far it does"),
        ("<drake:tag/>", THIRD % "", r"'tool0' carries 3 moving parts, driven by .* expected two"),
        ("<axis xyz='0 -1 0'/>", "<axis xyz='0 -1 0'/><mimic joint='right_slide'/>",
         r"'right_slide' mimics 'right_slide': expected a joint .* driven itself, one of left"),
    ],
    ids=["same way", "no way", "no limits", "three", "itself"],
)  # fmt: skip
def test_a_hand_that_is_no_jaw_is_refused_by_what_keeps_it_from_closing(tmp_path, old, new, words):
    path = written(tmp_path, fingers=True)
    path.write_text(path.read_text().replace(old, new))
    with pytest.raises(InvalidInput, match=f"arm.urdf: .*{words}"):
        robot(path)


def test_of_three_fingers_on_one_drive_two_have_to_be_named(tmp_path):
    path = written(tmp_path, fingers=True)
    text = path.read_text().replace("<axis xyz='0 -1 0'/>", f"<axis xyz='0 -1 0'/>{FOLLOWS}")
    path.write_text(text.replace("<drake:tag/>", THIRD % FOLLOWS))
    with pytest.raises(InvalidInput, match=r"arm.urdf: .* are three, .* third.*: see `joints`"):
        robot(path)
    named = robot(path, Jaw(joints=["left_slide"], links=["left", "right"]))
    assert named.jaw is not None and set(named.jaw.links) == {"left", "right"}
