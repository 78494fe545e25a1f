"""What no URDF may say is refused in a line that says where."""

from pathlib import Path

import pytest

from topple.robots.arm.urdf import read_urdf
from topple.topology.errors import InvalidInput

SPHERE = '<link name="{}"><collision><geometry><sphere radius="{}"/></geometry></collision></link>'
TURNING = '<joint name="{}" type="continuous"><parent link="{}"/><child link="{}"/></joint>'


@pytest.mark.parametrize(
    ("body", "words"),
    [
        ("", "has no links: expected at least one"),
        (SPHERE.format("a", "0"), "link 'a': expected a radius above 0, found '0'"),
        (SPHERE.format("a", "-0.1"), "expected a radius above 0"),
        (
            '<link name="a"/><link name="b"/><link name="c"/>'
            + TURNING.format("j", "b", "c")
            + TURNING.format("k", "c", "b"),
            "links in a loop, not connected to 'a': b, c",
        ),
        ('<link name="a"/><link name="a"/>', "there are two of link 'a': expected each name once"),
        (
            '<link name="a"/><link name="b"/><link name="c"/>'
            + TURNING.format("j", "a", "b")
            + TURNING.format("j", "b", "c"),
            "there are two of joint 'j'",
        ),
    ],
)
def test_it_is_refused(tmp_path: Path, body: str, words: str) -> None:
    (tmp_path / "arm.urdf").write_text(f"<robot name='arm'>{body}</robot>")
    with pytest.raises(InvalidInput, match=words):
        read_urdf(tmp_path / "arm.urdf")
