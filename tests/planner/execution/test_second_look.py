"""The arm carries a camera to the far side of what hides something, and comes back with a picture."""

import numpy as np
import pytest

from topple.planner.execution.loop import ClosedLoop
from topple.planner.execution.second_look import doubtful, second_look
from topple.planner.planning.order import cautious
from topple.robots import robot as robot_named
from topple.robots import shapes
from topple.robots.scenarios.scenario import pose_at
from topple.robots.world.camera import Camera
from topple.robots.world.simulated_arm import SimulatedArm
from topple.robots.world.world import World


@pytest.fixture
def stage() -> World:
    """Two blocks on each other behind a wall, as the only camera sees them."""
    world = World()
    world.add_table()
    world.add(shapes.box("wall", (0.03, 0.12, 0.05)), pose_at(0.06, 0.0, 0.0))
    world.add(shapes.block("low"), pose_at(0.0, 0.0, 0.0))
    world.add(shapes.block("upper"), pose_at(0.0, 0.0, 0.0502))
    world.settle()
    return world


@pytest.fixture
def loop(stage: World) -> ClosedLoop:
    arm = SimulatedArm(stage, robot_named("panda"), pose_at(-0.45, 0.0, 0.0))
    eye = Camera.looking_at((0.6, 0.1, 0.45), (0.0, 0.0, 0.05))
    return ClosedLoop.simulated(stage, arm, [eye], "free low", wrist_camera=True)


def test_the_picture_is_of_the_hidden_side_and_the_arm_is_back_home(loop):
    first = loop.look()
    order = cautious(first.situation, ["low"])
    assert loop.wrist is not None
    taken = second_look(loop.wrist, loop.robot, first.situation, order, seed=0)
    assert taken is not None
    image, view = taken
    assert np.linalg.norm(image.viewpoint - view.eye) < 0.01
    assert view.eye[0] < 0.05  # not where the fixed camera stands
    np.testing.assert_allclose(loop.robot.q_target, loop.robot.arm.home, atol=0.01)
    again = loop.perception.look(first.scene, (image,))
    before, after = (look.scene.clouds["low"] for look in (first, again))
    assert after[:, 0].min() < before[:, 0].min() + 1e-3 and len(after) > 1.5 * len(before)
    assert len(again.scene.viewpoints) == 2


def test_a_step_is_doubtful_by_its_risk(loop):
    order = cautious(loop.look().situation, ["low"])
    risky = [name for name, risk in order.risk.items() if risk > 0.1]
    assert [name for name in order.order if doubtful(order, name)] == [n for n in order.order if n in risky]
    assert not doubtful(order, "somebody else")


def test_what_it_showed_counts_until_it_is_moved(loop):
    first = loop.look()
    assert loop.wrist is not None
    taken = second_look(loop.wrist, loop.robot, first.situation, cautious(first.situation, ["low"]), seed=0)
    assert taken is not None
    again = loop.perception.look(first.scene, (taken[0],))
    later = loop.perception.look(again.scene)
    assert len(later.scene.clouds["low"]) > 1.5 * len(first.scene.clouds["low"])
    cloud = again.scene.clouds["low"] + np.array([0.0, 0.3, 0.0])  # as if it had been carried off
    moved = loop.perception.look(later.scene.with_cloud("low", cloud))
    assert len(moved.scene.clouds["low"]) < 1.5 * len(first.scene.clouds["low"])
    assert len(moved.scene.clouds["upper"]) > 1.1 * len(first.scene.clouds["upper"])
