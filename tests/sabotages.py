"""Ways to spoil a plan: each changes its document, or the scene it is checked with, and is to be noticed."""

import copy
from collections.abc import Callable
from typing import Any

import numpy as np

from topple.robots.catalog import robot
from topple.topology.scene import Scene

Document = dict[str, Any]
Sabotage = Callable[[Document], bool | None]
"""Changes a document; False where there is nothing to change in it."""


def _segments(document: Document, kind: str) -> list[Document]:
    return [part for step in document["steps"] for part in step["segments"] if part["kind"] == kind]


def _without(step: Document, *kinds: str) -> None:
    step["segments"] = [part for part in step["segments"] if part["kind"] not in kinds]


def _index(step: Document, kind: str) -> int:
    return [part["kind"] for part in step["segments"]].index(kind)


def _last(document: Document) -> Document:
    step: Document = document["steps"][-1]
    return step


def _first(document: Document) -> Document:
    step: Document = document["steps"][0]
    return step


def _fingers(document: Document) -> bool:
    return any(part["tool"] == "fingers" for step in document["steps"] for part in step["segments"])


def _shift(matrix: list[list[float]], axis: int, by: float) -> None:
    matrix[axis][3] += by


def _turn(matrix: list[list[float]], by: float) -> None:
    turn = np.array([[np.cos(by), -np.sin(by), 0.0], [np.sin(by), np.cos(by), 0.0], [0.0, 0.0, 1.0]])
    rotation = np.array(matrix)[:3, :3] @ turn
    for row in range(3):
        matrix[row][:3] = rotation[row].tolist()


# -- what the arm does


def no_actions(d: Document) -> None:
    for step in d["steps"]:
        step["segments"] = []


def no_actions_in_the_last_step(d: Document) -> None:
    _last(d)["segments"] = []


def no_actions_in_the_first_step(d: Document) -> None:
    _first(d)["segments"] = []


def no_grasps(d: Document) -> None:
    for step in d["steps"]:
        _without(step, "grasp")


def no_last_grasp(d: Document) -> None:
    _without(_last(d), "grasp")


def no_last_release(d: Document) -> None:
    _without(_last(d), "release")


def no_last_release_and_retreat(d: Document) -> None:
    _without(_last(d), "release", "retreat")


def no_release_anywhere(d: Document) -> None:
    for step in d["steps"]:
        _without(step, "release")


def no_approach(d: Document) -> None:
    _without(_first(d), "approach")


def no_lift(d: Document) -> None:
    _without(_first(d), "lift")


def no_transfer(d: Document) -> None:
    _without(_first(d), "transfer")


def no_lowering(d: Document) -> None:
    _without(_first(d), "place")


def only_the_hand_acts(d: Document) -> None:
    _without(_first(d), "move", "approach", "lift", "transfer", "place", "retreat")


def actions_backwards(d: Document) -> None:
    _first(d)["segments"].reverse()


def grasp_before_the_approach(d: Document) -> None:
    parts = _first(d)["segments"]
    parts.insert(_index(_first(d), "approach"), parts.pop(_index(_first(d), "grasp")))


def release_before_lowering(d: Document) -> None:
    parts = _first(d)["segments"]
    parts.insert(_index(_first(d), "place"), parts.pop(_index(_first(d), "release")))


def release_before_the_transfer(d: Document) -> None:
    parts = _first(d)["segments"]
    parts.insert(_index(_first(d), "transfer"), parts.pop(_index(_first(d), "release")))


def grasp_and_release_swapped(d: Document) -> None:
    parts = _first(d)["segments"]
    a, b = _index(_first(d), "grasp"), _index(_first(d), "release")
    parts[a], parts[b] = parts[b], parts[a]


def grasp_twice(d: Document) -> None:
    parts = _first(d)["segments"]
    parts.insert(_index(_first(d), "lift"), copy.deepcopy(parts[_index(_first(d), "grasp")]))


def last_step_twice(d: Document) -> None:
    d["steps"].append(copy.deepcopy(_last(d)))


# -- the hand


def hands_closed(d: Document) -> None:
    for step in d["steps"]:
        for part in step["segments"]:
            part["hand"] = {"opening": 0.0, "cup_extension": 0.0}


def hand_closed_on_the_way_in(d: Document) -> bool:
    for part in _segments(d, "approach"):
        part["hand"]["opening"] = 0.0
    return _fingers(d)


def hand_not_closed(d: Document) -> None:
    for part in _segments(d, "grasp"):
        part["hand"] = {"opening": part["hand"]["opening"] + 0.03, "cup_extension": 0.0}


def hand_not_opened(d: Document) -> bool:
    for step in d["steps"]:
        closed = step["segments"][_index(step, "grasp")]["hand"]
        step["segments"][_index(step, "release")]["hand"] = dict(closed)
    return _fingers(d)


def hand_changes_on_the_way(d: Document) -> None:
    hand = _segments(d, "transfer")[0]["hand"]
    hand["opening"] += 0.01
    hand["cup_extension"] = max(0.0, hand["cup_extension"] - 0.01)


def nothing_held(d: Document) -> None:
    for step in d["steps"]:
        for part in step["segments"]:
            part["holding"] = None


def another_thing_held(d: Document) -> None:
    other = next(thing["name"] for thing in d["objects"] if thing["name"] != _first(d)["object"])
    for part in _first(d)["segments"]:
        part["holding"] = part["holding"] and other


def something_held_from_the_start(d: Document) -> None:
    _segments(d, "move")[0]["holding"] = _first(d)["object"]


def another_tool_grasps(d: Document) -> None:
    part = _segments(d, "grasp")[0]
    part["tool"] = "suction" if part["tool"] == "fingers" else "fingers"


# -- the grasp


def grasp_elsewhere(d: Document) -> None:
    _shift(_last(d)["grasp"]["pose_tool_to_world"], 1, 0.1)


def grasp_a_little_elsewhere(d: Document) -> None:
    _shift(_first(d)["grasp"]["pose_tool_to_world"], 0, 0.003)


def grasp_turned(d: Document) -> None:
    _turn(_first(d)["grasp"]["pose_tool_to_world"], 0.1)


def grasp_of_another_kind(d: Document) -> None:
    grasp = _first(d)["grasp"]
    grasp["kind"] = "pinch" if grasp["kind"] == "suction" else "suction"


def grasp_of_no_kind(d: Document) -> None:
    _first(d)["grasp"]["kind"] = "magnet"


def grasp_of_another_width(d: Document) -> None:
    _first(d)["grasp"]["width"] += 0.02


def grasp_of_another_score(d: Document) -> None:
    _first(d)["grasp"]["score"] *= 0.9


def grasp_of_other_terms(d: Document) -> None:
    _first(d)["grasp"]["terms"]["balance"] *= 0.5


def grasp_without_a_term(d: Document) -> None:
    del _first(d)["grasp"]["terms"]["balance"]


# -- where it goes


def place_higher(d: Document) -> None:
    _shift(_last(d)["placement"]["pose_before_to_after"], 2, 0.1)


def place_aside(d: Document) -> None:
    _shift(_last(d)["placement"]["pose_before_to_after"], 0, 0.02)


def place_turned(d: Document) -> None:
    _turn(_last(d)["placement"]["pose_before_to_after"], 0.2)


def fall_upwards(d: Document) -> None:
    _last(d)["placement"]["drop"] -= 0.1


def fall_through_the_table(d: Document) -> None:
    _last(d)["placement"]["drop"] += 0.1


def put_into_another_thing(d: Document) -> None:
    placement, own = _first(d)["placement"], _first(d)["object"]
    placement["into"] = next(
        thing["name"]
        for thing in d["objects"]
        if thing["name"] not in (own, placement["into"]) and not thing["fixed"]
    )
    placement["how"] = "on"


def put_within_nothing(d: Document) -> bool:
    placement = _first(d)["placement"]
    placement["how"] = "within"
    return placement["into"] is None


def said_to_fall(d: Document) -> None:
    _first(d)["placement"]["falls"] = True


# -- what goes with the hand


def held_otherwise(d: Document) -> None:
    _shift(_last(d)["attachments"][0]["pose_start_to_tool"], 1, 0.05)


def held_turned(d: Document) -> None:
    _turn(_last(d)["attachments"][0]["pose_start_to_tool"], 0.2)


def attached_to_another_tool(d: Document) -> None:
    held = _first(d)["attachments"][0]
    held["tool"] = "suction" if held["tool"] == "fingers" else "fingers"


def attached_to_nothing(d: Document) -> None:
    _first(d)["attachments"] = []


def another_thing_rides(d: Document) -> None:
    held = copy.deepcopy(_first(d)["attachments"][0])
    held["object"] = next(
        thing["name"] for thing in d["objects"] if thing["name"] != held["object"] and thing["fixed"]
    )
    _first(d)["attachments"].append(held)


# -- motions


def through_the_table(d: Document) -> bool:
    arm = robot(d["robot"])
    tool = _first(d)["segments"][0]["tool"]
    under = np.array([[1.0, 0, 0, 0.5], [0, -1, 0, 0.0], [0, 0, -1, -0.05], [0, 0, 0, 1]])
    states = arm.inverse(under, tool)[0]
    motion = _segments(d, "transfer")[0]["motion"]
    if len(states):
        motion["positions"][len(motion["positions"]) // 2] = states[0].tolist()
    return len(states) > 0


def too_fast(d: Document) -> None:
    motion = _segments(d, "transfer")[0]["motion"]
    motion["times"] = [time / 6 for time in motion["times"]]
    motion["velocities"] = [[6 * value for value in row] for row in motion["velocities"]]


def time_backwards(d: Document) -> None:
    _segments(d, "lift")[0]["motion"]["times"].reverse()


def no_velocities(d: Document) -> None:
    motion = _segments(d, "transfer")[0]["motion"]
    motion["velocities"] = [[0.0 for _ in row] for row in motion["velocities"]]


def beyond_a_limit(d: Document) -> None:
    motion = _segments(d, "move")[0]["motion"]
    motion["positions"][len(motion["positions"]) // 2][0] = 9.0


def a_jump_at_the_join(d: Document) -> None:
    for row in _segments(d, "lift")[0]["motion"]["positions"]:
        row[0] += 0.05


def straight_to_the_end(d: Document) -> None:
    motion = _segments(d, "transfer")[0]["motion"]
    for key in ("times", "positions", "velocities"):
        motion[key] = [motion[key][0], motion[key][-1]]


def motion_of_another_step(d: Document) -> bool:
    moves = _segments(d, "transfer")
    moves[0]["motion"] = copy.deepcopy(moves[-1]["motion"])
    return len(moves) > 1


def starts_elsewhere(d: Document) -> None:
    d["q_start"][0] += 0.1


def base_elsewhere(d: Document) -> None:
    _shift(d["pose_base_to_world"], 0, 0.05)


def a_proof_missing(d: Document) -> None:
    _segments(d, "lift")[0]["certified"] = False


# -- order


def steps_swapped(d: Document) -> bool:
    d["steps"].reverse()
    for index, step in enumerate(d["steps"]):
        step["after"] = list(range(index))
    return len(d["steps"]) > 1


def first_step_left_out(d: Document) -> None:
    d["steps"].pop(0)
    for step in d["steps"]:
        step["after"] = []


def last_step_left_out(d: Document) -> None:
    d["steps"].pop()


def against_what_is_kept(d: Document) -> bool:
    for step in d["steps"]:
        step["against"] = copy.deepcopy(d["dependencies"])
    return bool(d["dependencies"])


def waits_for_nothing(d: Document) -> bool:
    for step in d["steps"]:
        step["after"] = []
    return any(edge["first"] != edge["then"] for edge in d["dependencies"]) and len(d["steps"]) > 1


def a_dependency_turned_round(d: Document) -> bool:
    for edge in d["dependencies"]:
        edge["first"], edge["then"] = edge["then"], edge["first"]
    return bool(d["dependencies"])


def another_goal(d: Document) -> None:
    handled = {step["object"] for step in d["steps"]}
    other = next(t["name"] for t in d["objects"] if t["name"] not in handled and not t["fixed"])
    d["goal"] = f"free {other}"


def order_of_others(d: Document) -> bool:
    d["order"] = list(reversed(d["order"]))
    return len(set(d["order"])) > 1


def upright_switched_on(d: Document) -> None:
    for step in d["steps"]:
        step["upright"] = True


def upright_in_the_plan_alone(d: Document) -> None:
    d["upright"] = [_first(d)["object"]]


# -- what it was planned for


def a_body_half_as_large(d: Document) -> None:
    thing = next(thing for thing in d["objects"] if thing["name"] == _first(d)["object"])
    middle = np.mean(np.vstack(thing["parts"]), axis=0)
    thing["parts"] = [(middle + 0.5 * (np.array(p) - middle)).tolist() for p in thing["parts"]]
    thing["whole"] = []


def a_body_twice_as_large(d: Document) -> None:
    thing = next(thing for thing in d["objects"] if thing["name"] == _first(d)["object"])
    middle = np.mean(np.vstack(thing["parts"]), axis=0)
    thing["parts"] = [(middle + 2.0 * (np.array(p) - middle)).tolist() for p in thing["parts"]]
    thing["whole"] = []


def an_obstacle_taken_out(d: Document) -> None:
    handled = {step["object"] for step in d["steps"]}
    thing = next(t for t in d["objects"] if t["name"] not in handled and not t["fixed"])
    thing["parts"], thing["whole"] = [thing["parts"][0][:4]], []


def a_fixed_thing_that_moves(d: Document) -> None:
    next(thing for thing in d["objects"] if thing["name"] == _first(d)["object"])["fixed"] = True


def up_turned(d: Document) -> None:
    d["up"] = [0.0, float(np.sin(0.1)), float(np.cos(0.1))]


def everything_excused(d: Document) -> None:
    arm = robot(d["robot"])
    handled = {step["object"] for step in d["steps"]}
    other = next(t["name"] for t in d["objects"] if t["name"] not in handled and not t["fixed"])
    _segments(d, "move")[0]["may_touch"] = [[arm.tools[next(iter(arm.tools))].links[0], other]]


def what_is_carried_excused(d: Document) -> None:
    handled = {step["object"] for step in d["steps"]}
    other = next(t["name"] for t in d["objects"] if t["name"] not in handled and not t["fixed"])
    _segments(d, "transfer")[0]["may_touch"] = [sorted([_first(d)["object"], other])]


SPOILT: tuple[Sabotage, ...] = (
    no_actions, no_actions_in_the_last_step, no_actions_in_the_first_step, no_grasps, no_last_grasp,
    no_last_release, no_last_release_and_retreat, no_release_anywhere, no_approach, no_lift, no_transfer,
    no_lowering, only_the_hand_acts, actions_backwards, grasp_before_the_approach, release_before_lowering,
    release_before_the_transfer, grasp_and_release_swapped, grasp_twice, last_step_twice,
    hands_closed, hand_closed_on_the_way_in, hand_not_closed, hand_not_opened, hand_changes_on_the_way,
    nothing_held, another_thing_held, something_held_from_the_start, another_tool_grasps,
    grasp_elsewhere, grasp_a_little_elsewhere, grasp_turned, grasp_of_another_kind, grasp_of_no_kind,
    grasp_of_another_width, grasp_of_another_score, grasp_of_other_terms, grasp_without_a_term,
    place_higher, place_aside, place_turned, fall_upwards, fall_through_the_table, put_into_another_thing,
    said_to_fall,
    held_otherwise, held_turned, attached_to_another_tool, attached_to_nothing, another_thing_rides,
    through_the_table, too_fast, time_backwards, no_velocities, beyond_a_limit, a_jump_at_the_join,
    straight_to_the_end, motion_of_another_step, starts_elsewhere, base_elsewhere, a_proof_missing,
    steps_swapped, first_step_left_out, last_step_left_out, against_what_is_kept, waits_for_nothing,
    a_dependency_turned_round, another_goal, order_of_others, upright_switched_on, upright_in_the_plan_alone,
    a_body_half_as_large, a_body_twice_as_large, an_obstacle_taken_out, a_fixed_thing_that_moves, up_turned,
    everything_excused, what_is_carried_excused,
)  # fmt: skip
"""What verification has to refute."""


def unknown_object(d: Document) -> None:
    _first(d)["object"] = "ghost"


def unknown_container(d: Document) -> None:
    _first(d)["placement"]["into"] = "ghost"


def unknown_rider(d: Document) -> None:
    _first(d)["attachments"][0]["object"] = "ghost"


def empty_motion(d: Document) -> None:
    _segments(d, "transfer")[0]["motion"] = {"times": [], "positions": [], "velocities": []}


def too_few_velocities(d: Document) -> None:
    _segments(d, "transfer")[0]["motion"]["velocities"].pop()


def unknown_segment(d: Document) -> None:
    _segments(d, "transfer")[0]["kind"] = "throw"


def pose_of_three_rows(d: Document) -> None:
    _first(d)["grasp"]["pose_tool_to_world"].pop()


def step_after_itself(d: Document) -> None:
    _first(d)["after"] = [0]


def negative_step(d: Document) -> None:
    _last(d)["after"] = [-1]


UNREADABLE: tuple[Sabotage, ...] = (
    unknown_object, unknown_container, unknown_rider, empty_motion, too_few_velocities, unknown_segment,
    pose_of_three_rows, step_after_itself, negative_step, put_within_nothing,
)  # fmt: skip
"""What reading has to refuse by path."""


# -- another scene than the plan was made for


def another_up(scene: Scene, _target: str) -> Scene:
    return scene.with_up([0.0, np.sin(0.1), np.cos(0.1)])


def forty_points(scene: Scene, target: str) -> Scene:
    cloud = scene.clouds[target]
    return scene.with_cloud(target, cloud[np.linspace(0, len(cloud) // 3, 40).astype(int)])


def thing_elsewhere(scene: Scene, target: str) -> Scene:
    return scene.with_cloud(target, scene.clouds[target] + np.array([0.03, 0.0, 0.0]))


def thing_larger(scene: Scene, target: str) -> Scene:
    cloud = scene.clouds[target]
    return scene.with_cloud(target, cloud.mean(axis=0) + 1.4 * (cloud - cloud.mean(axis=0)))


OTHER_SCENES = (another_up, forty_points, thing_elsewhere, thing_larger)
