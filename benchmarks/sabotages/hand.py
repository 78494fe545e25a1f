"""Spoil what the hand does."""

from topple.benchmarks.sabotages.document import Document, first_step, has_fingers, index_of, segments_of


def hands_closed(d: Document) -> None:
    for step in d["steps"]:
        for part in step["segments"]:
            part["hand"] = {"opening": 0.0, "cup_extension": 0.0}


def hand_closed_on_the_way_in(d: Document) -> bool:
    for part in segments_of(d, "approach"):
        part["hand"]["opening"] = 0.0
    return has_fingers(d)


def hand_not_closed(d: Document) -> None:
    for part in segments_of(d, "grasp"):
        part["hand"] = {"opening": part["hand"]["opening"] + 0.03, "cup_extension": 0.0}


def hand_not_opened(d: Document) -> bool:
    for step in d["steps"]:
        closed = step["segments"][index_of(step, "grasp")]["hand"]
        step["segments"][index_of(step, "release")]["hand"] = dict(closed)
    return has_fingers(d)


def hand_changes_on_the_way(d: Document) -> None:
    hand = segments_of(d, "transfer")[0]["hand"]
    hand["opening"] += 0.01
    hand["cup_extension"] = max(0.0, hand["cup_extension"] - 0.01)


def nothing_held(d: Document) -> None:
    for step in d["steps"]:
        for part in step["segments"]:
            part["holding"] = None


def another_thing_held(d: Document) -> None:
    other = next(thing["name"] for thing in d["objects"] if thing["name"] != first_step(d)["object"])
    for part in first_step(d)["segments"]:
        part["holding"] = part["holding"] and other


def something_held_from_the_start(d: Document) -> None:
    segments_of(d, "move")[0]["holding"] = first_step(d)["object"]


def another_tool_grasps(d: Document) -> None:
    part = segments_of(d, "grasp")[0]
    part["tool"] = "suction" if part["tool"] == "fingers" else "fingers"


def hand_wider_than_it_opens(d: Document) -> bool:
    for part in segments_of(d, "approach"):
        part["hand"]["opening"] = 0.3
    return has_fingers(d)


def pads_that_do_not_touch(d: Document) -> bool:
    """Closed, all along, to 11 mm more than the object between the pads is wide."""
    for step in d["steps"]:
        step["grasp"]["width"] += 0.011
        for part in step["segments"]:
            if part["kind"] in ("grasp", "lift", "transfer", "place"):
                part["hand"]["opening"] = step["grasp"]["width"]
    return has_fingers(d)


def pads_that_stop_short(d: Document) -> bool:
    """A pinch that is called a rim, closed to 18 mm more than the object between the pads is wide."""
    found = False
    for step in d["steps"]:
        grasp = step["grasp"]
        if grasp["kind"] != "pinch":
            continue
        grasp.update(kind="rim", terms={}, width=grasp["width"] + 0.018)
        for part in step["segments"]:
            if part["kind"] in ("grasp", "lift", "transfer", "place"):
                part["hand"]["opening"] = grasp["width"]
        found = True
    return found
