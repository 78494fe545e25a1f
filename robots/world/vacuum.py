"""A suction cup that holds as a real one does: where its lip seals, and no more than its vacuum pulls."""

from abc import ABC, abstractmethod

import numpy as np

from topple.robots.arm.gripper import SuctionCup, lip_plane, vacuum_load
from topple.robots.poses import inverse
from topple.robots.world.physical_world import PhysicalWorld
from topple.robots.world.tolerances import AT_LIMIT, CLEAR, PEEL_STEPS, RAYS, REACH, TILT
from topple.topology.arrays import FloatArray
from topple.topology.geometry.rigid import transformed


class Vacuum(ABC):
    """A cup that has taken an object.

    The hold is a constraint whose forces are read after every step: what `vacuum_load` says the lip does not
    hold breaks it.

    Args:
        world: The world both are in.
        name: The object it holds.
        pose_lip_to_world: (4, 4) where the lip is, z out of the hand.
        cup: Force, radius and friction.
    """

    def __init__(
        self, world: PhysicalWorld, name: str, pose_lip_to_world: FloatArray, cup: SuctionCup
    ) -> None:
        self.name, self.cup = name, cup
        self.world = world
        there = inverse(world.pose(name))
        self._axis: FloatArray = there[:3, :3] @ pose_lip_to_world[:3, 2]
        self._lip: FloatArray = there[:3, :3] @ pose_lip_to_world[:3, 3] + there[:3, 3]
        self._over = 0

    @property
    @abstractmethod
    def sealed(self) -> bool:
        """Whether it still holds."""

    @abstractmethod
    def off(self) -> None:
        """Lets go."""

    @abstractmethod
    def _load(self) -> tuple[FloatArray, FloatArray]:
        """What the object does to the lip in the last step.

        Returns:
            Force (3,) [N] and moment (3,) [N m] about the lip's centre, in the world's axes.
        """

    def _from_lip(self) -> FloatArray:
        """The way (3,) from the lip's centre to the object's centre of mass, in the world's axes [m]."""
        middle = self.world.body(self.name).centre_of_mass
        return np.asarray(self.world.pose(self.name)[:3, :3] @ (middle - self._lip))

    def check(self) -> None:
        """Reads the forces of the last step and lets go where they were too much for too long."""
        if not self.sealed:
            return
        force, moment = self._load()
        out = self.world.pose(self.name)[:3, :3] @ self._axis
        pull = float(force @ out)
        twist = float(moment @ out)
        shear = float(np.linalg.norm(force - pull * out))
        bending = float(np.linalg.norm(moment - twist * out))
        cup = self.cup
        load = vacuum_load(
            pull, shear, bending, twist, force=cup.max_force, radius=cup.radius, friction=cup.friction
        )
        self._over = self._over + 1 if load >= AT_LIMIT else 0
        if self._over >= PEEL_STEPS:
            self.off()


def lip_ring(cup: SuctionCup) -> FloatArray:
    """(k, 2) places just outside a lip, around its centre [m]."""
    angle = np.linspace(0.0, 2 * np.pi, RAYS, endpoint=False)
    return np.asarray((cup.radius + CLEAR) * np.column_stack([np.cos(angle), np.sin(angle)]))


def lip_rays(pose_lip_to_world: FloatArray, cup: SuctionCup) -> tuple[FloatArray, FloatArray]:
    """Where the rays around a lip begin, `REACH` behind it, and end, as far before it.

    Args:
        pose_lip_to_world: (4, 4) where the lip is, z out of the hand.
        cup: Its radius.

    Returns:
        (k, 3) each, in the world [m].
    """
    ring = lip_ring(cup)
    behind, before = (np.column_stack([ring, np.full(RAYS, z)]) for z in (-REACH, REACH))
    return transformed(behind, pose_lip_to_world), transformed(before, pose_lip_to_world)


def follows(heights: FloatArray, cup: SuctionCup) -> bool:
    """Whether a lip can follow what its rays met.

    What stands out of their plane within the lip holds the cup off, and the plane is then too far away.

    Args:
        heights: (k,) of what each ray met before the lip [m].
        cup: Its radius and what it bridges.
    """
    plane, uneven = lip_plane(lip_ring(cup), heights)
    return bool(max(uneven, abs(plane[2])) <= cup.lip_depth and np.hypot(plane[0], plane[1]) <= np.tan(TILT))
