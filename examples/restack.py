"""Two towers of blocks become two others: a closed loop that is shown the finished towers.

python examples/restack.py [SEED]
"""

import sys

import numpy as np

from topple.planner import Arrangement, ArrangementTask, ClosedLoop, Observer
from topple.robots import arm_in, robot
from topple.robots.scenarios import scenario_called


def main(seed: int = 1) -> int:
    """Play the scene, and say what was done and how it ended."""
    with scenario_called("restack", seed) as stage:
        assert stage.finished is not None
        eyes = Observer(stage.finished, stage.cameras, np.random.default_rng(seed), stage.fixed)
        towers = Arrangement(eyes.look().scene)
        print("to build:", ", ".join(towers.built.order))
        arm = arm_in(stage.world, robot("panda"), stage.pose_base_to_world)
        loop = ClosedLoop.simulated(
            stage.world, arm, stage.cameras, ArrangementTask(towers), seed=seed, wanted=stage.finished.poses()
        )
        record = loop.run()
    for step in record.steps:
        print(f"{step.action} {step.object}: {step.reason}")
    print(*record.violations, sep="\n")
    print(f"{len(record.steps)} moves:", "done, nothing disturbed" if record.success else "not done")
    return 0 if record.success else 1


if __name__ == "__main__":
    sys.exit(main(*map(int, sys.argv[1:])))
