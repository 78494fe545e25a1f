"""Cans and fruit into two bins, recorded as they move: where each thing went, and what held it on the way.

python examples/sort.py [SEED]
"""

import sys

import numpy as np

from topple.planner import ClosedLoop
from topple.robots import Recording, arm_in, robot
from topple.robots.scenarios import scenario_called


def main(seed: int = 2) -> int:
    """Sort, then read the recording: nothing jumps, and nothing but friction holds what is carried."""
    with scenario_called("sort", seed) as stage:
        arm = arm_in(stage.world, robot(stage.robot), stage.pose_base_to_world)
        recording = Recording(arm)  # 60 samples a second of everything, from here on
        loop = ClosedLoop.simulated(stage.world, arm, stage.cameras, "sort", fixed=stage.fixed, seed=seed)
        record = loop.run()
        recording.stop()
    for name in recording.poses[0]:
        path = np.array([poses[name][:3, 3] for poses in recording.poses])
        ways = np.linalg.norm(np.diff(path, axis=0), axis=1)
        fastest = float((ways / np.diff(recording.times)).max())
        print(f"{name}: {ways.sum():.2f} m of way, at most {fastest:.2f} m/s, ends at {path[-1].round(2)}")
    tied = {kind.kind for sample in recording.constraints for kind in sample}
    print("constraints:", "the gear of the fingers" if tied == {"gear"} else tied)
    print(
        f"{len(recording.times)} samples of {recording.times[-1] - recording.times[0]:.0f} s; {record.goal}:"
    )
    print("reached" if record.success else record.violations)
    return 0 if record.success else 1


if __name__ == "__main__":
    sys.exit(main(*map(int, sys.argv[1:])))
