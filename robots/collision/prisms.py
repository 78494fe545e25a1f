"""Upright prisms of a hand: what sweeps space when it comes in along the approach."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from topple.robots.collision.convex import section
from topple.topology.base.arrays import FloatArray


@dataclass(frozen=True)
class Prism:
    """A box of the hand with everything behind it: what sweeps space when the hand comes in along z.

    Attributes:
        x: Lower and upper bound along the tool's x [m].
        y: Lower and upper bound along y [m]; for a finger measured from its pad's face, outwards.
        front: Foremost extent along z [m].
    """

    x: tuple[float, float]
    y: tuple[float, float]
    front: float


def prisms(vertices: FloatArray, slabs: tuple[float, ...]) -> tuple[Prism, ...]:
    """Cut a convex body in slabs behind its foremost point and box each of them.

    Args:
        vertices: (V, 3) vertices of a convex body in the tool frame [m].
        slabs: Thickness of each slab, from the front backwards [m]; the last prism takes the rest.

    Returns:
        One prism per slab that is not empty.
    """
    low, front = float(vertices[:, 2].min()), float(vertices[:, 2].max())
    cuts = [front - float(depth) for depth in np.cumsum([0.0, *slabs]) if front - depth > low] + [low]
    found: list[Prism] = []
    for upper, lower in pairwise(cuts):
        inside = vertices[(vertices[:, 2] <= upper + 1e-9) & (vertices[:, 2] >= lower - 1e-9)]
        piece = np.vstack([inside, section(vertices, upper), section(vertices, lower)])
        if len(piece) > 0:
            (x0, y0), (x1, y1) = piece[:, :2].min(axis=0), piece[:, :2].max(axis=0)
            found.append(Prism((float(x0), float(x1)), (float(y0), float(y1)), upper))
    return tuple(found)


def fill_prisms(prisms: Sequence[Prism], length: float, layers: int) -> FloatArray:
    """Points (N, 3) in prisms, from their fronts some metres back [m]."""
    grids = [
        np.meshgrid(
            np.linspace(*prism.x, 3), np.linspace(*prism.y, 3), prism.front - np.linspace(0.0, length, layers)
        )
        for prism in prisms
    ]
    return np.vstack([np.column_stack([axis.ravel() for axis in grid]) for grid in grids])
