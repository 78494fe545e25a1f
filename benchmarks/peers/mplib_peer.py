"""Solve handed-over problems with mplib; run by the Python that has it, never imported.

Its own `OMPLPlanner.plan` (RRTConnect, then simplification) by its own C++ FCL checks, on all goals at once
and with that call's defaults; `plan_qpos`, which wraps it, takes branches of 0.1 rad, is four times slower
on the problems of the bench for it, and adds a retiming that is not timed here.
"""

import importlib
import json
import math
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np


def solved(folder: Path) -> list[dict[str, Any]]:
    """Answers to the problems in a folder: seconds of CPU time and a path or None."""
    mplib: Any = importlib.import_module("mplib")
    document: dict[str, Any] = json.loads((folder / "problems.json").read_text(encoding="utf-8"))
    if hasattr(mplib, "set_global_seed"):
        mplib.set_global_seed(document["seed"])
    planner = mplib.Planner(
        urdf=str(folder / "arm.urdf"),
        srdf=str(folder / "arm.srdf"),
        move_group=document["links"][-1],
        use_convex=True,
        user_joint_names=document["joints"],
    )
    return [_answer(mplib, planner, problem, document["budget"]) for problem in document["problems"]]


def _answer(mplib: Any, planner: Any, problem: dict[str, Any], budget: float) -> dict[str, Any]:
    fcl: Any = importlib.import_module("mplib.collision_detection.fcl")
    world = planner.planning_world
    for box in problem["boxes"]:
        turn = [math.cos(box["yaw"] / 2), 0.0, 0.0, math.sin(box["yaw"] / 2)]
        pose = mplib.Pose(box["centre"], turn)
        shape = fcl.CollisionObject(fcl.Box(np.array(box["size"])))
        world.add_object(fcl.FCLObject(box["name"], pose, [shape], [mplib.Pose()]))
    start = np.array(problem["start"])
    planner.robot.set_qpos(start, True)
    goals = [np.array(goal) for goal in problem["goals"]]
    begun = time.process_time()
    status, path = planner.planner.plan(start, goals, time=budget, simplify=True)
    seconds = time.process_time() - begun
    for box in problem["boxes"]:
        world.remove_object(box["name"])
    return {"seconds": seconds, "path": path.tolist() if status == "Exact solution" else None}


if __name__ == "__main__":
    where = Path(sys.argv[1])
    (where / "answers.json").write_text(json.dumps(solved(where)), encoding="utf-8")
