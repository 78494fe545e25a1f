"""Rearrangements as plans and runs of an arm."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from documents import contradictions
from on_table import BASE, on_table

from topple.planner import NoSafePlan, Plan, rearrange
from topple.planner.cli.main import main
from topple.planner.decide.arrange import Order
from topple.planner.execution.demo import loop_in
from topple.planner.execution.goal_poses import off_goal_pose
from topple.planner.planning.order import cautious
from topple.planner.planning.plan_format import plan_from_json, plan_to_json
from topple.planner.planning.step import Context, NextStep, Orderer
from topple.planner.rearranging.arrangement import Arrangement
from topple.planner.rearranging.problem import Act
from topple.planner.rearranging.task import ArrangementTask, DescribedTask, LearnedPrecedences
from topple.robots import scenario
from topple.robots.arm.arm import Station
from topple.robots.catalog import robot
from topple.robots.scenarios.scenario import pose_at
from topple.robots.shapes import block, box, plate
from topple.robots.world.world import World
from topple.topology import Scene
from topple.topology.situation.situation import Situation

UP = np.array([0.0, 0.0, 1.0])


def blocks(**places: tuple[float, float, float]) -> Scene:
    return on_table(*((box(name, (0.05, 0.05, 0.05)), place) for name, place in places.items()), points=1500)


START, GOAL = blocks(a=(0, 0, 0), b=(0.2, 0, 0)), blocks(a=(0.2, 0, 0), b=(0, 0, 0))


@pytest.fixture(scope="module")
def swapped() -> Plan:
    return rearrange(START, GOAL, "panda", pose_base_to_world=BASE)


def test_two_blocks_change_places_in_three_certified_steps(swapped):
    assert [(step.action, step.buffer) for step in swapped.steps] == [
        ("remove", True), ("place", False), ("place", False),
    ]  # fmt: skip
    assert swapped.certified and swapped.goal == "a on table, b on table"
    checked = swapped.verify(START)
    assert checked.ok
    assert any(each.name == "bodies off their place" for each in checked.residuals)
    assert plan_from_json(plan_to_json(swapped)) == swapped


def test_a_plan_that_leaves_a_thing_beside_its_place_is_refuted(swapped):
    import msgspec

    poses = {name: np.array(pose) for name, pose in swapped.poses.items()}
    poses["a"][1, 3] += 0.02
    spoilt = msgspec.structs.replace(swapped, poses={name: pose.tolist() for name, pose in poses.items()})
    assert [bad.name for bad in spoilt.verify(START).failed] == ["bodies off their place"]


def noisy(scene: Scene, seed: int) -> Scene:
    rng = np.random.default_rng(seed)
    clouds = {name: cloud + rng.normal(0, 0.0015, cloud.shape) for name, cloud in scene.clouds.items()}
    return replace(scene, clouds=clouds)


@pytest.mark.slow
def test_a_tower_does_not_grow_by_the_noise_of_what_is_seen():
    start = noisy(blocks(red=(0, 0, 0), green=(0, 0, 0.05), blue=(0, 0, 0.1)), 0)
    goal = noisy(blocks(red=(0.2, 0, 0), green=(0.2, 0, 0.1), blue=(0.2, 0, 0.05)), 1)
    found = rearrange(start, goal, "panda", pose_base_to_world=BASE)
    put = [step for step in found.steps if step.action == "place"]
    assert [step.object for step in put] == ["red", "blue", "green"]
    for step in put:
        down = step.placement.drop
        rest = np.array(step.placement.pose_before_to_after)
        assert 0.003 < down < 0.02 and rest.shape == (4, 4)
    assert found.verify(start).ok


@pytest.mark.slow
def test_a_tower_is_built_again_in_another_order():
    start = blocks(red=(0, 0, 0), green=(0, 0, 0.05), blue=(0, 0, 0.1))
    goal = blocks(red=(0.2, 0, 0), green=(0.2, 0, 0.1), blue=(0.2, 0, 0.05))
    found = rearrange(start, goal, "panda", pose_base_to_world=BASE)
    assert found.order == ["blue", "green", "red", "blue", "green"]
    assert found.verify(start).ok


@pytest.mark.slow
def test_what_bars_the_hand_makes_room_and_comes_back():
    around = [
        (box(name, (0.05, 0.05, 0.09)), (0.054 * x, 0.054 * y, 0.0))
        for name, (x, y) in {"west": (-1, 0), "east": (1, 0), "south": (0, -1), "north": (0, 1)}.items()
    ]
    low = box("low", (0.05, 0.05, 0.04))
    start, goal = (on_table(*around, (low, place), points=1500) for place in ((0, 0, 0), (0.05, 0.25, 0)))
    assert [move.object for move in rearrange(start, goal).moves] == ["low"]
    found = rearrange(start, goal, "panda", pose_base_to_world=BASE)
    middle = found.order.index("low")
    assert set(found.order[:middle]) == set(found.order[middle + 1 :])
    assert [step.buffer for step in found.steps] == [True] * middle + [False] * (middle + 1)
    assert found.verify(start).ok


def test_what_lies_there_already_takes_no_step():
    assert rearrange(START, START, "panda", pose_base_to_world=BASE).steps == []


def test_what_the_arm_cannot_do_is_told():
    wide = (
        on_table((box("a", (0.12, 0.12, 0.12)), (0, 0, 0))),
        on_table((box("a", (0.12, 0.12, 0.12)), (0.1, 0, 0))),
    )
    with pytest.raises(NoSafePlan, match="wider than the hand opens"):
        rearrange(*wide, "panda", pose_base_to_world=BASE)


@pytest.mark.slow
def test_the_command_writes_the_plan(tmp_path, typed):
    paths = [str(tmp_path / name) for name in ("start.npz", "goal.npz")]
    for path, scene in zip(paths, (START, GOAL), strict=True):
        np.savez(path, up=[0, 0, 1], fixed=["table"], robot_base=BASE, **dict(scene.clouds))  # type: ignore[arg-type]
    document = typed("plan", paths[0], "--to", paths[1], "--json").document
    assert [step["buffer"] for step in document["steps"]] == [True, False, False]
    assert set(document["poses"]) == {"a", "b"}
    assert "no sequence has fewer" in typed("order", paths[0], "--to", "a left of b").out
    assert main(["plan", paths[0], "--to", paths[1], "--goal", "a on b"]) == 2


def test_a_lesson_of_a_place_holds_until_that_is_left():
    learned = LearnedPrecedences()
    learned.pairs[(Act.TAKE, "a"), (Act.PUT, "b")] = 1
    learned.pairs[(Act.PUT, "a"), (Act.PUT, "b")] = 1
    done = [("a", "remove"), ("c", "place")]
    assert len(learned.now(done)) == 2
    assert learned.now([*done, ("a", "place")]) == {((Act.PUT, "a"), (Act.PUT, "b"))}


def test_an_arrangement_knows_what_lies_on_what():
    assert Arrangement(blocks(a=(0, 0, 0), b=(0, 0, 0.05))).goal(START).text == "a on table, b on a"
    with pytest.raises(Exception, match="things match by name"):
        Arrangement(blocks(a=(0, 0, 0))).goal(START)
    assert Arrangement(GOAL).fit("a", Situation(START)).way == pytest.approx(0.2, abs=0.003)


def test_a_body_is_off_its_place_by_no_turn_that_its_shape_does_not_show():
    from scipy.spatial.transform import Rotation

    with World() as world:
        world.add(plate("plate"), pose_at(0.3, 0, 0))
        world.add(block("block"), pose_at(0, 0, 0))
        for turn, seen in ((8.0, 8.0), (20.0, 20.0), (90.0, 0.0), (97.0, 7.0)):
            wanted = pose_at(0.005, 0, 0, Rotation.from_euler("z", turn, degrees=True))
            way, angle = off_goal_pose(world, "block", wanted, UP)
            assert way == pytest.approx(0.005) and np.degrees(angle) == pytest.approx(seen, abs=0.5)
            there = pose_at(0.3, 0, 0, Rotation.from_euler("z", turn, degrees=True))
            assert np.degrees(off_goal_pose(world, "plate", there, UP)[1]) < 3.0
        assert (
            np.degrees(
                off_goal_pose(world, "plate", pose_at(0.3, 0, 0, Rotation.from_euler("x", 0.2)), UP)[1]
            )
            > 11.0
        )


@pytest.mark.slow
def test_two_things_change_places_in_closed_loop():
    with scenario("swap", 1) as stage:
        record = loop_in(stage, seed=1).run()
        assert record.success, record.violations
        assert stage.finished is not None
        for name, pose in stage.finished.poses().items():
            way, angle = off_goal_pose(stage.world, name, pose, stage.up)
            assert way < 0.01 and angle < np.radians(10.0)


def test_a_task_that_is_asked_again_begins_anew():
    task = DescribedTask("a right of b")
    goals = [task.goal(scene) for scene in (START, blocks(a=(0, 0.2, 0), b=(0.1, -0.1, 0)))]
    fresh = DescribedTask("a right of b").goal(blocks(a=(0, 0.2, 0), b=(0.1, -0.1, 0)))
    assert np.allclose(goals[1].poses["a"], fresh.poses["a"])
    assert not np.allclose(goals[0].poses["a"], goals[1].poses["a"], atol=0.01)
    copied = ArrangementTask(Arrangement(GOAL))
    copied.learned.pairs[(Act.TAKE, "a"), (Act.PUT, "b")] = 0
    copied.goal(START)
    assert not copied.learned.pairs


AWAY = blocks(a=(0, 0.25, 0), b=(0.2, 0.25, 0))


def _first_step(context: Context, start: Scene = START, goal: Scene = AWAY) -> NextStep:
    task = ArrangementTask(Arrangement(Situation(goal)))
    chosen = task.chooser(Situation(start), task.goal(start), context).choose()
    assert chosen is not None
    return chosen


def _context(orderer: Orderer = cautious) -> Context:
    arm = robot("panda")
    return Context(Station(arm, BASE, np.asarray(arm.home)), observed=True, orderer=orderer)


def test_what_was_put_beside_its_place_is_taken_by_another_grasp():
    first = _first_step(_context())
    name, grasp = first.transfer.object, first.transfer.grasp
    again = _first_step(replace(_context(), placed={name: (grasp,)}))
    assert again.transfer.object == name
    assert not again.transfer.grasp.near(grasp)


@pytest.mark.parametrize(("risky", "other"), [("a", "b"), ("b", "a")])
def test_of_moves_that_wait_for_nothing_the_one_goes_first_that_moves_nothing_else(risky, other):
    def orderer(*args: Any, **more: Any) -> Order:
        return replace(cautious(*args, **more), chances={(other, risky): 0.3, (risky, other): 0.06})

    assert _first_step(_context(orderer)).transfer.object == other


def test_what_sticks_a_little_into_a_place_and_shall_leave_goes_first():
    tall, low = box("a", (0.05, 0.05, 0.08)), box("b", (0.05, 0.05, 0.015))
    start = on_table((tall, (0, 0.2, 0)), (low, (0, 0, 0)), points=1500)
    goal = on_table((tall, (0.045, 0, 0)), (low, (0, -0.2, 0)), points=1500)
    first = _first_step(_context(), start, goal)
    assert first.transfer.object == "b" and first.transfer.placement.into is None
    assert contradictions(first.order.to_json(), ["b"]) == []
