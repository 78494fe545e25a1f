"""A suction cup that holds as a real one does: where its lip seals, and no more than its vacuum pulls."""

from abc import ABC, abstractmethod
from collections.abc import Sequence

import numpy as np

from topple.robots.arm.cup import SuctionCup, lip_plane, vacuum_load
from topple.robots.poses import inverse
from topple.robots.world.physical_world import PhysicalWorld
from topple.robots.world.tolerances import AT_LIMIT, CLEAR, PEEL_STEPS, RAYS, REACH, TILT
from topple.topology.base.arrays import FloatArray
from topple.topology.geometry.rigid import move_points


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
    def load(self) -> tuple[FloatArray, FloatArray]:
        """Load of the object on the lip in the last step.

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
        force, moment = self.load()
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


def lip_rays(pose_lip_to_world: FloatArray, cup: SuctionCup) -> tuple[FloatArray, FloatArray]:
    """Rays just outside a lip, along its axis, from `REACH` behind it to as far before it.

    Args:
        pose_lip_to_world: (4, 4) where the lip is, z out of the hand.
        cup: Its radius.

    Returns:
        Where they begin and where they end, (k, 3) each, in the world [m].
    """
    ring = _ring(cup)
    behind, before = (np.column_stack([ring, np.full(RAYS, z)]) for z in (-REACH, REACH))
    return move_points(behind, pose_lip_to_world), move_points(before, pose_lip_to_world)


def sealed_on(world: PhysicalWorld, hits: Sequence[tuple[str | None, float]], cup: SuctionCup) -> str | None:
    """The body that a lip seals on: all rays meet it, in a plane that the lip can follow.

    What stands out of that plane within the lip holds the cup off, and the plane is then too far away.

    Args:
        world: The world.
        hits: For each of `lip_rays` the body that it meets first, and the share of its way until there.
        cup: Its radius and what it bridges.

    Returns:
        A body that can move; None where there is none.
    """
    (name, _), *others = hits
    if name is None or name not in world.movable or any(other != name for other, _ in others):
        return None
    heights = np.array([share * 2 * REACH - REACH for _, share in hits])
    plane, uneven = lip_plane(_ring(cup), heights)
    flat = max(uneven, abs(plane[2])) <= cup.lip_depth and np.hypot(plane[0], plane[1]) <= np.tan(TILT)
    return name if flat else None


def _ring(cup: SuctionCup) -> FloatArray:
    """(k, 2) places just outside a lip, around its centre [m]."""
    angle = np.linspace(0.0, 2 * np.pi, RAYS, endpoint=False)
    return np.asarray((cup.radius + CLEAR) * np.column_stack([np.cos(angle), np.sin(angle)]))
