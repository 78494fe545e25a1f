"""Results go to other processes and threads and come back equal."""

import copy
import json
import pickle
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor
from functools import partial
from multiprocessing import get_context
from typing import Any

import numpy as np
import pytest
from on_table import BASE, table

from topple.planner import NoSafePlan, order, plan, rank_grasps
from topple.planner.formats.run_record import RunRecord, StepRecord
from topple.planner.grasp.candidates import grasp_candidates
from topple.planner.planning.plan_format import plan_from_json, plan_to_json
from topple.robots.catalog import robot
from topple.robots.shapes.boxes import box
from topple.topology import DepthImage, Hull, InvalidInput, Mesh, Scene, relate
from topple.topology.situation.situation import Situation


def stack(seed: int = 0) -> Scene:
    rng = np.random.default_rng(seed)
    return Scene(
        {
            "table": table(0.3, 0.01),
            "lower": box("lower", (0.06, 0.06, 0.06)).surface(900, rng),
            "upper": box("upper", (0.05, 0.05, 0.05)).surface(900, rng) + np.array([0.0, 0.0, 0.0605]),
        },
        fixed=["table"],
        up=[0, 0, 1],
        masses={"upper": 0.2},
        meshes={"lower": Mesh(np.eye(3), np.array([[0, 1, 2]]))},
    )


def image() -> DepthImage:
    depth, labels = np.ones((4, 5)), np.ones((4, 5), dtype=np.int64)
    intrinsics = np.array([[4.0, 0, 2], [0, 4.0, 2], [0, 0, 1]])
    return DepthImage(depth, intrinsics, labels, names={1: "wall"})


SCENE = stack()


def _plan() -> Any:
    return plan(SCENE, ["lower"], "panda", pose_base_to_world=BASE)


def _record() -> RunRecord:
    step = StepRecord("upper", "remove", True, scene=SCENE, tool_path=np.zeros((2, 3)), tilts={"lower": 0.1})
    told = relate(SCENE).to_json()
    return RunRecord("free lower", "panda", 0, True, steps=(step,), scene=SCENE, relations=told)


RESULTS: dict[str, Callable[[], Any]] = {
    "scene": lambda: SCENE,
    "image": image,
    "mesh": lambda: SCENE.meshes["lower"],
    "hull": lambda: Hull.of(SCENE.clouds["lower"]),
    "relations": lambda: relate(SCENE),
    "pair": lambda: relate(SCENE).between("upper", "lower"),
    "situation": lambda: Situation(SCENE),
    "order": lambda: order(SCENE, "lower"),
    "graph": lambda: order(SCENE, "lower").graph,
    "grasp": lambda: grasp_candidates("upper", SCENE, robot("panda"))[0],
    "ranked": lambda: rank_grasps(SCENE, grasp_candidates("upper", SCENE, robot("panda"))[:3]),
    "plan": _plan,
    "record": _record,
    "refusal": lambda: NoSafePlan("none", ("cycle: a before b",)),
    "bad input": lambda: InvalidInput("no"),
}


@pytest.mark.parametrize("name", RESULTS)
def test_what_is_pickled_or_copied_is_equal(name):
    made = RESULTS[name]()
    for again in (pickle.loads(pickle.dumps(made)), copy.deepcopy(made)):
        assert type(again) is type(made)
        if isinstance(made, Exception):
            assert str(again) == str(made) and vars(again) == vars(made)
        elif name == "situation":
            assert again.scene == made.scene and again.relations == made.relations
        else:
            assert again == made


def test_what_differs_in_one_number_is_not_equal():
    other = SCENE.with_cloud("upper", SCENE.clouds["upper"] + 1e-9)
    assert stack() == SCENE and other != SCENE and hash(stack()) == hash(SCENE)
    assert relate(other) != relate(SCENE)
    assert order(SCENE, "lower") != order(SCENE, "upper")
    assert SCENE.weighed({"upper": 0.3}) != SCENE


def test_a_mapping_of_a_result_cannot_be_written_to():
    found = order(SCENE, "lower")
    for mapping in (SCENE.clouds, SCENE.masses, found.risk, found.chances):
        for change in (lambda m: m.__setitem__("x", 1), lambda m: m.pop("upper"), lambda m: m.update(x=1)):
            with pytest.raises(TypeError, match="read-only"):
                change(mapping)
    assert json.loads(json.dumps(found.risk)) == dict(found.risk)


SCENES = [stack(seed) for seed in range(3)]


@pytest.mark.slow
@pytest.mark.parametrize("method", ["fork", "spawn"])
def test_orders_are_made_in_other_processes(method):
    with ProcessPoolExecutor(1, mp_context=get_context(method)) as pool:
        found = list(pool.map(partial(order, targets="lower"), SCENES))
    assert found == [order(scene, "lower") for scene in SCENES]


def test_orders_are_made_in_threads():
    with ThreadPoolExecutor(3) as pool:
        found = list(pool.map(lambda scene: order(scene, "lower"), SCENES * 3))
    assert found == [order(scene, "lower") for scene in SCENES] * 3


def test_a_plan_read_back_is_equal():
    made = _plan()
    assert plan_from_json(plan_to_json(made)) == made
