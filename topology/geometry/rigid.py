"""Rigid transforms of points."""

import numpy as np

from topple.topology.base.arrays import FloatArray


def move_points(points: FloatArray, pose: FloatArray) -> FloatArray:
    """Move points by a rigid transform.

    Args:
        points: (..., 3) points [m].
        pose: (4, 4) pose of the frame they are in, in the frame they shall be in.

    Returns:
        (..., 3) the same points in that frame [m].
    """
    return points @ pose[:3, :3].T + pose[:3, 3]


def turned_to(rotation: FloatArray, here: FloatArray, there: FloatArray) -> FloatArray:
    """The rigid transform that turns, and brings one place to another: about a point where both are that.

    Args:
        rotation: (3, 3).
        here: (3,) a place [m].
        there: (3,) where it comes to [m].

    Returns:
        (4, 4).
    """
    pose = np.eye(4)
    pose[:3, :3], pose[:3, 3] = rotation, there - rotation @ here
    return pose
