"""A robot in its own picture: with --joints what is seen at it is nobody's, and no more than that."""

import re
from collections.abc import Sequence

import numpy as np
import pytest

from topple.robots import shapes
from topple.robots.catalog import robot
from topple.robots.scenarios.scenario import pose_at
from topple.robots.world.camera import Camera
from topple.robots.world.simulated_arm import SimulatedArm
from topple.robots.world.world import World
from topple.topology.io import load_scene

BASE = ("--base", "-0.5", "0", "0", "0")
JOINTS = ("--robot", "panda", "--joints", *map(str, robot("panda").home))
MASKS = {"table": 1, "box": 2}
"""What the masks name: not the post, nor the arm."""


@pytest.fixture(scope="module")
def frame(tmp_path_factory: pytest.TempPathFactory) -> str:
    """A box before a panda at home, and a post beside it."""
    with World() as world:
        world.add_table(size=(1.6, 1.6))
        world.add(shapes.box("box", (0.05, 0.05, 0.1)), pose_at(0.05, 0.0, 0.0), fixed=True)
        world.add(shapes.box("post", (0.05, 0.05, 0.4)), pose_at(-0.1, 0.45, 0.0), fixed=True)
        SimulatedArm(world, robot("panda"), pose_at(-0.5, 0.0, 0.0))
        image = Camera.looking_at((0.9, 0.5, 0.8), (-0.1, 0.1, 0.15)).look(world)
    label = np.zeros(image.depth.shape, dtype=np.uint8)
    for number, name in image.names.items():
        label[image.label == number] = MASKS.get(name, 0)
    path = tmp_path_factory.mktemp("seen") / "frame.npz"
    np.savez_compressed(
        path, depth=image.depth, K=image.K, label=label, pose_camera_to_world=image.pose_camera_to_world,
        names=np.array(["", *MASKS]), up=np.array([0.0, 0.0, 1.0]),
    )  # fmt: skip
    return str(path)


def said_of_matter(typed, command: Sequence[str]) -> list[str]:
    document = typed(*command, "--json").document
    return [text for text in document["assumptions"] if "reaches beyond the objects" in text]


@pytest.mark.parametrize("command", ["relate", "order"])
def test_its_points_are_nobodys_and_those_of_a_post_are_matter(command, frame, typed):
    (without,) = said_of_matter(typed, [command, frame])
    (given,) = said_of_matter(typed, [command, frame, *JOINTS, *BASE])
    assert int(without.split(": ")[1].split()[0]) > 1500
    assert 100 < int(given.split(": ")[1].split()[0]) < 400
    assert re.search(r"between \(-0\.1[23], 0\.4[23]", given)


def test_in_python_its_bodies_are_given(frame):
    panda = robot("panda")
    scene = load_scene(frame, robot_bodies=panda.bodies(panda.home, pose_at(-0.5, 0.0, 0.0)))
    assert set(scene.names) == {"table", "box"}
    assert 100 < len(scene.matter) < 400
    assert np.linalg.norm(scene.matter[:, :2] - [-0.1, 0.45], axis=1).max() < 0.06


@pytest.mark.slow
def test_an_arm_that_stands_there_plans(frame, typed):
    assert said_of_matter(typed, ["plan", frame, "--target", "box", *JOINTS, *BASE, "--verify"])


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (JOINTS, "the robot of --joints stands is not known: give --base"),
        ((*JOINTS[:-1], *BASE), r"expected 7 finite joint values, of panda_joint1"),
        ((*JOINTS[:-1], "nan", *BASE), r"expected 7 finite joint values"),
    ],
)
def test_what_is_missing_is_said(options, words, frame, typed):
    assert words in typed("order", frame, *options, code=2).err


def test_joints_are_those_of_a_robot(frame, typed):
    assert "--joints are those of --robot" in typed("relate", frame, "--joints", "0", code=2).err
