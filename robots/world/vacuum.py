"""A suction cup that holds as a real one does: where its lip seals, and no more than its vacuum pulls."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from topple.robots.arm.gripper import SuctionCup, lip_plane, vacuum_load
from topple.robots.engine import pybullet
from topple.robots.poses import inverse, pose_from, position_and_quaternion
from topple.robots.world.tolerances import AT_LIMIT, CLEAR, CONSTRAINT_ERP, PEEL_STEPS, RAYS, REACH, TILT
from topple.robots.world.world import World
from topple.topology.arrays import FloatArray
from topple.topology.geometry.rigid import transformed


@dataclass
class Vacuum:
    """A cup that has taken an object.

    The hold is a constraint whose forces are read after every step: what `vacuum_load` says the lip does not
    hold breaks it.

    Attributes:
        world: The world both are in.
        name: The object it holds.
        constraint: PyBullet's number of the constraint; None once it has let go.
        axis: (3,) unit, out of the cup, in the object's frame.
        cup: Force, radius and friction.
    """

    world: World
    name: str
    constraint: int | None
    axis: FloatArray
    cup: SuctionCup
    _over: int = 0

    @property
    def sealed(self) -> bool:
        """Whether it still holds."""
        return self.constraint is not None

    @classmethod
    def on(
        cls, world: World, robot: int, link: int, pose_lip_to_world: FloatArray, cup: SuctionCup
    ) -> "Vacuum | None":
        """Switches the vacuum on; None where the lip seals on nothing that can be moved.

        Args:
            world: The world the robot stands in.
            robot: PyBullet's number of the robot.
            link: Index of the cup's link.
            pose_lip_to_world: (4, 4) where the lip is, z out of the hand.
            cup: Radius, force and lip depth.
        """
        name = _under(world, pose_lip_to_world, cup)
        if name not in world.movable:
            return None
        state: Any = pybullet.getLinkState(
            robot, link, computeForwardKinematics=1, physicsClientId=world.client
        )
        pose_object = pose_from(
            *pybullet.getBasePositionAndOrientation(world.ids[name], physicsClientId=world.client)
        )
        # Bullet's constraints see gravity a step late: what hangs on one sags, and would be pushed down first
        pose_object[2, 3] += world.physics.gravity * world.time_step**2 / CONSTRAINT_ERP
        position, quaternion = position_and_quaternion(inverse(pose_from(state[0], state[1])) @ pose_object)
        constraint = pybullet.createConstraint(
            robot, link, world.ids[name], -1, pybullet.JOINT_FIXED, [0, 0, 0],
            position, [0, 0, 0], quaternion,
            physicsClientId=world.client,
        )  # fmt: skip
        pybullet.changeConstraint(constraint, maxForce=cup.max_force, physicsClientId=world.client)
        axis = world.pose(name)[:3, :3].T @ pose_lip_to_world[:3, 2]
        return cls(world, name, constraint, axis, cup)

    def check(self) -> None:
        """Reads the forces of the last step and lets go where they were too much for too long."""
        if self.constraint is None:
            return
        state = np.array(pybullet.getConstraintState(self.constraint, physicsClientId=self.world.client))
        out = self.world.pose(self.name)[:3, :3] @ self.axis
        pull = float(state[:3] @ out)
        twist = float(state[3:6] @ out)
        shear = float(np.linalg.norm(state[:3] - pull * out))
        bending = float(np.linalg.norm(state[3:6] - twist * out))
        cup = self.cup
        load = vacuum_load(
            pull, shear, bending, twist, force=cup.max_force, radius=cup.radius, friction=cup.friction
        )
        self._over = self._over + 1 if load >= AT_LIMIT else 0
        if self._over >= PEEL_STEPS:
            self.off()

    def off(self) -> None:
        """Lets go."""
        if self.constraint is not None:
            pybullet.removeConstraint(self.constraint, physicsClientId=self.world.client)
            self.constraint = None


def _under(world: World, pose_lip_to_world: FloatArray, cup: SuctionCup) -> str | None:
    """The body that rays just outside the lip all meet in a plane that the lip can follow.

    What stands out of that plane within the lip holds the cup off, and the plane is then too far away.
    """
    angle = np.linspace(0.0, 2 * np.pi, RAYS, endpoint=False)
    ring = (cup.radius + CLEAR) * np.column_stack([np.cos(angle), np.sin(angle)])
    ends = [np.column_stack([ring, np.full(RAYS, z)]) for z in (-REACH, REACH)]
    start, end = (transformed(points, pose_lip_to_world) for points in ends)
    hits: Any = pybullet.rayTestBatch(start.tolist(), end.tolist(), physicsClientId=world.client)
    if len({hit[0] for hit in hits}) > 1:
        return None
    height = np.array([hit[2] * 2 * REACH - REACH for hit in hits])
    plane, uneven = lip_plane(ring, height)
    follows = max(uneven, abs(plane[2])) <= cup.lip_depth and np.hypot(*plane[:2]) <= np.tan(TILT)
    return world.name_of(hits[0][0]) if follows else None
