"""The vacuum of a suction cup in a world on PyBullet."""

from typing import Any

import numpy as np

from topple.robots.arm.cup import SuctionCup
from topple.robots.engine import pybullet
from topple.robots.poses import inverse, pose_from, position_and_quaternion
from topple.robots.world.tolerances import CONSTRAINT_ERP
from topple.robots.world.vacuum import Vacuum, lip_rays, sealed_on
from topple.robots.world.world import World
from topple.topology.base.arrays import FloatArray


class BulletVacuum(Vacuum):
    """A `Vacuum` that is a constraint of PyBullet's; see `on`."""

    def __init__(
        self, world: World, name: str, pose_lip_to_world: FloatArray, cup: SuctionCup, constraint: int
    ) -> None:
        super().__init__(world, name, pose_lip_to_world, cup)
        self._bullet = world
        self._constraint: int | None = constraint

    @property
    def sealed(self) -> bool:
        """Whether it still holds."""
        return self._constraint is not None

    @classmethod
    def on(
        cls, world: World, robot: int, link: int, pose_lip_to_world: FloatArray, cup: SuctionCup
    ) -> "BulletVacuum | None":
        """Switches the vacuum on; None where the lip seals on nothing that can be moved.

        Args:
            world: The world the robot stands in.
            robot: PyBullet's number of the robot.
            link: Index of the cup's link.
            pose_lip_to_world: (4, 4) where the lip is, z out of the hand.
            cup: Radius, force and lip depth.
        """
        start, end = lip_rays(pose_lip_to_world, cup)
        rays: Any = pybullet.rayTestBatch(start.tolist(), end.tolist(), physicsClientId=world.client)
        name = sealed_on(world, [(world.name_of(ray[0]), ray[2]) for ray in rays], cup)
        if name is None:
            return None
        state: Any = pybullet.getLinkState(
            robot, link, computeForwardKinematics=1, physicsClientId=world.client
        )
        pose_object = pose_from(
            *pybullet.getBasePositionAndOrientation(world.ids[name], physicsClientId=world.client)
        )
        world.sleep.wake()
        # Bullet's constraints see gravity a step late: what hangs on one sags, and would be pushed down first
        pose_object[2, 3] += world.physics.gravity * world.time_step**2 / CONSTRAINT_ERP
        position, quaternion = position_and_quaternion(inverse(pose_from(state[0], state[1])) @ pose_object)
        constraint = pybullet.createConstraint(
            robot, link, world.ids[name], -1, pybullet.JOINT_FIXED, [0, 0, 0],
            position, [0, 0, 0], quaternion,
            physicsClientId=world.client,
        )  # fmt: skip
        pybullet.changeConstraint(constraint, maxForce=cup.max_force, physicsClientId=world.client)
        return cls(world, name, pose_lip_to_world, cup, constraint)

    def off(self) -> None:
        """Lets go."""
        if self._constraint is not None:
            pybullet.removeConstraint(self._constraint, physicsClientId=self._bullet.client)
            self._constraint = None

    def load(self) -> tuple[FloatArray, FloatArray]:
        """Load of the object on the lip; see `Vacuum.load`."""
        state = np.array(pybullet.getConstraintState(self._constraint, physicsClientId=self._bullet.client))
        force, about_middle = state[:3], state[3:6]  # the constraint holds the object's centre of mass
        return force, about_middle + np.cross(self._from_lip(), force)
