"""Spoil the order of the steps."""

import copy

from topple.benchmarks.sabotages.document import Document, first_step, last_step


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
    d["upright"] = [first_step(d)["object"]]


def nothing_is_said_to_wait(d: Document) -> bool:
    """Its steps are in order, and what it says of that lets another program do them in any."""
    waiting = any(step["after"] for step in d["steps"])
    for step in d["steps"]:
        step["after"] = []
    d["dependencies"] = []
    return waiting


def a_dependency_more(d: Document) -> bool:
    """Between things of which the plan moves one, and the other never."""
    handled = {step["object"] for step in d["steps"]}
    other = next(t["name"] for t in d["objects"] if t["name"] not in handled and not t["fixed"])
    edge = {"first": first_step(d)["object"], "then": other, "reason": "supported", "confidence": 0.9}
    d["dependencies"].append(edge)
    return True


def a_dependency_less(d: Document) -> bool:
    waiting = len(d["steps"]) > 1 and bool(d["dependencies"])
    d["dependencies"] = []
    return waiting


def a_dependency_for_another_reason(d: Document) -> bool:
    for edge in d["dependencies"]:
        edge["reason"] = "contained"
    return bool(d["dependencies"])


def a_dependency_that_is_sure(d: Document) -> bool:
    for edge in d["dependencies"]:
        edge["confidence"] *= 0.9
    return bool(d["dependencies"])


def another_action(d: Document) -> None:
    step = last_step(d)
    step["action"] = "remove"


def room_is_made(d: Document) -> None:
    first_step(d)["buffer"] = True
