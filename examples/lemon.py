"""A lemon into a full bowl: a loop of one's own in a world of one's own, told what shall hold.

    python examples/lemon.py [SEED]

What has to leave the bowl first, and how much, nobody says: it follows from what is seen after each action.
"""

import sys

from topple.planner import ClosedLoop, RunLimits
from topple.robots import arm_in, robot
from topple.robots.scenarios import scenario_called


def main(seed: int = 2) -> int:
    """Put an arm into the scene, let it reach the goal and print what was not as planned."""
    with scenario_called("lemon", seed) as stage:  # a PyBullet world with a table, things and cameras
        loop = ClosedLoop.simulated(
            stage.world,
            arm_in(stage.world, robot("panda"), stage.pose_base_to_world),
            stage.cameras,
            "lemon within bowl",
            limits=RunLimits(attempts=2),
            seed=seed,
            progress=print,
        )
        record = loop.run()
    for step in record.steps:
        for event in step.events:
            print(f"{step.object}: {event}")
    taken = [step.object for step in record.steps if step.action == "remove"]
    print(f"taken out of the way: {', '.join(taken) or 'nothing'}")
    print(f"lemon within bowl: {'yes' if record.success else record.violations}")
    return 0 if record.success else 1


if __name__ == "__main__":
    sys.exit(main(*map(int, sys.argv[1:])))
