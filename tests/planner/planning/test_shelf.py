"""Things in a shelf are taken from the front: what stands before one goes first, and nothing goes up."""

from collections.abc import Iterator

import numpy as np
import pytest

from topple.planner.decide.dependency import Reason, dependencies
from topple.planner.execution.look import Observer
from topple.planner.grasp.grasp import PINCH, Grasp
from topple.planner.planning.plan import plan
from topple.planner.rearranging.arrangement import Arrangement
from topple.planner.rearranging.task import ArrangementTask
from topple.planner.transfer.transfer import TransferFailure, TransferRequest, plan_transfer
from topple.planner.verify import verify
from topple.robots import scenario
from topple.robots.arm.arm import Station
from topple.robots.arm.gripper import FINGERS
from topple.robots.catalog import robot
from topple.robots.scenarios.scenario import Scenario
from topple.topology.base.arrays import bounds
from topple.topology.scene.scene import Scene
from topple.topology.situation.situation import Situation

OUT = np.array([-1.0, 0.0, 0.0])


@pytest.fixture(scope="module")
def stage() -> Iterator[Scenario]:
    with scenario("shelf", 1) as made:
        yield made


@pytest.fixture(scope="module")
def scene(stage: Scenario) -> Scene:
    eyes = Observer(stage.world, stage.cameras, np.random.default_rng(0), stage.fixed, stage.up)
    return eyes.look().scene


def test_what_stands_before_a_thing_goes_first(scene):
    situation = Situation(scene)
    assert all(situation.way_out(name) @ OUT > 0.99 for name in scene.movable)
    found = dependencies(situation)
    assert {(edge.first, edge.then) for edge in found.dependencies} == {
        ("can_1", "box_0"), ("tin_7", "mug_4"),
    }  # fmt: skip
    for edge in found.dependencies:
        (swept,) = edge.evidence
        assert edge.reason is Reason.BLOCKING
        assert (swept.a, swept.b, swept.level) == (edge.then, edge.first, True)
        assert "slid out" in edge.sentence()
        assert swept.to_json()["level"] is True


def test_under_a_board_no_hand_comes_from_above(scene, stage):
    arm = robot(stage.robot)
    pose, (low, high) = np.diag([1.0, -1.0, -1.0, 1.0]), bounds(scene.clouds["can_1"])
    pose[:3, 3] = [*(low + high)[:2] / 2.0, high[2] - 0.02]
    above = Grasp("can_1", PINCH, pose, 0.062, 0.078, 1.0)
    station = Station(arm, stage.pose_base_to_world, np.array(arm.home))
    found = plan_transfer("can_1", scene, station, TransferRequest(grasps=[above]))
    assert isinstance(found, TransferFailure)
    assert found.reasons
    assert all("meets shelf" in words for words in found.reasons)


def test_what_belongs_in_another_column_slides_in_level(scene, stage):
    clouds = {**scene.clouds, "can_1": scene.clouds["can_1"] + np.array([0.0, 0.16, 0.0])}
    wanted = ArrangementTask(Arrangement(Scene(clouds, scene.fixed, scene.up)))
    found = plan(scene, wanted, stage.robot, pose_base_to_world=stage.pose_base_to_world)
    assert verify(found, scene).ok
    segments = found.steps[-1].segments
    (way,) = (segment.motion for segment in segments if segment.kind == "place")
    assert way is not None
    tool = robot(stage.robot).tool_pose(np.array(way.positions), FINGERS)[:, :3, 3]
    along = tool[-1] - tool[0]
    assert -0.03 < along[2] < -0.01
    assert np.linalg.norm(along[:2]) > 0.05


@pytest.mark.slow
def test_what_is_planned_slides_out_and_is_verified(scene, stage):
    found = plan(scene, stage.goal, stage.robot, pose_base_to_world=stage.pose_base_to_world)
    assert found.order == ["can_1", "box_0"]
    assert found.verify(scene).ok
    arm, base = robot(stage.robot), stage.pose_base_to_world
    for step in found.steps:
        approach = np.array(step.grasp.pose_tool_to_world)[:3, 2]
        assert approach @ OUT < -0.8
        (lift,) = [each.motion for each in step.segments if each.kind == "lift"]
        assert lift is not None
        way = (base @ arm.tool_pose(np.array(lift.positions), FINGERS))[:, :3, 3]
        assert way[-1] - way[0] == pytest.approx(0.10 * OUT + [0.0, 0.0, 0.02], abs=4e-3)
        low = way[:, 2] - way[0, 2] < 0.018
        assert np.abs((way[low] - way[0])[:, :2]).max() < 3e-3  # up first
