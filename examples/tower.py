"""Red on green on blue: the whole sequence as data, before anything moves.

python examples/tower.py [SEED]
"""

import sys

import numpy as np

from topple.planner import NoSafePlan, Observer, plan
from topple.planner.export import export
from topple.robots.scenarios import scenario_called


def main(seed: int = 2) -> int:
    """Look once, plan, and print what a controller would be sent."""
    with scenario_called("tower", seed) as stage:
        eyes = Observer(stage.world, stage.cameras, np.random.default_rng(seed), stage.fixed)
        scene, base = eyes.look().scene, stage.pose_base_to_world
    try:
        found = plan(scene, "red on green on blue", "panda", base=base, seed=seed)
    except NoSafePlan as error:
        print(*error.certificate, sep="\n")
        return 1
    for step in found.steps:
        print(f"{step.action} {step.object}: {step.reason}")
        for segment in step.segments:
            points = 0 if segment.motion is None else len(segment.motion.times)
            print(f"  {segment.kind:9} {points:4} joint states")
    print(f"{found.seconds:.0f} s of motion")
    print(export(found, "bt").splitlines()[0])
    return 0


if __name__ == "__main__":
    sys.exit(main(*map(int, sys.argv[1:])))
