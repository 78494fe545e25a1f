"""Spoil what goes with the hand."""

import copy

from sabotages.document import Document, first_step, last_step, shift, turn


def held_otherwise(d: Document) -> None:
    shift(last_step(d)["attachments"][0]["pose_start_to_tool"], 1, 0.05)


def held_turned(d: Document) -> None:
    turn(last_step(d)["attachments"][0]["pose_start_to_tool"], 0.2)


def attached_to_another_tool(d: Document) -> None:
    held = first_step(d)["attachments"][0]
    held["tool"] = "suction" if held["tool"] == "fingers" else "fingers"


def attached_to_nothing(d: Document) -> None:
    first_step(d)["attachments"] = []


def another_thing_rides(d: Document) -> None:
    held = copy.deepcopy(first_step(d)["attachments"][0])
    held["object"] = next(
        thing["name"] for thing in d["objects"] if thing["name"] != held["object"] and thing["fixed"]
    )
    first_step(d)["attachments"].append(held)
