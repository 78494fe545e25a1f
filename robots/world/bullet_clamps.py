"""A fixture in a world on PyBullet."""

from collections.abc import Collection
from typing import Any

from topple.robots.engine import pybullet
from topple.robots.world.clamps import Clamps
from topple.robots.world.physical_world import PhysicalWorld
from topple.robots.world.tolerances import CLAMPING, CONSTRAINT_ERP
from topple.robots.world.world import in_bullet


class BulletClamps(Clamps[tuple[int, int]]):
    """`Clamps` in a world that PyBullet plays: constraints that hold up to `CLAMPING`.

    Raises:
        InvalidInput: Another engine plays the world.
    """

    def __init__(self, world: PhysicalWorld, names: Collection[str]) -> None:
        self._world = in_bullet(world)
        super().__init__(world, names)

    def _let_go(self, name: str, grip: tuple[int, int]) -> None:
        self._world.sleep.wake()
        clamp, constraint = grip
        pybullet.removeConstraint(constraint, physicsClientId=self._world.client)
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
