"""Spoil what the arm does."""

import copy

from sabotages.document import Document, drop_segments, first_step, index_of, last_step


def no_actions(d: Document) -> None:
    for step in d["steps"]:
        step["segments"] = []


def no_actions_in_the_last_step(d: Document) -> None:
    last_step(d)["segments"] = []


def no_actions_in_the_first_step(d: Document) -> None:
    first_step(d)["segments"] = []


def no_grasps(d: Document) -> None:
    for step in d["steps"]:
        drop_segments(step, "grasp")


def no_last_grasp(d: Document) -> None:
    drop_segments(last_step(d), "grasp")


def no_last_release(d: Document) -> None:
    drop_segments(last_step(d), "release")


def no_last_release_and_retreat(d: Document) -> None:
    drop_segments(last_step(d), "release", "retreat")


def no_release_anywhere(d: Document) -> None:
    for step in d["steps"]:
        drop_segments(step, "release")


def no_approach(d: Document) -> None:
    drop_segments(first_step(d), "approach")


def no_lift(d: Document) -> None:
    drop_segments(first_step(d), "lift")


def no_transfer(d: Document) -> None:
    drop_segments(first_step(d), "transfer")


def no_lowering(d: Document) -> None:
    drop_segments(first_step(d), "place")


def only_the_hand_acts(d: Document) -> None:
    drop_segments(first_step(d), "move", "approach", "lift", "transfer", "place", "retreat")


def actions_backwards(d: Document) -> None:
    first_step(d)["segments"].reverse()


def grasp_before_the_approach(d: Document) -> None:
    parts = first_step(d)["segments"]
    parts.insert(index_of(first_step(d), "approach"), parts.pop(index_of(first_step(d), "grasp")))


def release_before_lowering(d: Document) -> None:
    parts = first_step(d)["segments"]
    parts.insert(index_of(first_step(d), "place"), parts.pop(index_of(first_step(d), "release")))


def release_before_the_transfer(d: Document) -> None:
    parts = first_step(d)["segments"]
    parts.insert(index_of(first_step(d), "transfer"), parts.pop(index_of(first_step(d), "release")))


def grasp_and_release_swapped(d: Document) -> None:
    parts = first_step(d)["segments"]
    a, b = index_of(first_step(d), "grasp"), index_of(first_step(d), "release")
    parts[a], parts[b] = parts[b], parts[a]


def grasp_twice(d: Document) -> None:
    parts = first_step(d)["segments"]
    parts.insert(index_of(first_step(d), "lift"), copy.deepcopy(parts[index_of(first_step(d), "grasp")]))


def last_step_twice(d: Document) -> None:
    d["steps"].append(copy.deepcopy(last_step(d)))
