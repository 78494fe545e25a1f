"""Vessels: closed stacks of rings, watertight, with convex parts that are exact: one per sector of a wall."""

from collections.abc import Sequence

import numpy as np

from topple.topology.base.arrays import FloatArray
from topple.topology.scene.mesh import Mesh


def circle(sides: int) -> FloatArray:
    """Corners (sides, 2) of a regular polygon in the unit circle."""
    angles = np.arange(sides) * (2 * np.pi / sides)
    return np.stack([np.cos(angles), np.sin(angles)], axis=1)


def rings(outline: FloatArray, profile: Sequence[tuple[float, float]]) -> FloatArray:
    """Copies of an outline, scaled and lifted along a profile.

    Args:
        outline: (N, 2) corners, counterclockwise.
        profile: Radius (scale of the outline) and height of each ring in [m].

    Returns:
        (R, N, 3) corners of the rings in [m].
    """
    stacked = np.empty((len(profile), len(outline), 3))
    for ring, (radius, height) in zip(stacked, profile, strict=True):
        ring[:, :2] = outline * radius
        ring[:, 2] = height
    return stacked


def closed_surface(stack: FloatArray) -> Mesh:
    """Skin of a stack of rings, from a cap on the first, outside and under, to a cap on the last, on top.

    Args:
        stack: (R, N, 3) corners in [m].

    Returns:
        A watertight mesh, faces counterclockwise seen from outside.
    """
    count, sides = stack.shape[:2]
    column = np.arange(sides)
    after = (column + 1) % sides
    faces: list[FloatArray] = []
    for ring in range(count - 1):
        low, high = ring * sides, (ring + 1) * sides
        faces.append(np.stack([low + column, low + after, high + after], axis=1))
        faces.append(np.stack([low + column, high + after, high + column], axis=1))
    fan = np.arange(1, sides - 1)
    last = (count - 1) * sides
    faces.append(np.stack([np.zeros_like(fan), fan + 1, fan], axis=1))
    faces.append(np.stack([last + np.zeros_like(fan), last + fan, last + fan + 1], axis=1))
    return Mesh(stack.reshape(-1, 3), np.concatenate(faces).astype(np.int64))


def sectors(stack: FloatArray, members: Sequence[int]) -> list[FloatArray]:
    """Convex parts of a wall: what lies between two neighbouring columns of some rings.

    Args:
        stack: (R, N, 3) corners in [m].
        members: Rings whose corners make a convex section of the wall.

    Returns:
        N vertex sets (2 M, 3).
    """
    chosen = stack[list(members)]
    return [
        np.concatenate([chosen[:, column], chosen[:, (column + 1) % stack.shape[1]]])
        for column in range(stack.shape[1])
    ]


def disc(stack: FloatArray, members: Sequence[int]) -> FloatArray:
    """One convex part (M N, 3) of all corners of some rings."""
    return stack[list(members)].reshape(-1, 3)
