"""Solve handed-over problems with pybullet-planning; run by the Python that has it, never imported.

Its own `plan_joint_motion`, which is birrt with its restarts and smoothing, by its own collision function;
everything at its defaults, steps of 0.05 rad among them. It takes one goal: they are tried in turn.
"""

import importlib
import json
import math
import random
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np


def solved(folder: Path) -> list[dict[str, Any]]:
    """Answers to the problems in a folder: seconds of CPU time and a path or None."""
    planning: Any = importlib.import_module("pybullet_planning")
    document: dict[str, Any] = json.loads((folder / "problems.json").read_text(encoding="utf-8"))
    random.seed(document["seed"])
    np.random.seed(document["seed"])
    planning.connect(use_gui=False)
    arm = planning.load_pybullet(str(folder / "arm.urdf"), fixed_base=True)
    joints = planning.joints_from_names(arm, document["joints"])
    # the root link has no index of its own in pybullet
    index = {name: planning.link_from_name(arm, name) for name in document["links"][1:]}
    index[document["links"][0]] = planning.BASE_LINK
    ignored = {(index[a], index[b]) for a, b in document["ignored_pairs"]}
    answers: list[dict[str, Any]] = []
    for problem in document["problems"]:
        bodies = [_box(planning, box) for box in problem["boxes"]]
        answers.append(_answer(planning, arm, joints, bodies, ignored, problem, document["budget"]))
        for body in bodies:
            planning.remove_body(body)
    return answers


def _box(planning: Any, box: dict[str, Any]) -> int:
    body = planning.create_box(*box["size"])
    planning.set_pose(body, planning.Pose(planning.Point(*box["centre"]), planning.Euler(yaw=box["yaw"])))
    return int(body)


def _answer(
    planning: Any,
    arm: int,
    joints: list[int],
    bodies: list[int],
    ignored: set[tuple[int, int]],
    problem: dict[str, Any],
    budget: float,
) -> dict[str, Any]:
    planning.set_joint_positions(arm, joints, problem["start"])
    path = None
    begun = time.process_time()
    for goal in problem["goals"]:
        left = budget - (time.process_time() - begun)
        if path is not None or left <= 0:
            break
        planning.set_joint_positions(arm, joints, problem["start"])
        path = planning.plan_joint_motion(
            arm, joints, goal, obstacles=bodies, disabled_collisions=ignored, max_time=left
        )
    seconds = time.process_time() - begun
    waypoints = None if path is None else [[float(v) for v in q] for q in path]
    return {"seconds": seconds, "path": waypoints if waypoints and math.isfinite(seconds) else None}


if __name__ == "__main__":
    where = Path(sys.argv[1])
    (where / "answers.json").write_text(json.dumps(solved(where)), encoding="utf-8")
