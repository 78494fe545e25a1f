"""What no hand can hold is refused by rankings, and used by no plan."""

from dataclasses import replace

import numpy as np
import pytest
from on_table import BASE, on_table

from topple.planner.errors import NoSafePlan
from topple.planner.grasp.candidates import grasp_candidates
from topple.planner.grasp.given import doable
from topple.planner.grasp.grasp import Grasp
from topple.planner.grasp.rank import rank_grasps
from topple.planner.planning.plan import plan
from topple.robots.catalog import robot
from topple.robots.shapes.boxes import box, can
from topple.robots.shapes.cutlery import spoon
from topple.robots.shapes.tableware import mug
from topple.topology.scene.scene import Scene
from topple.topology.situation.situation import Situation

PANDA = robot("panda")
MIDDLE = (0.0, 0.0, 0.0)


def pinch(name: str, x: float, y: float, z: float, opening: float = 0.0) -> Grasp:
    """A hand from above whose pads close along y."""
    pose = np.diag([1.0, -1.0, -1.0, 1.0])
    pose[:3, 3] = [x, y, z]
    return Grasp(name, "pinch", pose, 0.0, opening, 1.0)


def carton(hole: bool = False) -> Scene:
    """A carton of 20 by 20 by 10 cm, whose cloud has a hole in its top, as glossy ones have, or has none."""
    scene = on_table((box("carton", (0.2, 0.2, 0.1)), MIDDLE), points=12000)
    cloud = scene.clouds["carton"]
    lost = (np.abs(cloud[:, 0]) < 0.04) & (cloud[:, 1] < 0.098) & (cloud[:, 1] > 0.02) & (cloud[:, 2] > 0.05)
    return scene.with_cloud("carton", cloud[~lost]) if hole else scene


def walled() -> Scene:
    """A block, and beside it matter that no mask names."""
    scene = on_table((box("block", (0.05, 0.05, 0.05)), MIDDLE))
    matter = np.random.default_rng(1).uniform([-0.1, 0.034, 0.0], [0.1, 0.044, 0.1], (800, 3))
    return Scene(scene.clouds, ["table"], (0, 0, 1), matter=matter)


def ball() -> Scene:
    """A ball of 7 cm."""
    way = np.random.default_rng(2).normal(size=(4000, 3))
    cloud = 0.035 * way / np.linalg.norm(way, axis=1)[:, None] + [0.0, 0.0, 0.035]
    return on_table().with_cloud("ball", cloud)


CASES = {
    "in what it fills": (carton(hole=True), pinch("carton", 0.0, 0.1, 0.08, 0.04), "a finger would stand in"),
    "wide": (
        carton(),
        pinch("carton", 0.0, 0.0, 0.1),
        "carton is 200 mm wide between the pads, which open 80",
    ),
    "sliding": (ball(), pinch("ball", 0.0, 0.0, 0.072), "pads would slide"),
    "empty": (carton(), pinch("carton", 0.0, 0.2, 0.08), "nothing of carton is between its pads"),
    "in matter": (walled(), pinch("block", 0.0, 0.0, 0.04), "the hand meets something without a name"),
}


@pytest.mark.parametrize("case", CASES)
def test_what_no_hand_can_hold_is_refused_by_ranking_and_plan_alike(case):
    scene, grasp, words = CASES[case]
    (ranked,) = rank_grasps(scene, [grasp], "panda")
    assert words in (ranked.why or "")
    with pytest.raises(NoSafePlan, match=r"\(2 of 2 grasps given\)") as caught:
        plan(scene.with_base(BASE), [grasp.object], "panda", grasps=[grasp, replace(grasp, score=0.5)])
    (failure,) = caught.value.failures
    assert any(words in reason for reason in failure.reasons)


def test_of_grasps_given_those_that_hold_are_used_and_none_of_the_others():
    scene = walled()
    bad = pinch("block", 0.0, 0.0, 0.04)
    turned = np.array([[0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, -1.0]])
    pose = bad.pose_tool_to_world.copy()
    pose[:3, :3] = turned
    good = replace(bad, pose_tool_to_world=pose, score=0.1)
    left, dropped = doable([bad, good], Situation(scene), PANDA, BASE)
    assert [np.allclose(grasp.pose_tool_to_world, pose) for grasp in left] == [True]
    assert list(dropped.reasons) == ["the hand meets something without a name (1 of 2 grasps given)"]
    (step,) = plan(scene, ["block"], "panda", pose_base_to_world=BASE, grasps=[bad, good]).steps
    assert abs(np.array(step.grasp.pose_tool_to_world)[0, 1]) == pytest.approx(1.0)


@pytest.mark.parametrize("told", [0.0, 0.01, 0.2])
def test_a_width_is_what_the_object_measures_whatever_it_is_told_to_be(told):
    scene = on_table((box("block", (0.05, 0.06, 0.05)), MIDDLE))
    (grasp,), _ = doable([replace(pinch("block", 0, 0, 0.04), width=told)], Situation(scene), PANDA, BASE)
    assert grasp.width == pytest.approx(0.06, abs=0.004)
    assert PANDA.jaw is not None
    assert grasp.width < grasp.opening <= PANDA.jaw.max_opening


@pytest.mark.parametrize(
    "body", [can(), mug(), spoon(), box("box", (0.04, 0.12, 0.06))], ids=lambda b: b.name
)
def test_what_a_search_finds_the_ranking_refuses_none_of(body):
    scene = on_table((body, MIDDLE))
    found = grasp_candidates(body.name, scene, PANDA)
    assert found
    refused = [entry.why for entry in rank_grasps(scene, found, "panda") if entry.why]
    assert refused == []
