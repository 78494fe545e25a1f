"""Which grasps an arm can reach."""

from collections.abc import Sequence

import numpy as np

from topple.planner.grasp.grasp import HALF_TURN, Grasp
from topple.robots.arm.arm import Arm
from topple.robots.poses import inverse
from topple.topology.base.arrays import FloatArray


def reachable(grasps: Sequence[Grasp], arm: Arm, pose_base_to_world: FloatArray) -> list[bool]:
    """Ask inverse kinematics about grasps, each with the hand turned half as well.

    Args:
        grasps: In the world.
        arm: The arm.
        pose_base_to_world: (4, 4) where it stands.

    Returns:
        For each grasp whether joint values within the limits take the tool there. What is in the arm's way
        is not asked.
    """
    world_to_base = inverse(np.asarray(pose_base_to_world, dtype=np.float64))
    found = [False] * len(grasps)
    for tool in {grasp.tool for grasp in grasps}:
        places = [place for place, grasp in enumerate(grasps) if grasp.tool == tool]
        poses = world_to_base @ np.array([grasps[place].pose_of(arm.tools[tool]) for place in places])
        both = np.stack([poses, poses @ HALF_TURN], axis=1)
        for place, yes in zip(places, arm.reaches(both, tool).tolist(), strict=True):
            found[place] = yes
    return found
