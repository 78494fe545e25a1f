"""The same pile seen by one camera and by three: what hidden sides cost, and the target freed all the same.

    python examples/pile.py [SEED] [CAMERAS]

Masks of a segmentation end some pixels off; CAMERAS (1) of them look on while the arm works on pile SEED (3).
"""

import sys

import numpy as np

from topple.planner import ClosedLoop, Observer, order
from topple.robots import arm_in, robot
from topple.robots.scenarios import scenario_called

MASKS = 1.0  # [pixels] standard deviation of the edges of the masks


def main(seed: int = 3, count: int = 1) -> int:
    """Compare the orders, then let the arm decide from what the cameras see after each action."""
    with scenario_called("pile", seed) as stage:
        cameras = [camera.with_mask_noise(MASKS) for camera in stage.cameras]
        for number in (3, 1):
            eyes = Observer(stage.world, cameras[:number], np.random.default_rng(seed), stage.fixed)
            look = eyes.look()
            found = order(look.scene, stage.targets, relations=look.relations)
            hidden = sum(not pair.observed for pair in look.relations.pairs)
            said = f"{hidden} pairs not seen well; {stage.goal}: {', '.join(found.order)}"
            print(f"{number} camera{'s' if number > 1 else ''}: {said}")
        arm = arm_in(stage.world, robot(stage.robot), stage.pose_base_to_world)
        record = ClosedLoop.simulated(stage.world, arm, cameras[:count], stage.goal, seed=seed).run()
    for step in record.steps:
        print(f"{step.action} {step.object}, {len(step.disturbed)} others watched", *step.events, sep="\n  ")
    print(f"{record.goal}: {'reached' if record.success else record.violations}")
    return 0 if record.success else 1


if __name__ == "__main__":
    sys.exit(main(*map(int, sys.argv[1:])))
