"""Which grasps an arm can reach."""

from collections.abc import Sequence

import numpy as np

from topple.planner.grasp.grasp import Grasp
from topple.robots.arm import Arm
from topple.robots.poses import inverse
from topple.topology.arrays import FloatArray


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
        both = [pose for place in places for pose in (grasps[place], grasps[place].turned())]
        solved = arm.inverse(world_to_base @ np.array([grasp.pose_tool_to_world for grasp in both]), tool)
        for k, place in enumerate(places):
            found[place] = len(solved[2 * k]) > 0 or len(solved[2 * k + 1]) > 0
    return found
