"""Spoil motions."""

import copy

import numpy as np

from topple.benchmarks.sabotages.document import Document, first_step, segments_of, shift
from topple.robots.catalog import robot


def through_the_table(d: Document) -> bool:
    arm = robot(d["robot"])
    tool = first_step(d)["segments"][0]["tool"]
    under = np.array([[1.0, 0, 0, 0.5], [0, -1, 0, 0.0], [0, 0, -1, -0.05], [0, 0, 0, 1]])
    states = arm.inverse(under, tool)[0]
    motion = segments_of(d, "transfer")[0]["motion"]
    if len(states):
        motion["positions"][len(motion["positions"]) // 2] = states[0].tolist()
    return len(states) > 0


def too_fast(d: Document) -> None:
    motion = segments_of(d, "transfer")[0]["motion"]
    motion["times"] = [time / 6 for time in motion["times"]]
    motion["velocities"] = [[6 * value for value in row] for row in motion["velocities"]]


def time_backwards(d: Document) -> None:
    segments_of(d, "lift")[0]["motion"]["times"].reverse()


def no_velocities(d: Document) -> None:
    motion = segments_of(d, "transfer")[0]["motion"]
    motion["velocities"] = [[0.0 for _ in row] for row in motion["velocities"]]


def beyond_a_limit(d: Document) -> None:
    motion = segments_of(d, "move")[0]["motion"]
    motion["positions"][len(motion["positions"]) // 2][0] = 9.0


def a_jump_at_the_join(d: Document) -> None:
    for row in segments_of(d, "lift")[0]["motion"]["positions"]:
        row[0] += 0.05


def straight_to_the_end(d: Document) -> None:
    motion = segments_of(d, "transfer")[0]["motion"]
    for key in ("times", "positions", "velocities"):
        motion[key] = [motion[key][0], motion[key][-1]]


def motion_of_another_step(d: Document) -> bool:
    moves = segments_of(d, "transfer")
    moves[0]["motion"] = copy.deepcopy(moves[-1]["motion"])
    return len(moves) > 1


def starts_elsewhere(d: Document) -> None:
    d["q_start"][0] += 0.1


def base_elsewhere(d: Document) -> None:
    shift(d["pose_base_to_world"], 0, 0.05)


def a_proof_missing(d: Document) -> None:
    segments_of(d, "lift")[0]["certified"] = False


def a_motion_that_begins_late(d: Document) -> None:
    motion = segments_of(d, "transfer")[0]["motion"]
    motion["times"] = [time + 100.0 for time in motion["times"]]


def velocities_a_third_larger(d: Document) -> None:
    for part in segments_of(d, "transfer"):
        part["motion"]["velocities"] = [
            [1.3 * value for value in row] for row in part["motion"]["velocities"]
        ]


def more_room_than_there_is(d: Document) -> None:
    segments_of(d, "transfer")[0]["clearance"] = 0.5


def a_spline_that_swings_out(d: Document) -> None:
    """Before it sets out, speeds up and back within limits: half a second in which a cubic swings out."""
    motion, speed, ramp, pause = segments_of(d, "transfer")[0]["motion"], 1.0, 0.1, 0.5
    begin, times = motion["positions"][0], motion["times"]
    still = [0.0] * (len(begin) - 1)
    aside = [begin[0] + speed * ramp / 2.0, *begin[1:]]
    lasts = 2.0 * ramp + pause
    motion["times"] = [0.0, ramp, ramp + pause, *(lasts + time for time in times)]
    motion["positions"] = [begin, aside, aside, *motion["positions"]]
    motion["velocities"] = [[0.0, *still], [speed, *still], [-speed, *still], *motion["velocities"]]
    d["seconds"] += lasts


def a_lift_that_presses_down_first(d: Document) -> None:
    """Slowly and within limits: down into what bears it by 30 mm, back up, and away as planned."""
    part, arm = segments_of(d, "lift")[-1], robot(d["robot"])
    motion = part["motion"]
    begin, tool, up = np.array(motion["positions"][0]), part["tool"], np.array(d["up"])
    pose = arm.tool_pose(begin, tool)[0]
    pose[:3, 3] -= 0.03 * np.array(d["pose_base_to_world"])[:3, :3].T @ up
    deep = arm.inverse(pose, tool, near=begin)[0][0] - begin
    times = np.linspace(0.0, 2.0, 41)
    ways, speeds = (1.0 - np.cos(np.pi * times)) / 2.0, np.pi * np.sin(np.pi * times) / 2.0
    motion["times"] = [*times[:-1].tolist(), *(2.0 + time for time in motion["times"])]
    motion["positions"] = [*(begin + np.outer(ways, deep))[:-1].tolist(), *motion["positions"]]
    motion["velocities"] = [*np.outer(speeds, deep)[:-1].tolist(), *motion["velocities"]]
    d["seconds"] += 2.0


def proofs_of_a_hand_that_closes(d: Document) -> None:
    segments_of(d, "grasp")[0]["certified"] = True


def certified_and_met(d: Document) -> None:
    segments_of(d, "lift")[0]["witness"] = ["table", first_step(d)["object"]]


def not_certified_as_a_whole(d: Document) -> None:
    d["certified"] = False


def longer_than_it_takes(d: Document) -> None:
    d["seconds"] += 1.0
