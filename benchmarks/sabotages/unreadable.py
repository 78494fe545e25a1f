"""Documents that reading has to refuse by path."""

from topple.benchmarks.sabotages.document import Document, first_step, last_step, segments_of


def unknown_object(d: Document) -> None:
    first_step(d)["object"] = "ghost"


def unknown_container(d: Document) -> None:
    first_step(d)["placement"]["into"] = "ghost"


def unknown_rider(d: Document) -> None:
    first_step(d)["attachments"][0]["object"] = "ghost"


def empty_motion(d: Document) -> None:
    segments_of(d, "transfer")[0]["motion"] = {"times": [], "positions": [], "velocities": []}


def too_few_velocities(d: Document) -> None:
    segments_of(d, "transfer")[0]["motion"]["velocities"].pop()


def unknown_segment(d: Document) -> None:
    segments_of(d, "transfer")[0]["kind"] = "throw"


def pose_of_three_rows(d: Document) -> None:
    first_step(d)["grasp"]["pose_tool_to_world"].pop()


def step_after_itself(d: Document) -> None:
    first_step(d)["after"] = [0]


def negative_step(d: Document) -> None:
    last_step(d)["after"] = [-1]


def put_within_nothing(d: Document) -> bool:
    placement = first_step(d)["placement"]
    placement["how"] = "within"
    return placement["into"] is None


def grasp_that_scales(d: Document) -> None:
    pose = first_step(d)["grasp"]["pose_tool_to_world"]
    pose[0] = [3.0 * value for value in pose[0]]


def a_place_without_a_turn(d: Document) -> None:
    first_step(d)["placement"]["pose_before_to_after"] = [[0.0] * 4 for _ in range(4)]


def what_touches_itself(d: Document) -> None:
    segments_of(d, "lift")[0]["may_touch"].append([first_step(d)["object"]] * 2)


def step_after_one_twice(d: Document) -> bool:
    step = last_step(d)
    step["after"] = step["after"] * 2
    return bool(step["after"])


def an_action_of_no_kind(d: Document) -> None:
    first_step(d)["action"] = "juggle"


def a_fallback_of_no_kind(d: Document) -> None:
    first_step(d)["fallbacks"] = ["magic"]


def put_beside_of_no_kind(d: Document) -> None:
    first_step(d)["placement"].update(how="beside", into=d["objects"][-1]["name"])
