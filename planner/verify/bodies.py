"""The bodies that a plan was made with, and how poses are held against each other."""

import numpy as np

from topple.planner.formats.plan_structs import PlanData
from topple.robots.arm.arm import Arm
from topple.robots.poses import angle_between
from topple.topology.base.arrays import FloatArray


def tool_poses(arm: Arm, plan: PlanData, tool: str, states: FloatArray) -> FloatArray:
    """Poses (m, 4, 4) of a tool in the world."""
    return np.matmul(np.array(plan.pose_base_to_world), arm.tool_pose(states, tool))


def off_by(a: FloatArray, b: FloatArray) -> float:
    """How far two poses (4, 4) are apart: metres, or a tenth of the angle [rad] where that is more."""
    return max(float(np.linalg.norm(a[:3, 3] - b[:3, 3])), angle_between(a, b) / 10.0)


def parts_of(plan: PlanData) -> dict[str, list[FloatArray]]:
    """Convex parts (V, 3) of every object, where it was when the plan began [m]."""
    return {thing.name: [np.array(part) for part in thing.parts] for thing in plan.objects}


def completed_of(plan: PlanData) -> dict[str, list[FloatArray]]:
    """The same with the hidden sides [m]."""
    return {thing.name: [np.array(part) for part in thing.whole or thing.parts] for thing in plan.objects}
