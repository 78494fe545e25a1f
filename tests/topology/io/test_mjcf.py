"""Scenes of MuJoCo: bodies, masses and what is fixed, at keyframes, of files and simulations."""

from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("mujoco", reason="MuJoCo is not installed: pip install '.[mujoco]'")

import mujoco

import topple
from topple.planner.stability.check import check
from topple.topology import InvalidInput, UnknownObject, load_scene, scene_from_mujoco

SCENE = """<mujoco model="desk">
  <asset><mesh name="wedge" file="meshes/wedge.obj"/></asset>
  <worldbody>
    <geom name="floor" type="plane" size="0 0 1"/>
    <body name="shelf" pos="0.5 0 0.1"><geom type="box" size=".1 .1 .1"/>
      <body name="door"><joint type="hinge"/><geom type="box" size=".01 .1 .1" pos="-.2 0 0"/></body></body>
    <body name="book" pos="0 0 .015"><freejoint/>
      <inertial pos=".02 0 0" mass="1.5" diaginertia=".01 .01 .01"/>
      <geom type="box" size=".1 .075 .015" friction=".81"/>
      <geom type="box" size=".3 .3 .3" contype="0" conaffinity="0"/></body>
    <body name="mug" pos=".02 0 .08"><freejoint/><geom type="cylinder" size=".04 .05" mass=".3"/></body>
    <body name="ball" pos="-.3 0 .03"><freejoint/><geom type="sphere" size=".03" mass=".3"/></body>
    <body name="wedge" pos="-.3 .3 0"><freejoint/><geom type="mesh" mesh="wedge" mass=".2"/></body>
  </worldbody>
  <keyframe><key name="edge" qpos="0  0 .4 .015 1 0 0 0
    .104 .4 .08 1 0 0 0  -.3 0 .05 1 0 0 0  -.3 .3 .0167 1 0 0 0"/></keyframe>
</mujoco>"""
WEDGE = "v 0 0 0\nv .1 0 0\nv 0 .1 0\nv .1 .1 0\nv 0 0 .05\nv 0 .1 .05\n" + "".join(
    f"f {face}\n" for face in ("1 3 4", "1 4 2", "1 2 5", "3 6 4", "1 5 6", "1 6 3", "2 4 6", "2 6 5")
)


@pytest.fixture
def path(tmp_path: Path) -> Path:
    (tmp_path / "meshes").mkdir()
    (tmp_path / "meshes" / "wedge.obj").write_text(WEDGE)
    (tmp_path / "scene.xml").write_text(SCENE)
    return tmp_path / "scene.xml"


def test_a_file_is_read_with_masses_centres_friction_and_what_is_fixed(path):
    scene = load_scene(path)
    assert set(scene.names) == {"floor", "shelf", "book", "mug", "ball", "wedge"}
    assert scene.fixed == {"floor", "shelf"}, "a door on a hinge is no thing by itself"
    assert np.allclose(scene.up, (0, 0, 1))
    assert scene.masses["book"] == pytest.approx(1.5)
    assert np.allclose(scene.centres["book"], (0.02, 0, 0.015))
    assert scene.friction["book"] == pytest.approx(0.9)
    book, shelf, ball = (scene.meshes[name].vertices for name in ("book", "shelf", "ball"))
    assert np.allclose(np.ptp(book, axis=0), (0.2, 0.15, 0.03)), "what collides with nothing is left out"
    assert shelf[:, 0].min() == pytest.approx(0.29)
    assert np.linalg.norm(ball - [-0.3, 0, 0.03], axis=1) == pytest.approx(0.03)
    found = check(scene, margins=False).objects
    assert [name for name in ("book", "mug", "ball") if found[name].stands] == ["book", "mug", "ball"]


def test_a_keyframe_is_another_scene(path):
    found = topple.check(load_scene(path, keyframe="edge"), margins=False)
    assert str(found.objects["mug"].verdict) == "tips"
    assert found.objects["mug"].amount == pytest.approx(0.004, abs=2e-4)
    assert str(found.objects["ball"].verdict) == "floats"
    assert found.objects["ball"].amount == pytest.approx(0.02, abs=2e-4)
    with pytest.raises(InvalidInput, match="it has no keyframe 3: it has edge"):
        load_scene(path, keyframe=3)


def test_a_simulation_is_taken_as_it_is_now(path):
    model = mujoco.MjModel.from_xml_path(str(path))
    data = mujoco.MjData(model)
    with pytest.raises(InvalidInput, match="mj_forward"):
        scene_from_mujoco(model, data)
    mujoco.mj_resetDataKeyframe(model, data, 0)
    for _ in range(1000):
        mujoco.mj_step(model, data)
    scene = scene_from_mujoco(model, data, ignore=["wedge"])
    assert "wedge" not in scene.names
    found = check(scene, margins=False)
    assert found.objects["ball"].stands, found.sentence()
    assert np.allclose(scene.centres["ball"], data.body("ball").xipos)
    with pytest.raises(UnknownObject):
        scene_from_mujoco(model, data, fixed="lamp")


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("<mujoco><worldbody><body></mujoco>", "broken XML"),
        ("<mujoco><worldbody><geom type='star'/></worldbody></mujoco>", "MuJoCo cannot read it"),
        ("<mujoco><worldbody/></mujoco>", "nothing in it can be touched"),
        ("<!DOCTYPE a [<!ENTITY b 'c'>]><mujoco><worldbody/></mujoco>", "declares entities"),
        ("<mujoco><include file='../other.xml'/></mujoco>", "not below the folder"),
        ("<mujoco><asset><mesh file='/etc/passwd'/></asset></mujoco>", "not below the folder"),
        ("<mujoco><asset><mesh file='none.obj'/></asset></mujoco>", "No such file"),
    ],
)
def test_what_is_no_scene_is_refused_in_one_line(text, says, tmp_path):
    (tmp_path / "in").mkdir()
    (tmp_path / "other.xml").write_text("<mujoco/>")
    (tmp_path / "in" / "scene.xml").write_text(text)
    with pytest.raises(InvalidInput, match=says):
        load_scene(tmp_path / "in" / "scene.xml")
