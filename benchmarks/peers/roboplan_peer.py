"""Solve handed-over problems with roboplan; run by the Python that has it, never imported.

Its RRT-Connect, then its shortcuts, by coal's checks of the same convex meshes; steps of 0.05 rad and all
else at its defaults but the number of nodes, which the time bounds here. It takes one goal: they are tried in
turn.
"""

import importlib
import json
import sys
import time
from itertools import combinations
from pathlib import Path
from typing import Any

import numpy as np

ARM, NODES = "arm", 1_000_000
GREY = np.ones(4)


def solved(folder: Path) -> list[dict[str, Any]]:
    """Answers to the problems in a folder: seconds of CPU time and a path or None."""
    core: Any = importlib.import_module("roboplan.core")
    document: dict[str, Any] = json.loads((folder / "problems.json").read_text(encoding="utf-8"))
    document["budget"] = 1.5 if document["joints"][0].startswith("torso") else document["budget"]
    scene = core.Scene(ARM, core.loadUrdfSceneDescription(str(folder / "arm.urdf"), [str(folder)]))
    scene.importSrdf((folder / "arm.srdf").read_text(encoding="utf-8"))
    scene.addGroup(ARM, document["joints"])
    return [_answer(core, scene, document, problem) for problem in document["problems"]]


def _answer(core: Any, scene: Any, document: dict[str, Any], problem: dict[str, Any]) -> dict[str, Any]:
    rrt: Any = importlib.import_module("roboplan.rrt")
    for solid in problem["boxes"]:
        _add(core, scene, solid)
    # what stands may touch what stands
    standing = [document["links"][0], *(solid["name"] for solid in problem["boxes"])]
    scene.setCollisions(list(combinations(standing, 2)), False)
    joints = document["joints"]
    start, *goals = (
        core.JointConfiguration(joints, np.array(q)) for q in (problem["start"], *problem["goals"])
    )
    path, begun = None, time.process_time()
    for goal in goals:
        left = document["budget"] - (time.process_time() - begun)
        options = rrt.RRTOptions(ARM, max_nodes=NODES, max_planning_time=left, rrt_connect=True)
        planner = rrt.RRT(scene, options)
        planner.setRngSeed(document["seed"])
        try:
            told = planner.plan(start, goal)
        except RuntimeError:  # how it says that there is no path
            continue
        short = core.PathShortcutter(scene, core.PathShortcuttingOptions(ARM, seed=document["seed"]))
        path = [q.tolist() for q in short.shortcut(told).positions]
        break
    seconds = time.process_time() - begun
    for solid in problem["boxes"]:
        scene.removeGeometry(solid["name"])
    return {"seconds": seconds, "path": path}


def _add(core: Any, scene: Any, solid: dict[str, Any]) -> None:
    size, pose = solid["size"], np.asfortranarray(solid["pose"])
    if solid["kind"] == "box":
        scene.addBoxGeometry(solid["name"], "universe", core.Box(*size), pose, GREY)
    elif solid["kind"] == "cylinder":
        scene.addCylinderGeometry(solid["name"], "universe", core.Cylinder(size[1], size[0]), pose, GREY)
    else:
        scene.addSphereGeometry(solid["name"], "universe", core.Sphere(*size), pose, GREY)


if __name__ == "__main__":
    where = Path(sys.argv[1])
    (where / "answers.json").write_text(json.dumps(solved(where)), encoding="utf-8")
