"""Straight ways of the tool (approach, lift, retreat): inverse kinematics from waypoint to waypoint."""

import numpy as np

from topple.planner.motion.collision import Checker
from topple.robots.arm import Arm
from topple.robots.inverse import InverseTolerances, solve
from topple.robots.kinematics import rotation_vectors
from topple.topology.arrays import FloatArray

SPACING = 0.01  # [m] between waypoints: the tool strays less than 0.1 mm from the line in between
TURN = 0.05  # [rad] between waypoints where the tool also turns
JUMP = 0.25  # [rad] largest joint change between waypoints; more means another branch of solutions
CONTINUED = InverseTolerances(iterations=16, step=0.2)  # the start is close: few and short steps


def straight_line(
    arm: Arm,
    checker: Checker | None,
    q_start: FloatArray,
    pose_tool_to_base: FloatArray,
    tool: str = "fingers",
) -> FloatArray | None:
    """Move a tool straight to a pose, turning it evenly on the way.

    Args:
        arm: The arm.
        checker: What may not be hit; None to ask for kinematics alone.
        q_start: (n,) state to start from; it is checked too.
        pose_tool_to_base: (4, 4) pose at the end.
        tool: The tool that moves.

    Returns:
        (k, n) joint path, or None where the arm cannot follow or would hit something.
    """
    targets = _line(arm.tool_pose(q_start, tool)[0], pose_tool_to_base)
    flange = np.matmul(targets, np.linalg.inv(arm.tool_to_flange(tool)))
    path = [np.asarray(q_start, dtype=float)]
    for target in flange[1:]:
        found, _ = solve(arm.chain, target[None], path[-1][None], CONTINUED)
        if not len(found) or np.abs(found[0] - path[-1]).max() > JUMP:
            return None
        path.append(found[0])
    result = np.array(path)
    if checker is not None and not checker.edges_free(result[:-1], result[1:], step=0.01).all():
        return None
    return result


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
