"""A look joins what is seen with what is remembered, and says what was not expected."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import pytest

from topple.planner.execution.look import Observer
from topple.planner.motion.trajectory import retime
from topple.robots import shapes
from topple.robots.catalog import robot
from topple.robots.scenarios.scenario import around, pose_at
from topple.robots.world.camera import Camera
from topple.robots.world.simulated_arm import SimulatedArm
from topple.robots.world.world import World
from topple.topology.base.errors import InvalidInput
from topple.topology.bodies.matter import MATTER
from topple.topology.situation.situation import Situation

AWAY = Camera.looking_at((1.0, 0.0, 0.5), (5.0, 0.0, 3.0))


@pytest.fixture
def world() -> Iterator[World]:
    with World() as made:
        made.add_table()
        made.add(shapes.can("can"), pose_at(0.0, 0.0, 0.0))
        made.add(shapes.block("block"), pose_at(0.0, 0.2, 0.0))
        yield made


def observer(world: World, *cameras: Camera) -> Observer:
    front = Camera.looking_at((0.7, 0.0, 0.3), (0.0, 0.0, 0.05))
    return Observer(world, cameras or (front,), np.random.default_rng(0), ("table",))


def test_strays_are_dropped_and_tables_thinned(world):
    scene = observer(world).look().scene
    can = scene.clouds["can"]
    assert (
        np.linalg.norm(can[:, :2], axis=1).max() < 0.045 and -0.01 < can[:, 2].min() < can[:, 2].max() < 0.12
    )
    assert len(scene.clouds["table"]) < 60_000


def test_what_stays_in_place_is_no_surprise(world):
    eyes = observer(world)
    assert eyes.look(eyes.look().scene).surprises == {}


def test_what_moved_and_what_is_new_is_said(world):
    eyes = observer(world)
    before = eyes.look().scene
    world.place("block", pose_at(0.03, 0.2, 0.0))
    world.add(shapes.block("late"), pose_at(0.0, -0.2, 0.0))
    said = eyes.look(before).surprises
    assert len(said) == 2
    assert said["late"] == "late is seen for the first time" and said["block"].startswith("block is ")


def test_what_is_hidden_is_remembered_and_what_is_gone_is_not(world):
    eyes = observer(world)
    before = eyes.look().scene
    world.add(shapes.box("screen", (0.02, 0.2, 0.2)), pose_at(0.2, 0.2, 0.0))
    hidden = eyes.look(before)
    assert "block" in hidden.scene.names
    assert hidden.surprises["block"] == "block is taken to be where it should be: it is hidden"
    world.remove("screen")
    world.remove("block")
    gone = eyes.look(before)
    assert "block" not in gone.scene.names
    assert gone.surprises["block"] == "block is not where it should be, and seen nowhere"


def test_a_blind_camera_does_no_harm_and_blind_cameras_are_refused(world):
    seeing = observer(world).cameras[0]
    assert set(observer(world, AWAY, seeing).look().scene.names) == {"table", "can", "block"}
    with pytest.raises(InvalidInput, match="none of 1 cameras sees anything"):
        observer(world, AWAY).look()


def test_what_was_weighed_stays_so_when_it_is_seen_anew(world):
    front = Camera.looking_at((0.7, 0.0, 0.3), (0.0, 0.0, 0.05))
    masses, friction = {"can": 0.4, "late": 1.5}, {"table": 0.6, "can": 0.3}
    rng = np.random.default_rng(0)
    eyes = Observer(world, (front,), rng, ("table",), masses=masses, friction=friction)
    before = eyes.look().scene
    assert before.masses == {"can": 0.4}
    assert before.friction == friction
    world.add(shapes.block("late"), pose_at(0.0, -0.2, 0.0))
    world.place("can", pose_at(0.05, 0.0, 0.0))
    after = eyes.look(before).scene
    assert after.masses == masses
    assert after.friction == friction
    others = observer(world).look(before).scene
    assert others.masses == {"can": 0.4}, "what the expected scene says is kept as well"


@pytest.fixture
def walled(world: World) -> World:
    """With a wall that is no object."""
    wall = shapes.box(MATTER, (0.02, 0.6, 0.4))
    world.add(wall, pose_at(-0.2, 0.1, 0.0), fixed=True)
    return world


def test_a_wall_without_a_mask_is_matter_in_every_look(walled):
    eyes = replace(observer(walled), robots=[])
    first = eyes.look().scene
    second = eyes.look(first)
    assert second.surprises == {} and set(second.scene.names) == {"table", "can", "block"}
    for scene in (first, second.scene):
        assert len(scene.matter) > 500
        assert np.abs(scene.matter[:, 0] + 0.19).max() < 0.02
        assert MATTER in Situation(scene).solids


OTHERS = (pytest.param(name, marks=pytest.mark.slow) for name in ("panda-suction", "iiwa", "xarm6"))


@pytest.mark.parametrize("name", ["panda", *OTHERS])
def test_an_arm_in_the_picture_is_no_matter_wherever_it_stands(world, name):
    arm = SimulatedArm(world, robot(name), pose_at(-0.45, 0.0, 0.0))
    cameras = around((0.0, 0.1, 0.03))
    untold, eyes = (replace(observer(world, *cameras), robots=robots) for robots in ([], [arm]))
    assert len(untold.look().scene.matter) > 500
    assert len(observer(world, *cameras).look().scene.matter) == 0  # where robots are not known
    for way in (0.2, -0.4):
        assert len(eyes.look().scene.matter) == 0
        there = arm.q_target + way * np.where(np.arange(len(arm.q_target)) < 2, 1.0, 0.3)
        arm.follow(retime(arm.arm, np.stack([arm.q_target, there]), 0.5))
    assert len(eyes.look().scene.matter) == 0


def test_masks_that_are_off_make_no_matter_of_objects(world):
    cameras = [camera.with_mask_noise(2.0) for camera in around((0.0, 0.1, 0.03))]
    eyes = replace(observer(world, *cameras), robots=[])
    assert len(eyes.look(eyes.look().scene).scene.matter) == 0
