"""Lift something straight up in a world, whatever engine plays it, and tell how far the others moved."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeVar

import numpy as np

from topple.planner.simulate.tolerances import DOWNWARD, HIGHER, LIFT, SPEED
from topple.planner.tolerances import DISTURBED, TURNED
from topple.robots.poses import angle_between
from topple.robots.world.physical_world import PhysicalWorld
from topple.topology.base.arrays import FloatArray

_World = TypeVar("_World", bound=PhysicalWorld)


@dataclass(frozen=True)
class Move:
    """How far something moved.

    Attributes:
        distance: Displacement of the centre of mass [m].
        angle: Turn [rad].
    """

    distance: float
    angle: float

    @property
    def share(self) -> float:
        """Size as a multiple of the least move that counts, a centimetre or ten degrees."""
        return max(self.distance / DISTURBED, self.angle / TURNED)

    def beyond(self, distance: float, degrees: float) -> bool:
        """Whether it moved further than a distance [m] or turned by more than some degrees."""
        return self.distance > distance or self.angle > np.radians(degrees)


def lift(world: _World, name: str, watch: Callable[[_World], None] | None = None) -> None:
    """Lift an object straight up, rigidly, until it is above everything or a board bars its way.

    Args:
        world: A world at rest.
        name: What is lifted.
        watch: Called after every step.
    """
    pose = world.pose(name)
    for step in range(1, round(LIFT / SPEED / world.time_step) + 1):
        pose[2, 3] += SPEED * world.time_step
        world.place(name, pose, rising=SPEED)
        world.step()
        if watch is not None:
            watch(world)
        if step % 12 == 0 and (_is_clear(world, name) or _is_stopped(world, name)):
            break


def move_between(world: PhysicalWorld, name: str, before: FloatArray, after: FloatArray) -> Move:
    """How far a body got from one pose (4, 4) to another.

    Args:
        world: Its world.
        name: The body.
        before: pose_body_to_world.
        after: The same later.
    """
    shift = _centre(world, name, after) - _centre(world, name, before)
    return Move(float(np.linalg.norm(shift)), angle_between(before, after))


def _is_clear(world: PhysicalWorld, name: str) -> bool:
    """Whether a body is above everything else."""
    bottom = min(part[:, 2].min() for part in world.parts(name))
    others = (part for other in world.names if other != name for part in world.parts(other))
    return bool(bottom > max((part[:, 2].max() for part in others), default=-np.inf) + HIGHER)


def _is_stopped(world: PhysicalWorld, name: str) -> bool:
    """Whether a body has come up against something fixed above it."""
    for contact in world.contacts():
        down = contact.normal[2] if contact.a == name else -contact.normal[2]
        other = contact.b if contact.a == name else contact.a
        if name in (contact.a, contact.b) and other in world.fixed and down < -DOWNWARD:
            return True
    return False


def _centre(world: PhysicalWorld, name: str, pose: FloatArray) -> FloatArray:
    """Centre of mass of a body in the world [m]."""
    return np.asarray(pose[:3, :3] @ world.body(name).centre_of_mass + pose[:3, 3])
