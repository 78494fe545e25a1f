"""Spoil what the plan was made for."""

import numpy as np

from topple.benchmarks.sabotages.document import Document, first_step, last_step, segments_of, shift
from topple.robots.catalog import robot


def a_body_half_as_large(d: Document) -> None:
    thing = next(thing for thing in d["objects"] if thing["name"] == first_step(d)["object"])
    middle = np.mean(np.vstack(thing["parts"]), axis=0)
    thing["parts"] = [(middle + 0.5 * (np.array(p) - middle)).tolist() for p in thing["parts"]]
    thing["whole"] = []


def a_body_twice_as_large(d: Document) -> None:
    thing = next(thing for thing in d["objects"] if thing["name"] == first_step(d)["object"])
    middle = np.mean(np.vstack(thing["parts"]), axis=0)
    thing["parts"] = [(middle + 2.0 * (np.array(p) - middle)).tolist() for p in thing["parts"]]
    thing["whole"] = []


def an_obstacle_taken_out(d: Document) -> None:
    handled = {step["object"] for step in d["steps"]}
    thing = next(t for t in d["objects"] if t["name"] not in handled and not t["fixed"])
    thing["parts"], thing["whole"] = [thing["parts"][0][:4]], []


def a_fixed_thing_that_moves(d: Document) -> None:
    next(thing for thing in d["objects"] if thing["name"] == first_step(d)["object"])["fixed"] = True


def up_turned(d: Document) -> None:
    d["up"] = [0.0, float(np.sin(0.1)), float(np.cos(0.1))]


def everything_excused(d: Document) -> None:
    arm = robot(d["robot"])
    handled = {step["object"] for step in d["steps"]}
    other = next(t["name"] for t in d["objects"] if t["name"] not in handled and not t["fixed"])
    segments_of(d, "move")[0]["may_touch"] = [[arm.tools[next(iter(arm.tools))].links[0], other]]


def what_is_carried_excused(d: Document) -> None:
    handled = {step["object"] for step in d["steps"]}
    other = next(t["name"] for t in d["objects"] if t["name"] not in handled and not t["fixed"])
    segments_of(d, "transfer")[0]["may_touch"] = [sorted([first_step(d)["object"], other])]


def an_arm_that_is_faster(d: Document) -> None:
    d["arm"]["velocity"] = [10.0 * value for value in d["arm"]["velocity"]]


def a_tool_elsewhere(d: Document) -> None:
    shift(d["arm"]["tools"][0]["pose_tool_to_link"], 2, 0.05)


def a_larger_table(d: Document) -> None:
    for thing in d["objects"]:
        if thing["fixed"]:
            thing["parts"] = [[[3.0 * x, 3.0 * y, z] for x, y, z in part] for part in thing["parts"]]


def a_foot_that_nobody_saw(d: Document) -> None:
    """A slab under what is put down, on which it stands well."""
    thing = next(thing for thing in d["objects"] if thing["name"] == last_step(d)["object"])
    low, high = (each(np.vstack(thing["parts"]), axis=0) for each in (np.min, np.max))
    slab = [
        [x, y, z]
        for x in (low[0] - 0.1, high[0] + 0.1)
        for y in (low[1] - 0.1, high[1] + 0.1)
        for z in (low[2], low[2] + 0.002)
    ]
    thing["whole"] = [*thing["parts"], slab]
