"""A fixture in a world on MuJoCo: what keeps bodies where they are until it lets go of them."""

from collections.abc import Collection

import numpy as np

from topple.robots.mujoco.world import MujocoWorld
from topple.topology.errors import UnknownObject


class MujocoClamps:
    """Clamps on some bodies of a world; a `topple.robots.driver.Fixture`.

    Args:
        world: The world.
        names: The bodies, as they are now.

    Raises:
        UnknownObject: There is no such body that can move.
    """

    def __init__(self, world: MujocoWorld, names: Collection[str]) -> None:
        self._world, self._names = world, set(names)
        for name in sorted(names):
            if name not in world.movable:
                raise UnknownObject(name, world.movable)
        for name in sorted(names):
            pose = world.pose(name)
            middle = pose @ np.append(world.body(name).centre_of_mass, 1.0)
            world.weld(name, None, middle[:3])

    @property
    def clamped(self) -> frozenset[str]:
        """What they keep."""
        return frozenset(self._names)

    def release(self, name: str) -> None:
        """Let go of a body; of one that they do not keep, nothing happens."""
        if name in self._names:
            self._names.remove(name)
            self._world.unweld(name, None)
