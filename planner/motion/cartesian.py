"""Straight ways of the tool (approach, lift, retreat): inverse kinematics from waypoint to waypoint."""

import numpy as np

from topple.planner.motion.tolerances import JUMP, SPACING, TURN
from topple.robots.arm.arm import Arm
from topple.robots.arm.gripper import FINGERS
from topple.robots.arm.inverse import InverseTolerances, solve
from topple.robots.arm.kinematics import rotation_vectors
from topple.topology.base.arrays import FloatArray

CONTINUED = InverseTolerances(iterations=16, step=0.2)  # the start is close: few and short steps


def straight_lines(
    arm: Arm, q_start: FloatArray, poses_tool_to_base: FloatArray, tool: str = FINGERS
) -> list[FloatArray | None]:
    """Move a tool along many straight lines, each on its own: kinematics alone, one batch for each waypoint.

    Args:
        arm: The arm.
        q_start: (m, n) states to start from.
        poses_tool_to_base: (m, 4, 4) poses at the ends.
        tool: The tool that moves.

    Returns:
        For each line its (k, n) joint path, or None where the arm cannot follow.
    """
    starts = arm.tool_pose(q_start, tool)
    held = arm.tool_to_flange(tool)
    to_flange = np.linalg.inv(held)
    lines = [np.matmul(_line(a, b), to_flange) for a, b in zip(starts, poses_tool_to_base, strict=True)]
    paths = [[np.asarray(q, dtype=np.float64)] for q in q_start]
    following = list(range(len(lines)))
    for waypoint in range(1, max((len(line) for line in lines), default=0)):
        following = [k for k in following if len(paths[k]) == waypoint]
        moving = [k for k in following if len(lines[k]) > waypoint]
        if not moving:
            break
        targets = np.array([lines[k][waypoint] for k in moving])
        seeds = np.array([paths[k][-1] for k in moving])[:, None, :]
        found, owners = solve(arm.chain, targets, seeds, CONTINUED, tool_point=held[:3, 3])
        for q, owner in zip(found, owners, strict=True):
            if np.abs(q - seeds[owner, 0]).max() <= JUMP:
                paths[moving[int(owner)]].append(q)
    return [np.array(p) if len(p) == len(line) else None for p, line in zip(paths, lines, strict=True)]


def _line(start: FloatArray, end: FloatArray) -> FloatArray:
    """Poses from start to end, (k, 4, 4), evenly spaced in place and turn."""
    from scipy.spatial.transform import Rotation

    turn = rotation_vectors((end[:3, :3] @ start[:3, :3].T)[None])[0]
    way = end[:3, 3] - start[:3, 3]
    count = max(int(np.ceil(max(np.linalg.norm(way) / SPACING, np.linalg.norm(turn) / TURN))), 1)
    t = np.linspace(0.0, 1.0, count + 1)
    poses = np.tile(np.eye(4), (count + 1, 1, 1))
    poses[:, :3, 3] = start[:3, 3] + t[:, None] * way
    poses[:, :3, :3] = np.matmul(Rotation.from_rotvec(t[:, None] * turn).as_matrix(), start[:3, :3])
    return poses
