"""Convex parts as python-fcl has them."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from topple.robots.collision.convex import hull_of
from topple.topology.base.arrays import FloatArray


def fcl_convex(points: FloatArray) -> Any:
    """The hull of (N, 3) points [m] as an `fcl.Convex`; a flat one is thickened by 0.1 mm."""
    import fcl

    corners, faces = hull_of(points)
    packed = np.column_stack([np.full(len(faces), 3), faces]).ravel()
    return fcl.Convex(corners, len(faces), packed)


def fcl_body(points: FloatArray) -> Any:
    """The hull of (N, 3) points [m] as an `fcl.CollisionObject`, where the points have it."""
    import fcl

    return fcl.CollisionObject(fcl_convex(points))


def apart(a: Sequence[FloatArray], b: Sequence[FloatArray], distance: float) -> bool:
    """Whether two objects keep a distance.

    Args:
        a: Convex parts of the one, (V, 3) vertices each [m].
        b: Of the other.
        distance: The distance [m].

    Returns:
        True where no two parts come closer.
    """
    import fcl

    near = [
        (part, other)
        for part in a
        for other in b
        if (np.maximum(part.min(axis=0), other.min(axis=0)) - distance
            < np.minimum(part.max(axis=0), other.max(axis=0))).all()
    ]  # fmt: skip
    asked = fcl.DistanceRequest()
    return all(fcl.distance(fcl_body(part), fcl_body(other), asked) >= distance for part, other in near)
