"""Two things change places: what three cameras see of the table as it is and as it shall be, and the plan.

    python examples/07_swap.py [START.npz GOAL.npz]

With two paths both scenes are written there, for `topple plan START.npz --to GOAL.npz`; nothing is planned.
"""

import sys
from pathlib import Path

import numpy as np

import topple
from topple.planner import Observer, plan_page
from topple.robots import scenario
from topple.robots.scenarios import Scenario


def looked(stage: Scenario, finished: bool, seed: int) -> topple.Scene:
    """What the cameras see of the start, or of the finished arrangement."""
    world = stage.finished if finished else stage.world
    assert world is not None
    return Observer(world, stage.cameras, np.random.default_rng(seed), stage.fixed).look().scene


def write(path: str, scene: topple.Scene, base: np.ndarray) -> None:
    """A scene file, with where the robot stands."""
    clouds = {name: points.astype(np.float32) for name, points in scene.clouds.items()}
    about = {"up": scene.up, "fixed": sorted(scene.fixed), "viewpoints": scene.viewpoints, "robot_base": base}
    np.savez_compressed(path, **clouds, **about)
    print(f"{path}: {', '.join(clouds)}")


def main(paths: list[str], seed: int = 1) -> int:
    """Look at both tables; write them, or plan the moves and say what they are."""
    with scenario("swap", seed) as stage:
        start, goal = looked(stage, False, seed), looked(stage, True, seed)
        base = stage.pose_base_to_world
    if paths:
        for path, scene in zip(paths, (start, goal), strict=True):
            write(path, scene, base)
        return 0
    try:
        plan = topple.rearrange(start, goal, "panda", pose_base_to_world=base, verify=True, seed=seed)
    except topple.NoSafePlan as error:
        print(*error.certificate, sep="\n")
        return 1
    for step in plan.steps:
        print(f"{step.object} {step.reason}")
    Path("swap.html").write_text(plan_page(plan, start), encoding="utf-8")
    print(*plan.assumptions, sep="\n")
    print(f"{len(plan.steps)} moves, {plan.seconds:.0f} s of motion, certified: {plan.certified}")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
