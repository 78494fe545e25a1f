"""A simulated world that is kept for one drop after the other: what stands as it stood stays in it."""

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from topple.robots.engines import rehearsal_world
from topple.topology.base.arrays import FloatArray

if TYPE_CHECKING:
    from topple.robots.world.physical_world import PhysicalWorld

Standing = tuple[Sequence[FloatArray], float]
"""Convex parts in the frame of the scene [m], and the coefficient of friction."""


class Rehearsal:
    """The world, to be used with `with`; it is made once it is needed.

    Args:
        up: (3,) unit vector.

    Attributes:
        level: (4, 4) turn from the scene's frame to that of the world.
    """

    def __init__(self, up: FloatArray) -> None:
        self.level = _levelling(up)
        self._world: PhysicalWorld | None = None
        self._there: dict[str, Standing] = {}

    def __enter__(self) -> "Rehearsal":
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """End the simulation."""
        if self._world is not None:
            self._world.close()

    def among(self, fixed: Mapping[str, Standing]) -> "PhysicalWorld":
        """The world with some bodies that hold still, by name, and nothing else."""
        from topple.robots.world.bodies import Body

        world = self._world = self._world or rehearsal_world()
        for name in [name for name, known in self._there.items() if not _same(known, fixed.get(name))]:
            world.remove(name)
            del self._there[name]
        for name, (parts, friction) in fixed.items():
            if name not in self._there:
                world.add(Body.of(name, parts, friction=friction), self.level, fixed=True)
                self._there[name] = parts, friction
        return world


def _same(one: Standing, other: Standing | None) -> bool:
    if other is None or one[1] != other[1] or len(one[0]) != len(other[0]):
        return False
    return all(a is b or np.array_equal(a, b) for a, b in zip(one[0], other[0], strict=True))


def _levelling(up: FloatArray) -> FloatArray:
    """(4, 4) turn that brings up (3,), a unit vector, to z; its transpose is its inverse."""
    axis = np.cross(up, [0.0, 0.0, 1.0])
    pose = np.eye(4)
    if np.linalg.norm(axis) < 1e-9:
        pose[:3, :3] = np.diag([1.0, np.sign(up[2]), np.sign(up[2])])
        return pose
    x = axis / np.linalg.norm(axis)
    pose[:3, :3] = np.stack([x, np.cross(up, x), up])
    return pose
