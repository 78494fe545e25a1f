"""What no URDF may say is refused in a line that says where."""

import numpy as np
import pytest
import trimesh

from topple.robots.arm.urdf import read_urdf
from topple.robots.catalog import robot
from topple.topology.base.errors import InvalidInput

SPHERE = '<link name="{}"><collision><geometry><sphere radius="{}"/></geometry></collision></link>'
LIMITED = (
    '<link name="a"/><link name="b"/><joint name="j" type="{}"><parent link="a"/><child link="b"/>'
    '<limit lower="{}" upper="{}" velocity="1" effort="1"/></joint>'
)
THREE = '<link name="a"/><link name="b"/><link name="c"/>'
TURNING = '<joint name="{}" type="continuous"><parent link="{}"/><child link="{}"/></joint>'


@pytest.mark.parametrize(
    ("body", "words"),
    [
        ("", "has no links: expected at least one"),
        (SPHERE.format("a", "0"), "link 'a': expected a radius above 0, found '0'"),
        (SPHERE.format("a", "-0.1"), "expected a radius above 0"),
        (
            THREE + TURNING.format("j", "b", "c") + TURNING.format("k", "c", "b"),
            "links in a loop, not connected to 'a': b, c",
        ),
        ('<link name="a"/><link name="a"/>', "there are two of link 'a': expected each name once"),
        (THREE + TURNING.format("j", "a", "b") + TURNING.format("j", "b", "c"), "there are two of joint 'j'"),
        (LIMITED.format("prismatic", 0.04, 0), r"'j': its lower limit 0.04 is above its upper limit 0: exch"),
        (LIMITED.format("revolute", -170, 170), r"for degrees expected -2.967 and 2.967; a joint that turns"),
    ],
)
def test_it_is_refused(tmp_path, body, words):
    (tmp_path / "arm.urdf").write_text(f"<robot name='arm'>{body}</robot>")
    with pytest.raises(InvalidInput, match=words):
        read_urdf(tmp_path / "arm.urdf")


@pytest.mark.parametrize(
    ("body", "words"),
    [
        (SPHERE.format("a", "0.1"), "no joint moves 'a'"),
        (
            THREE + TURNING.format("left", "a", "b") + TURNING.format("right", "a", "c"),
            "'a' carries 2 moving parts and none is an arm, which has 4 joints or more",
        ),
    ],
    ids=["still", "legs"],
)
def test_what_is_no_arm_is_refused_by_the_name_of_its_file(tmp_path, body, words):
    (tmp_path / "post.urdf").write_text(f"<robot name='arm'>{body}</robot>")
    with pytest.raises(InvalidInput, match=rf"^post\.urdf: {words}"):
        robot(tmp_path / "post.urdf")


@pytest.mark.parametrize(
    ("scale", "words"),
    [
        ("", "looks like millimetres; expected metres, or scale="),
        ('scale="0 0 0"', "expected numbers other than 0, found '0 0 0'"),
        ('scale="0.001 0.001 0.001"', ""),
    ],
)
def test_a_mesh_in_millimetres_says_so(tmp_path, scale, words):
    trimesh.creation.box((80.0, 80.0, 300.0)).export(tmp_path / "link.stl")
    shape = f'<geometry><mesh filename="link.stl" {scale}/></geometry>'
    mesh = f'<link name="a"><collision>{shape}</collision></link>'
    (tmp_path / "arm.urdf").write_text(f"<robot name='arm'>{mesh}</robot>")
    if not words:
        assert np.ptp(read_urdf(tmp_path / "arm.urdf").links["a"].parts[0], axis=0) == pytest.approx(
            [0.08, 0.08, 0.3]
        )
        return
    with pytest.raises(InvalidInput, match=words):
        read_urdf(tmp_path / "arm.urdf")
