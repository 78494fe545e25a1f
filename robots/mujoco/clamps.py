"""A fixture in a world on MuJoCo."""

from collections.abc import Collection

import numpy as np

from topple.robots.mujoco.world import MujocoWorld
from topple.robots.world.clamps import Clamps


class MujocoClamps(Clamps[None]):
    """`Clamps` in a world on MuJoCo: welds to the world, which hold whatever pulls."""

    def __init__(self, world: MujocoWorld, names: Collection[str]) -> None:
        self._world = world
        super().__init__(world, names)

    def _clamp(self, name: str) -> None:
        middle = self._world.pose(name) @ np.append(self._world.body(name).centre_of_mass, 1.0)
        self._world.weld(name, None, middle[:3])

    def _let_go(self, name: str, grip: None) -> None:
        del grip
        self._world.unweld(name, None)
