"""Spoil the grasp."""

from sabotages.document import Document, first_step, last_step, shift, turn


def grasp_elsewhere(d: Document) -> None:
    shift(last_step(d)["grasp"]["pose_tool_to_world"], 1, 0.1)


def grasp_a_little_elsewhere(d: Document) -> None:
    shift(first_step(d)["grasp"]["pose_tool_to_world"], 0, 0.003)


def grasp_turned(d: Document) -> None:
    turn(first_step(d)["grasp"]["pose_tool_to_world"], 0.1)


def grasp_of_another_kind(d: Document) -> None:
    grasp = first_step(d)["grasp"]
    grasp["kind"] = "pinch" if grasp["kind"] == "suction" else "suction"


def grasp_of_no_kind(d: Document) -> None:
    first_step(d)["grasp"]["kind"] = "magnet"


def grasp_of_another_width(d: Document) -> None:
    first_step(d)["grasp"]["width"] += 0.02


def grasp_of_another_score(d: Document) -> None:
    first_step(d)["grasp"]["score"] *= 0.9


def grasp_of_other_terms(d: Document) -> None:
    first_step(d)["grasp"]["terms"]["balance"] *= 0.5


def grasp_without_a_term(d: Document) -> None:
    del first_step(d)["grasp"]["terms"]["balance"]
