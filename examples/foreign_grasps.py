"""Grasps of another pipeline, put into a safe order: which may be done now, which later, which never.

    python examples/foreign_grasps.py [FILE]

FILE is what a grasp network writes (GraspNet, Contact-GraspNet, isaac_grasp, plain poses). Without one,
grasps are made here as a network might propose them that knows no gravity: from above, all over the scene.
From a shell: topple rank SCENE FILE --robot panda.
"""

import sys
from collections import Counter

import numpy as np

from topple.planner import ForeignGrasps, Observer, grasps_from_array, rank_grasps, read_grasps
from topple.robots.scenarios import scenario_called
from topple.topology import Scene


def proposed(scene: Scene, count: int = 60) -> ForeignGrasps:
    """Poses (N, 4, 4) of a hand that comes from above, at random points of the things."""
    rng = np.random.default_rng(0)
    points = np.concatenate([scene.clouds[name] for name in scene.movable])
    poses = np.tile(np.diag([1.0, -1.0, -1.0, 1.0]), (count, 1, 1))
    poses[:, :3, 3] = rng.choice(points, count) - [0.0, 0.0, 0.01]
    turns = rng.uniform(0, np.pi, count)
    poses[:, 0, 0], poses[:, 0, 1] = np.cos(turns), np.sin(turns)
    poses[:, 1, 0], poses[:, 1, 1] = np.sin(turns), -np.cos(turns)
    return grasps_from_array(poses)


def main(path: str | None = None, seed: int = 0) -> int:
    """Rank the grasps and say what speaks against those that cannot be done now."""
    with scenario_called("dishes", seed) as stage:
        eyes = Observer(stage.world, stage.cameras, np.random.default_rng(seed), stage.fixed)
        scene, base = eyes.look().scene, stage.pose_base_to_world
    ranked = rank_grasps(
        scene, proposed(scene) if path is None else read_grasps(path), "panda", pose_base_to_world=base
    )
    for found in ranked[:5]:
        print(f"grasp {found.index} of {found.grasp.object or 'nothing'}: {found.dropped or 'now'}")
    print(f"{sum(g.dropped is None for g in ranked)} of {len(ranked)} can be done now")
    for reason, times in Counter(g.dropped for g in ranked if g.dropped).most_common(4):
        print(f"{times} x {reason}")
    return 0


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
