"""Plans and runs with the caller's own grasps, order and relations."""

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from on_table import BASE, on_table

from topple.planner.decide.arrange import Order, arrange
from topple.planner.decide.dependency import Dependency, DependencyGraph
from topple.planner.errors import NoSafePlan
from topple.planner.execution.run import run
from topple.planner.grasp.foreign import grasps_from_array
from topple.planner.grasp.grasp import Grasp
from topple.planner.grasp.rank import rank_grasps
from topple.planner.planning.order import order
from topple.planner.planning.plan import plan
from topple.robots.shapes.boxes import box
from topple.topology.base.errors import InvalidInput, UnknownObject
from topple.topology.relations.relate import Relations, relate
from topple.topology.scene.scene import Scene
from topple.topology.situation.situation import Situation


def down(x: float, y: float, z: float, turn: float = 0.0) -> np.ndarray:
    """A hand from above whose pads close along y, turned about the vertical."""
    pose = np.diag([1.0, -1.0, -1.0, 1.0])
    cos, sin = np.cos(turn), np.sin(turn)
    pose[:3, :3] = np.array([[cos, -sin, 0.0], [sin, cos, 0.0], [0.0, 0.0, 1.0]]) @ pose[:3, :3]
    pose[:3, 3] = [x, y, z]
    return pose


PINCH = Grasp("aside", "pinch", down(0.0, 0.2, 0.04), 0.05, 0.06, 1.0)


def stacked() -> Scene:
    """A block on a block, and one aside."""
    places = {"lower": (0.0, 0.0, 0.0), "upper": (0.0, 0.0, 0.0505), "aside": (0.0, 0.2, 0.0)}
    return on_table(*((box(name, (0.05, 0.05, 0.05)), at) for name, at in places.items()), half=0.35)


def test_an_object_is_taken_by_a_grasp_of_the_callers_own_and_the_others_as_ever():
    scene = stacked()
    # many that stand in the block, one beside it, and one that nobody's search would find: turned by 0.1 rad
    poses = [*(down(0.0, 0.0, 0.06) for _ in range(40)), down(0.2, -0.2, 0.1), down(0.004, 0.0, 0.086, 0.1)]
    ranked = rank_grasps(scene, grasps_from_array(np.array(poses)), "panda", pose_base_to_world=BASE)
    found = plan(scene, ["lower"], "panda", pose_base_to_world=BASE, grasps=ranked)
    first, second = found.steps
    assert (first.object, second.object) == ("upper", "lower")
    assert np.allclose(first.grasp.pose_tool_to_world, poses[-1], atol=1e-5) or np.allclose(
        first.grasp.pose_tool_to_world, poses[-1] @ np.diag([-1.0, -1.0, 1.0, 1.0]), atol=1e-5
    )
    assert first.grasp.width == pytest.approx(0.05, abs=0.006)
    assert found.verify(scene).ok


def test_where_no_grasp_of_the_callers_own_will_do_there_is_no_plan():
    scene = stacked()
    high = Grasp("aside", "pinch", down(0.0, 0.2, 0.02), 0.05, 0.06, 1.0)  # the palm meets the top
    sunk = replace(high, pose_tool_to_world=down(0.0, 0.2, -0.02))
    for given in ({"aside": [sunk]}, {"aside": []}):
        with pytest.raises(NoSafePlan, match="aside"):
            plan(scene, ["aside"], "panda", pose_base_to_world=BASE, grasps=given)
    assert plan(scene, ["aside"], "panda", pose_base_to_world=BASE).steps


@pytest.mark.parametrize(
    ("given", "error", "words"),
    [
        ([replace(PINCH, object="")], InvalidInput, "grasp 0 names no object"),
        ({"cup": []}, UnknownObject, "cup"),
        ({"aside": [replace(PINCH, object="lower")]}, InvalidInput, "is given for"),
        ([replace(PINCH, kind="suction")], InvalidInput, "panda has no suction"),
    ],
)
def test_grasps_that_do_not_fit_are_refused(given, error, words):
    for act in (plan, run):
        with pytest.raises(error, match=words):
            act(stacked(), ["aside"], "panda", pose_base_to_world=BASE, grasps=given)


def aside_first(scene: Scene, targets: Sequence[str], **_: object) -> Order:
    """Takes what stands aside before anything else."""
    names = [name for name in ("aside", "upper") if name not in targets]
    edges = [Dependency(first, then, "blocking", 1.0) for first in names for then in targets]
    if "upper" in scene.movable and "aside" in names:
        edges.append(Dependency("aside", "upper", "blocking", 1.0))
    return arrange(
        DependencyGraph(scene.movable, tuple(edges)), targets, {n: np.zeros(3) for n in scene.movable}
    )


@pytest.mark.slow
def test_an_orderer_of_the_callers_own_is_asked_for_the_order():
    plain = plan(stacked(), ["lower"], "panda", pose_base_to_world=BASE)
    assert [step.object for step in plain.steps] == ["upper", "lower"]
    asked: list[tuple[str, ...]] = []

    def orderer(scene: Situation, targets: Sequence[str], **known: Any) -> Order:
        asked.append(tuple(targets))
        if len(asked) == 1:
            return aside_first(scene.scene, targets)
        return order(scene, targets)

    found = plan(stacked(), ["lower"], "panda", pose_base_to_world=BASE, orderer=orderer)
    assert [step.object for step in found.steps] == ["aside", "upper", "lower"]
    assert asked[0] == ("lower",)


def test_an_orderer_that_gives_no_order_is_refused():
    def names(scene: Situation, targets: Sequence[str], **_: object) -> Any:
        return ["upper", "lower"]

    with pytest.raises(InvalidInput, match="the orderer gave list, expected an Order"):
        plan(stacked(), ["lower"], "panda", pose_base_to_world=BASE, orderer=names)


@pytest.mark.slow
def test_relations_of_the_callers_own_are_what_the_order_is_asked_with():
    scene, seen = stacked(), list[Relations]()
    mine = relate(scene)

    def orderer(given: Situation, targets: Sequence[str], **_: Any) -> Order:
        seen.append(given.relations)
        return order(given, targets)

    plan(scene, ["lower"], "panda", pose_base_to_world=BASE, orderer=orderer, relations=mine)
    assert seen[0] is mine
    assert seen[-1] is not mine
    asked: list[Scene] = []

    def related(given: Scene) -> Relations:
        asked.append(given)
        return relate(given)

    found = plan(scene, ["lower"], "panda", pose_base_to_world=BASE, relations=related)
    assert len(asked) == len(found.steps) + 1
    with pytest.raises(InvalidInput, match="the relations are of"):
        plan(scene, ["lower"], "panda", pose_base_to_world=BASE, relations=relate(scene.without("aside")))


@pytest.mark.slow
def test_a_run_takes_the_callers_grasps_and_order():
    scene, asked = stacked(), list[tuple[str, ...]]()

    def orderer(given: Situation, targets: Sequence[str], **known: Any) -> Order:
        asked.append(tuple(targets))
        return order(given, targets)

    pose = down(0.012, 0.2, 0.036, 0.1)  # off its middle, where no search of our own begins
    record = run(
        scene, ["aside"], "panda", pose_base_to_world=BASE, orderer=orderer,
        grasps=[Grasp("aside", "pinch", pose, 0.0, 0.0, 1.0)],
    )  # fmt: skip
    assert record.success, record.violations
    assert asked
    middle = np.mean([scene.clouds[name].mean(axis=0) for name in scene.movable], axis=0)
    x, y, z = pose[:3, 3] - [middle[0], middle[1], 0.0]
    # a run lays the things about its middle along the sides of the table, of which none is the first
    wanted = np.array([(x, y, z), (-y, x, z), (-x, -y, z), (y, -x, z)])
    path = np.array(record.steps[0].tool_path)[:, None, :3]
    assert np.linalg.norm(path - wanted, axis=2).min() < 0.006
