"""Solve handed-over problems with VAMP; run by the Python that has it, never imported.

RRT-Connect and the simplification that its package configures for a Panda, on all goals at once, by its own
spheres around the arm's links. No wheel of it is published: its sdist (vamp-planner 0.6.4) wants the headers
of Eigen (the wheel cmeel-eigen has them) and, where its `cmake/FetchInitCPM.cmake` downloads, those of nigh,
pdqsort and SIMDxorshift: define `CPMAddPackage` there so that it sets NAME_SOURCE_DIR to copies of them and
finds nanobind, then `pip install --no-build-isolation` it with CMAKE_PREFIX_PATH at Eigen and nanobind.
"""

import importlib
import json
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np

BASE = 0.02
"""How far the table is lowered [m]: the spheres around the arm's base reach into it where it is."""


def solved(folder: Path) -> list[dict[str, Any]]:
    """Answers to the problems in a folder: seconds of CPU time and a path or None."""
    vamp: Any = importlib.import_module("vamp")
    document: dict[str, Any] = json.loads((folder / "problems.json").read_text(encoding="utf-8"))
    arm, plan, settings, simplifying = vamp.configure_robot_and_planner_with_kwargs("panda", "rrtc")
    found: list[dict[str, Any]] = []
    for problem in document["problems"]:
        world, sampler = vamp.Environment(), arm.halton()
        for box in problem["boxes"]:
            half, (x, y, z) = [edge / 2.0 for edge in box["size"]], box["centre"]
            low = BASE if box["name"] == "table" else 0.0
            world.add_cuboid(vamp.Cuboid([x, y, z - low], [0.0, 0.0, box["yaw"]], half))
        begun = time.process_time()
        result = plan(problem["start"], problem["goals"], world, settings, sampler)
        if result.solved:
            result = arm.simplify(result.path, world, simplifying, sampler)
        seconds = time.process_time() - begun
        path = np.array(result.path.numpy()).tolist() if result.solved else None
        found.append({"seconds": seconds, "path": path})
    return found


if __name__ == "__main__":
    where = Path(sys.argv[1])
    (where / "answers.json").write_text(json.dumps(solved(where)), encoding="utf-8")
