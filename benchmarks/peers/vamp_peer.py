"""Solve handed-over problems with VAMP; run by the Python that has it, never imported.

RRT-Connect and the simplification that its package configures for the arm, on all goals at once, by its own
spheres around the arm's links. A cylinder is the box around it, as it has none but capsules. No wheel is
published: its sdist (vamp-planner 0.6.4) wants the headers of Eigen (the wheel cmeel-eigen has them) and,
where its `cmake/FetchInitCPM.cmake` downloads, those of kavrakilab's nigh, pdqsort and SIMDxorshift: define
`CPMAddPackage` there so that it sets NAME_SOURCE_DIR to copies of them and finds nanobind, then `pip install
--no-build-isolation` it with CMAKE_ARGS="-DEigen3_DIR=... -Dnanobind_DIR=...".
"""

import importlib
import json
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np

ARMS = {"panda_joint1": "panda", "shoulder_pan_joint": "ur5", "torso_lift_joint": "fetch"}
"""By the first joint."""

BASE = 0.02
"""How far the table is lowered [m]: the spheres around the arm's base reach into it where it is."""


def solved(folder: Path) -> list[dict[str, Any]]:
    """Answers to the problems in a folder: seconds of CPU time and a path or None."""
    vamp: Any = importlib.import_module("vamp")
    document: dict[str, Any] = json.loads((folder / "problems.json").read_text(encoding="utf-8"))
    named = ARMS[document["joints"][0]]
    arm, plan, settings, simplifying = vamp.configure_robot_and_planner_with_kwargs(named, "rrtc")
    found: list[dict[str, Any]] = []
    for problem in document["problems"]:
        world, sampler = vamp.Environment(), arm.halton()
        for solid in problem["boxes"]:
            _add(vamp, world, solid)
        begun = time.process_time()
        result = plan(problem["start"], problem["goals"], world, settings, sampler)
        if result.solved:
            result = arm.simplify(result.path, world, simplifying, sampler)
        seconds = time.process_time() - begun
        path = np.array(result.path.numpy()).tolist() if result.solved else None
        found.append({"seconds": seconds, "path": path})
    return found


def _add(vamp: Any, world: Any, solid: dict[str, Any]) -> None:
    pose, size = np.array(solid["pose"]), solid["size"]
    x, y, z = pose[:3, 3]
    if solid["kind"] == "sphere":
        world.add_sphere(vamp.Sphere([x, y, z], size[0]))
        return
    if solid["kind"] == "cylinder":
        size = [2.0 * size[1], 2.0 * size[1], size[0]]
    # about the axes of the world, x first
    turned = [
        np.arctan2(pose[2, 1], pose[2, 2]), -np.arcsin(np.clip(pose[2, 0], -1.0, 1.0)),
        np.arctan2(pose[1, 0], pose[0, 0]),
    ]  # fmt: skip
    low = BASE if solid["name"] == "table" else 0.0
    world.add_cuboid(vamp.Cuboid([x, y, z - low], turned, [edge / 2.0 for edge in size]))


if __name__ == "__main__":
    where = Path(sys.argv[1])
    (where / "answers.json").write_text(json.dumps(solved(where)), encoding="utf-8")
