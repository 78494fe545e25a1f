"""The vacuum of a suction cup in a world on MuJoCo."""

import numpy as np

from topple.robots.arm.cup import SuctionCup
from topple.robots.mujoco.world import MujocoWorld
from topple.robots.world.vacuum import Vacuum, lip_rays, sealed_on
from topple.topology.base.arrays import FloatArray


class MujocoVacuum(Vacuum):
    """A `Vacuum` that is a weld of MuJoCo's; see `on`."""

    def __init__(
        self, world: MujocoWorld, name: str, link: str, pose_lip_to_world: FloatArray, cup: SuctionCup
    ) -> None:
        super().__init__(world, name, pose_lip_to_world, cup)
        self._mujoco, self._link = world, link
        world.weld(name, link, pose_lip_to_world[:3, 3])

    @classmethod
    def on(
        cls, world: MujocoWorld, link: str, pose_lip_to_world: FloatArray, cup: SuctionCup
    ) -> "MujocoVacuum | None":
        """Switches the vacuum on; None where the lip seals on nothing that can be moved.

        Args:
            world: The world the robot stands in.
            link: The cup's link.
            pose_lip_to_world: (4, 4) where the lip is, z out of the hand.
            cup: Radius, force and lip depth.
        """
        start, end = lip_rays(pose_lip_to_world, cup)
        hits = [world.ray_hit(*ray, link) for ray in zip(start, end, strict=True)]
        name = sealed_on(world, hits, cup)
        return None if name is None else cls(world, name, link, pose_lip_to_world, cup)

    @property
    def sealed(self) -> bool:
        """Whether it still holds."""
        return self._mujoco.is_welded(self.name, self._link)

    def off(self) -> None:
        """Lets go."""
        self._mujoco.unweld(self.name, self._link)

    def load(self) -> tuple[FloatArray, FloatArray]:
        """Load of the object on the lip; see `Vacuum.load`."""
        force, about_middle = self._mujoco.weld_wrench(self.name, self._link)
        return -force, -(about_middle + np.cross(self._from_lip(), force))
