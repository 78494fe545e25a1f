"""SRDF files: which joints are the arm, what holds still, which links are not checked against each other."""

import sys
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest

from topple.robots.arm.arm_chain import arm_chain
from topple.robots.arm.gripper_file import ArmPart, Cup, GripperFile
from topple.robots.arm.srdf import EndEffector, read_srdf, srdf_beside
from topple.robots.arm.tree import Tree
from topple.robots.catalog import robot
from topple.topology.base.errors import InvalidInput

sys.path.insert(0, str(Path(__file__).parents[1] / "catalog"))
from own_urdf import linked, written

SRDF = """<robot name="two">
 <group name="left"><chain base_link="mount" tip_link="left_tool0"/></group>
 <group name="right"><joint name="right_j0"/><joint name="right_j1"/><joint name="right_j2"/>
  <joint name="right_j3"/><joint name="right_j4"/><joint name="right_j5"/></group>
 <group name="right_and_lift"><joint name="lift"/><group name="right"/></group>
 <group name="cup"><link name="left_tool0"/></group>
 <group_state name="rest" group="left"><joint name="left_j1" value="-0.5"/></group_state>
 <end_effector name="sucker" parent_link="left_tool0" group="cup"/>
 <disable_collisions link1="left_link4" link2="right_link1" reason="User"/>
 <disable_collisions link1="left_link1" link2="not_here" reason="Never"/>
</robot>"""


def two_armed(folder: Path) -> Path:
    """Two of the six-joint arms on a lift, with a wheel and a head."""
    text = written(folder).read_text()
    arm = text[text.index("<link name='foot'") : text.index("<drake")]
    arm = arm.replace(
        "<joint name='mount' type='fixed'><parent link='world'/><child link='foot'/></joint>", ""
    )
    whole = "<robot name='two'><link name='world'/>" + linked("mount", "<box size='0.1 0.6 0.05'/>")
    whole += (
        "<joint name='lift' type='prismatic'><parent link='world'/><child link='mount'/><axis xyz='0 0 1'/>"
    )
    whole += "<limit lower='0.1' upper='0.4' velocity='0.1'/><origin xyz='0 0 0.3'/></joint>"
    whole += linked("wheel", "<sphere radius='0.05'/>") + linked("head", "<sphere radius='0.05'/>")
    whole += "<joint name='roll' type='continuous'><parent link='world'/><child link='wheel'/></joint>"
    whole += "<joint name='nod' type='revolute'><parent link='mount'/><child link='head'/>"
    whole += "<origin xyz='-0.1 0 0.3'/><limit lower='-1' upper='1'/></joint>"
    for side, y in (("left", 0.25), ("right", -0.25)):
        own = arm
        for kind in ("link", "joint", "child", "parent"):
            key = "name" if kind in ("link", "joint") else "link"
            own = own.replace(f"<{kind} {key}='", f"<{kind} {key}='{side}_")
        whole += own + f"<joint name='{side}' type='fixed'><parent link='mount'/><child link='{side}_foot'/>"
        whole += f"<origin xyz='0 {y} 0.05'/></joint>"
    path = folder / "my_arm" / "two.urdf"
    path.write_text(whole + "</robot>")
    return path


def cup(side: str) -> Cup:
    return Cup(link=f"{side}_tool0", offset=[0.0, 0.0, 0.08], radius=0.015)


@pytest.fixture
def srdf(tmp_path: Path) -> Path:
    path = tmp_path / "semantics.srdf"
    path.write_text(SRDF)
    return path


def test_an_srdf_is_read_whole(srdf):
    said = read_srdf(srdf)
    assert set(said.groups) == {"left", "right", "right_and_lift", "cup"}
    assert said.groups["left"].chains == (("mount", "left_tool0"),)
    assert said.end_effectors == (EndEffector("sucker", "left_tool0", "cup"),)
    assert said.states["left"]["rest"] == {"left_j1": -0.5}
    assert frozenset(("left_link4", "right_link1")) in said.apart


@pytest.mark.parametrize("side", ["left", "right"])
def test_a_group_is_the_arm_and_all_else_holds_still(tmp_path, srdf, side):
    arm = robot(two_armed(tmp_path), cup(side), srdf=srdf, group=side)
    assert arm.joints == tuple(f"{side}_j{k}" for k in range(6))
    assert any("roll at 0" in words and "lift at 0.1" in words for words in arm.assumptions)
    shoulder = arm.chain.frames(arm.home[None])[0, 1, :3, 3]
    # 0.3 below the lift, 0.1 of it, 0.05 of the mount, 0.02 of the foot
    assert shoulder == pytest.approx([0.0, 0.25 if side == "left" else -0.25, 0.47])
    other = "right" if side == "left" else "left"
    q = np.random.default_rng(0).uniform(arm.lower, arm.upper, (2, 6))
    poses = arm.forward(q)[:, arm.links.index(f"{other}_tool0")]
    assert poses[0] == pytest.approx(poses[1])


def test_of_two_arms_one_has_to_be_named(tmp_path, srdf):
    path = two_armed(tmp_path)
    with pytest.raises(InvalidInput, match=r"several arms: .* group=NAME, one of left, right; for one that"):
        robot(path, srdf=srdf)
    with pytest.raises(InvalidInput, match=r"two\.urdf has several arms: .*left_link5, right_link5"):
        robot(path)
    with pytest.raises(InvalidInput, match="no group 'both'; groups that are an arm: left, right"):
        robot(path, srdf=srdf, group="both")
    with pytest.raises(InvalidInput, match="give srdf=FILE"):
        robot(path, group="left")
    with pytest.raises(InvalidInput, match="panda is known whole"):
        robot("panda", srdf=srdf)


def test_of_a_torso_its_arms_are_named(tmp_path):
    text = two_armed(tmp_path).read_text().replace("</robot>", "")
    for k in range(7):  # a leg beside the lift
        text += f"<link name='leg{k}'/><joint name='hip{k}' type='continuous'><child link='leg{k}'/>"
        text += f"<parent link='{f'leg{k - 1}' if k else 'world'}'/></joint>"
    tree = Tree(ElementTree.fromstring(text + "</robot>"), "walker")
    with pytest.raises(InvalidInput, match=r"walker has several arms: .*left_link5, right_link5, leg6"):
        arm_chain(tree, None, None, None)


def test_joints_beneath_all_that_has_a_shape_are_wheels_and_hold_still():
    text = ""
    for k, kind in enumerate(["prismatic", "prismatic", "continuous", *["revolute"] * 5]):
        shape = "<collision><geometry><box size='1 1 1'/></geometry></collision>" * (k > 2)
        text += f"<link name='l{k}'>{shape}</link><joint name='j{k}' type='{kind}'><parent link='l{k}'/>"
        text += f"<child link='l{k + 1}'/></joint>"
    tree = Tree(ElementTree.fromstring(f"<robot>{text}<link name='l8'/></robot>"), "rover")
    chain = arm_chain(tree, None, None, None)
    assert chain is not None
    assert (chain.joints, chain.still) == (("j3", "j4", "j5", "j6", "j7"), ("j0", "j1", "j2"))


def test_a_gripper_file_names_the_arm_and_where_the_rest_stands(tmp_path):
    path, place = two_armed(tmp_path), tmp_path / "arm.toml"
    place.write_text(
        '[cup]\nlink = "left_tool0"\noffset = [0, 0, 0.08]\nradius = 0.015\n'
        '[arm]\ntip = "left_tool0"\nrest = {lift = 0.3}\n'
    )
    arm = robot(path, place)
    assert arm.joints == tuple(f"left_j{k}" for k in range(6))
    assert arm.chain.frames(arm.home[None])[0, 1, 2, 3] == pytest.approx(0.67)
    place.write_text('[arm]\ntip = "left_tool0"\nrest = {lift = 0.5}\n')
    with pytest.raises(
        InvalidInput, match=r"joint 'lift' cannot stand at 0\.5: its limits are 0\.1 and 0\.4"
    ):
        robot(path, place)


def test_links_that_are_not_to_be_checked_are_not(tmp_path, srdf):
    path, named = (
        two_armed(tmp_path),
        GripperFile(cup=cup("left"), arm=ArmPart(tip="left_tool0", rest={"lift": 0.1})),
    )

    def pairs(arm_srdf: Path | None) -> set[frozenset[str]]:
        arm = robot(path, named, srdf=arm_srdf)
        return {frozenset((arm.links[i], arm.links[j])) for i, j in arm.self_pairs}

    assert pairs(None) - pairs(srdf) == {frozenset(("left_link4", "right_link1"))}


def test_what_was_settled_makes_the_same_arm_without_the_srdf(tmp_path, srdf):
    path = two_armed(tmp_path)
    arm = robot(path, cup("right"), srdf=srdf, group="right")
    srdf.unlink()
    again = robot(path, arm.gripper)
    assert again.joints == arm.joints and again.apart == arm.apart and again.gripper == arm.gripper
    assert again.home == pytest.approx(arm.home)


def test_an_srdf_of_the_same_name_is_found_beside(tmp_path):
    path = two_armed(tmp_path)
    assert srdf_beside(path) is None
    for place in (tmp_path / "my_arm" / "config", tmp_path / "my_arm"):
        place.mkdir(exist_ok=True)
        (place / "two.srdf").write_text(SRDF)
        assert srdf_beside(path) == (place / "two.srdf").resolve()
    assert robot(path, cup("left"), group="left").joints[0] == "left_j0"


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("<robot", "not XML"),
        ("<sdf/>", "the root element is <sdf>, an SRDF has <robot>"),
        ("<robot><link name='a'/></robot>", "this is a URDF"),
        ("<robot><group/></robot>", "a <group> without 'name'"),
        ("<robot><group name='a'><group name='b'/></group></robot>", "group 'a' contains 'b', which is not"),
        ("<robot><disable_collisions link1='a'/></robot>", "a <disable_collisions> without 'link2'"),
        ("<robot><group_state name='a'><joint name='j' value='x'/></group_state></robot>", "found 'x'"),
    ],
)
def test_a_bad_srdf_is_refused_in_one_line(tmp_path, text, words):
    path = tmp_path / "bad.srdf"
    path.write_text(text)
    with pytest.raises(InvalidInput) as refusal:
        read_srdf(path)
    assert words in str(refusal.value) and "bad.srdf" in str(refusal.value)
