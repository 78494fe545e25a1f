"""A fixture: what keeps bodies of a world where they are, as a vice does, until it lets go of them."""

from collections.abc import Collection
from typing import Any

from topple.robots.engine import pybullet
from topple.robots.world.physical_world import PhysicalWorld
from topple.robots.world.tolerances import CLAMPING, CONSTRAINT_ERP
from topple.robots.world.world import in_bullet
from topple.topology.errors import UnknownObject


class Clamps:
    """Clamps on some bodies of a world; a `topple.robots.driver.Fixture`.

    Args:
        world: The world, which PyBullet plays.
        names: The bodies, as they are now.

    Raises:
        InvalidInput: Another engine plays the world.
        UnknownObject: There is no such body that can move.
    """

    def __init__(self, world: PhysicalWorld, names: Collection[str]) -> None:
        self._world = in_bullet(world)
        for name in sorted(names):
            if name not in world.movable:
                raise UnknownObject(name, world.movable)
        self._grips = {name: self._clamp(name) for name in sorted(names)}

    @property
    def clamped(self) -> frozenset[str]:
        """What they keep."""
        return frozenset(self._grips)

    def release(self, name: str) -> None:
        """Let go of a body; of one that they do not keep, nothing happens."""
        if (found := self._grips.pop(name, None)) is not None:
            clamp, grip = found
            pybullet.removeConstraint(grip, physicsClientId=self._world.client)
            pybullet.removeBody(clamp, physicsClientId=self._world.client)

    def _clamp(self, name: str) -> tuple[int, int]:
        """PyBullet's numbers of a clamp, a body without a shape that never moves, and of its grip.

        The grip yields to a weight until what it makes up for in a step is what that adds: it is as much too
        high before.
        """
        world = self._world
        at, turned = self._where(name)
        sag = world.physics.gravity * world.time_step**2 / CONSTRAINT_ERP
        clamp: int = pybullet.createMultiBody(
            0.0,
            basePosition=[at[0], at[1], at[2] + sag],
            baseOrientation=turned,
            physicsClientId=world.client,
        )
        grip: int = pybullet.createConstraint(
            clamp, -1, world.ids[name], -1, pybullet.JOINT_FIXED, [0, 0, 0], [0, 0, 0], [0, 0, 0],
            physicsClientId=world.client,
        )  # fmt: skip
        pybullet.changeConstraint(grip, maxForce=CLAMPING, physicsClientId=world.client)
        return clamp, grip

    def _where(self, name: str) -> Any:
        """Position and quaternion of a body's centre of mass."""
        return pybullet.getBasePositionAndOrientation(
            self._world.ids[name], physicsClientId=self._world.client
        )
