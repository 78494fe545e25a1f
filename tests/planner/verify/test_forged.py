"""Plans that were forged with care, all else being right: each is refuted by the claim that is about it."""

import copy
import json
from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest
from moving import at
from on_table import BASE, on_table

from topple.benchmarks.sabotages.caught import CASES, ROUGH, planned, scene_for
from topple.benchmarks.sabotages.motions import a_spline_that_swings_out
from topple.planner.decide.goal import Action, PlaceRelation, parse_goal
from topple.planner.errors import NoSafePlan
from topple.planner.placement.placement import Placement
from topple.planner.planning.order import order
from topple.planner.planning.plan import plan, plan_as_done
from topple.planner.planning.plan_format import Plan, plan_from_json, plan_to_json
from topple.planner.planning.step import Context, NextStep
from topple.planner.transfer.transfer import Transfer, TransferRequest, plan_transfer
from topple.planner.verify import Verification, verify
from topple.robots.arm.arm import Station
from topple.robots.catalog import robot
from topple.robots.shapes.boxes import box
from topple.topology.base.errors import InvalidInput
from topple.topology.scene.scene import Scene

CASE = CASES[0]  # a block on a block, and a Panda
CARRIES, HOLDS = "the arm can carry it", "its weight is held"


def refuted(checked: Verification) -> set[str]:
    return {proof.what for proof in checked.refuted}


def document() -> dict[str, Any]:
    made: dict[str, Any] = json.loads(plan_to_json(planned(*CASE)))
    return made


def read(changed: dict[str, Any]) -> Plan:
    return plan_from_json(json.dumps(changed))


def alone(reach: float = 0.0, **seen: Any) -> Scene:
    """A block on a table, seen from all around or as is said."""
    scene = on_table((box("block", (0.05, 0.05, 0.05)), (reach, 0.0, 0.0)), half=0.7)
    return Scene(scene.clouds, fixed=["table"], up=[0, 0, 1], **seen)


def test_an_arm_that_stands_20_cm_beside_where_the_scene_has_it():
    beside = BASE.copy()
    beside[1, 3] += 0.2
    made = planned(*CASE)
    checked = verify(made, scene_for(CASE[0]).with_base(beside), step=ROUGH)
    assert refuted(checked) == {"the arm stands where the scene has it"}
    assert "-0.500 0.000 0.000" in checked.failed[0].witness and "0.200" in checked.failed[0].witness
    assert verify(made, scene_for(CASE[0]).with_base(BASE), step=ROUGH).ok


def test_a_base_of_ones_own_replaces_that_of_the_scene():
    beside = BASE.copy()
    beside[1, 3] += 0.1
    made = plan(alone(robot_base=beside), ["block"], "panda", pose_base_to_world=BASE)
    assert made.pose_base_to_world == BASE.tolist()


@pytest.mark.parametrize(("mass", "what"), [(30.0, {CARRIES, HOLDS}), (4.0, {CARRIES}), (2.0, set())])
def test_what_is_weighed_is_held_against_arm_and_hand(mass, what):
    weighed = scene_for(CASE[0]).weighed({"lower": mass, "upper": 0.1})
    assert refuted(verify(planned(*CASE), weighed, step=ROUGH)) == what
    if what:
        with pytest.raises(NoSafePlan, match=rf"{mass:g} kg are more than"):
            plan(weighed, "free lower", "panda", pose_base_to_world=BASE)


def test_joints_that_cannot_hold_a_load_are_named_with_their_figures():
    """Within the rated payload, and beyond what a joint of an xArm holds far out."""
    far, arm = alone(0.25), robot("xarm6")
    made = plan(far, ["block"], arm, pose_base_to_world=BASE)
    assert verify(made, far, step=ROUGH).ok
    heavy = far.weighed({"block": 2.9}, {"block": 1.0})
    checked = verify(made, heavy, step=ROUGH)
    assert refuted(checked) == {CARRIES}
    assert "joint" in checked.failed[0].witness and "N m" in checked.failed[0].witness
    with pytest.raises(NoSafePlan, match=r"joint\d takes \d+ of \d+ N m"):
        plan(heavy, ["block"], arm, pose_base_to_world=BASE)


def test_a_load_pressed_into_the_table_that_it_is_said_to_be_put_into():
    scene, arm, start = alone(), robot("panda"), np.asarray(robot("panda").home)
    place = at(0.05, 0.12, -0.03)
    into = Placement(place, 1.0, into="table", how=PlaceRelation.ON)
    found = plan_transfer("block", scene, Station(arm, BASE, start), TransferRequest([into]))
    assert isinstance(found, Transfer), found
    step = NextStep(found, Action.FREE, "it is to be free", order(scene, ["block"]))
    made = plan_as_done(scene, parse_goal("free block", scene), Context(Station(arm, BASE, start)), [step])
    checked = verify(made, scene, step=ROUGH)
    assert "nor is it pressed into what bears it" in refuted(checked)
    (pressed,) = [each for each in checked.failed if each.name == "pressed into what it is put on or into"]
    assert 0.005 < pressed.value < 0.03 and "table in block" in pressed.witness


def test_pads_that_are_11_mm_further_apart_than_the_object_is_wide():
    forged = document()
    for step in forged["steps"]:
        step["grasp"]["width"] += 0.011
        for part in step["segments"]:
            if part["holding"] is not None:
                part["hand"]["opening"] = step["grasp"]["width"]
    checked = verify(read(forged), scene_for(CASE[0]), step=ROUGH)
    assert checked["grasps that hold nothing"] == 2.0
    assert "50 mm wide between the pads, which close to 61 mm" in str(checked.failed)


def test_a_foot_that_no_camera_saw_and_nobody_guesses():
    seen = alone(viewpoints=[[0.6, 0.0, 0.8], [-0.2, 0.6, 0.7]])
    made = plan(seen, ["block"], "panda", pose_base_to_world=BASE)
    forged = json.loads(plan_to_json(made))
    thing = next(each for each in forged["objects"] if each["name"] == "block")
    foot = [[x, y, z] for x in (-0.1, 0.1) for y in (-0.1, 0.1) for z in (0.0, 0.002)]
    thing["whole"] = [*(thing["whole"] or thing["parts"]), foot]
    checked = verify(read(forged), seen, step=ROUGH)
    assert "its hidden sides are those of this scene" in refuted(checked)
    assert checked["hidden sides of the plan beyond the scene's"] > 0.05


def test_speeds_by_which_a_controller_leaves_the_path_that_was_checked():
    forged = document()
    a_spline_that_swings_out(forged)
    checked = verify(read(forged), scene_for(CASE[0]), step=ROUGH)
    assert refuted(checked) == {"a controller drives what was checked"}
    assert checked["splines through the samples off the straight way"] > 0.03


# -- each field in turn

FREE = {
    "seed": "how it was found",
    "base_searched": "how it was found: where the arm stands is checked",
    "planning_seconds": "how long it took to find",
    "steps[].planning_seconds": "how long it took to find",
    "tried.*": "how it was found",
    "assumptions[]": "text: more may be assumed than scene and arm say, whose own have to be there",
    "steps[].reason": "text",
    "steps[].grasp.reason": "text",
    "steps[].placement.rest": "text",
}
"""Fields that may say anything, and why."""


def fields(value: Any, name: str = "", path: tuple[Any, ...] = ()) -> Iterator[tuple[str, tuple[Any, ...]]]:
    """The places of all values in a document, each with the name of its field."""
    if isinstance(value, dict):
        for key, inner in value.items():
            open_ = name in ("tried", "poses", "steps[].grasp.terms")  # the keys are names
            yield from fields(inner, f"{name}.{'*' if open_ else key}".lstrip("."), (*path, key))
    elif isinstance(value, list):
        yield f"{name}[]", (*path, len(value))
        for index, inner in enumerate(value):
            yield from fields(inner, f"{name}[]", (*path, index))
    else:
        yield name, path


def altered(value: Any) -> Any:
    if isinstance(value, bool):
        return not value
    if isinstance(value, (int, float)):
        return value + 0.05 if isinstance(value, float) else value + 1
    return ["ghost", "other"] if value is None else f"{value}x"


def forged(value: Any, path: tuple[Any, ...]) -> Any:
    """A document with another value at a place, or one more at the end of a list; the rest is shared."""
    here, *deeper = path
    changed = copy.copy(value)
    if deeper:
        changed[here] = forged(value[here], tuple(deeper))
    elif isinstance(value, list) and here == len(value):
        changed.append("ghost")
    else:
        changed[here] = altered(value[here])
    return changed


def forgeries() -> dict[str, dict[str, Any]]:
    """One document for each field, in which it is another; a list that is empty has one thing more."""
    found: dict[str, dict[str, Any]] = {}
    whole = document()
    for name, path in fields(whole):
        holder = whole
        for key in path[:-1]:
            holder = holder[key]
        more = isinstance(holder, list) and path[-1] == len(holder)
        if name in found or (more and holder):
            continue
        found[name] = forged(whole, path)
    return found


def unnoticed(names: list[str]) -> set[str]:
    """Of fields those that can be another and the plan is still verified."""
    scene, found = scene_for(CASE[0]), forgeries()
    passed = set[str]()
    for name in names:
        try:
            if verify(read(found[name]), scene, step=ROUGH).ok:
                passed.add(name)
        except InvalidInput:
            continue
    return passed


def test_some_fields_that_are_another_are_noticed():
    names = sorted(forgeries().keys() - FREE.keys())
    assert len(names) > 60 and forgeries().keys() >= FREE.keys()
    assert not unnoticed(names[::12])


@pytest.mark.slow
def test_every_field_that_is_another_is_noticed_but_those_that_are_free():
    assert unnoticed(sorted(forgeries())) == FREE.keys()
