"""Frames: axes square to a direction, and axes that turn with a cloud."""

import numpy as np

from topple.topology.arrays import FloatArray

_ENOUGH = 4000
"""Points that tell how a cloud lies."""


def perpendiculars(axis: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Two unit vectors square to a direction and to each other; with it they are right-handed.

    Args:
        axis: (3,) unit vector.
    """
    first = np.cross(axis, np.eye(3)[int(np.argmin(np.abs(axis)))]).astype(np.float64)
    first /= np.linalg.norm(first)
    return first, np.cross(axis, first).astype(np.float64)


def upright_axes(up: FloatArray) -> FloatArray:
    """Axes of a frame whose z axis is `up`.

    Args:
        up: (3,) vector against gravity, any length but zero.

    Returns:
        (3, 3) rotation, rows x, y, z; the identity for up = (0, 0, 1).
    """
    z = np.asarray(up, dtype=np.float64) / np.linalg.norm(up)
    if z[2] > 1 - 1e-9:
        return np.eye(3)
    seed = np.eye(3)[int(np.argmin(np.abs(z)))]
    x = seed - (seed @ z) * z
    x /= np.linalg.norm(x)
    return np.asarray(np.stack([x, np.cross(z, x), z]), dtype=np.float64)


def own_axes(points: FloatArray, up: FloatArray | None = None) -> FloatArray:
    """Axes of a cloud that turn with it: grids laid along them cut it the same way in every frame.

    Args:
        points: (N, 3) points [m], N >= 1.
        up: (3,) unit vector that is to be the third axis; None: the direction in which the cloud is thinnest.

    Returns:
        (3, 3) rotation, rows the principal axes, widest first, each towards the longer tail of the points.
    """
    some = points[:: -(-len(points) // _ENOUGH)]
    centred = some - some.mean(axis=0)
    if up is None:
        axes = np.linalg.eigh(centred.T @ centred)[1].T[::-1]
    else:
        level = np.stack(perpendiculars(up))
        flat = centred @ level.T
        axes = np.vstack([np.linalg.eigh(flat.T @ flat)[1].T[::-1] @ level, up])
    tails = ((centred @ axes[:2].T) ** 3).sum(axis=0)
    axes[:2] *= np.where(tails < 0, -1.0, 1.0)[:, None]
    third = np.cross(axes[0], axes[1])
    if up is None:
        axes[2] = third
    elif third @ up < 0:
        axes[1] *= -1.0
    return np.asarray(axes, dtype=np.float64)
