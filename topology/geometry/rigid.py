"""Rigid transforms of points."""

from topple.topology.arrays import FloatArray


def transformed(points: FloatArray, pose: FloatArray) -> FloatArray:
    """Move points by a rigid transform.

    Args:
        points: (..., 3) points [m].
        pose: (4, 4) pose of the frame they are in, in the frame they shall be in.

    Returns:
        (..., 3) the same points in that frame [m].
    """
    return points @ pose[:3, :3].T + pose[:3, 3]
