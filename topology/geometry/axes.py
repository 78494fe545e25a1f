"""Frames: axes square to a direction, and axes that turn with a cloud."""

import numpy as np

from topple.topology.base.arrays import FloatArray, middle_of
from topple.topology.geometry.tolerances import ENOUGH


def perpendiculars(axis: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Two unit vectors square to a direction and to each other; with it they are right-handed.

    Args:
        axis: (3,) unit vector.
    """
    first = cross(axis, np.eye(3)[int(np.argmin(np.abs(axis)))])
    first /= np.linalg.norm(first)
    return first, cross(axis, first)


def around(count: int) -> FloatArray:
    """(count, 2) unit vectors evenly around in the plane, the first along x."""
    angles = np.arange(count) * np.pi / (count / 2)
    return np.stack([np.cos(angles), np.sin(angles)], axis=1)


def level_axes(up: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Two unit vectors that span the level plane.

    Args:
        up: (3,) unit vector.

    Returns:
        x and y with x cross y = up; the world's x and y where up is its z.
    """
    y = np.array([0.0, 1.0, 0.0]) if abs(up[1]) < 0.9 else np.array([0.0, 0.0, 1.0])
    x = cross(y, up)
    x /= np.linalg.norm(x)
    return x, cross(up, x)


def cross(a: FloatArray, b: FloatArray) -> FloatArray:
    """Cross products of vectors (..., 3): of few numpy's takes many times as long."""
    if a.ndim == b.ndim == 1:
        (ax, ay, az), (bx, by, bz) = a.tolist(), b.tolist()
        return np.array([ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx])
    (ax, ay, az), (bx, by, bz) = (each.transpose(-1, *range(each.ndim - 1)) for each in (a, b))
    return np.stack([ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx], axis=-1)


def own_axes(points: FloatArray) -> FloatArray:
    """Axes of a cloud that turn with it: grids laid along them cut it the same way in every frame.

    Args:
        points: (N, 3) points [m], N >= 1.

    Returns:
        (3, 3) rotation, rows the principal axes, widest first, each towards the longer tail of the points.
    """
    some = points[:: -(-len(points) // ENOUGH)]
    centred = some - middle_of(some)
    axes = np.linalg.eigh(centred.T @ centred)[1].T[::-1]
    far = centred @ axes.T
    tails = np.einsum("ni->i", far * far * far)
    axes = np.where(tails < 0, -1.0, 1.0)[:, None] * axes
    axes[2] = cross(axes[0], axes[1])
    return axes
