"""Ideal hands: they take and put without touching anything else, and what still moves, moves of itself."""

from collections.abc import Mapping

import numpy as np

from topple.planner.environment.tolerances import CLEARANCE, FALLEN, NEAR, SETTLE
from topple.planner.simulate.lift import lift, move_between
from topple.robots.world.physical_world import PhysicalWorld
from topple.topology.base.arrays import FloatArray


def take(world: PhysicalWorld, name: str) -> tuple[str, ...]:
    """Lift an object straight up and out of the world.

    Args:
        world: At rest; it goes on from where everything comes to lie.
        name: What is taken.

    Returns:
        The others that were disturbed: moved by more than 1 cm or turned by more than 10 degrees.
    """
    before = world.poses()
    lift(world, name)
    world.remove(name)
    return _settle_and_judge(world, name, before)


def put(world: PhysicalWorld, name: str, where: str) -> tuple[str, ...]:
    """Let an object go over the middle of another one, as low as what lies there allows.

    Args:
        world: At rest; it goes on from where everything comes to lie.
        name: What is put.
        where: Over what.

    Returns:
        The others that were disturbed.
    """
    before = world.poses()
    middle = np.concatenate(world.parts(where)).mean(axis=0)
    others = [np.concatenate(world.parts(other)) for other in world.movable if other != name]
    under = np.concatenate([each[np.linalg.norm((each - middle)[:, :2], axis=1) < NEAR] for each in others])
    own = np.concatenate(world.parts(name))
    top = float(under[:, 2].max()) if len(under) else float(middle[2])
    pose = before[name].copy()
    pose[:3, 3] += middle - own.mean(axis=0)
    pose[2, 3] = before[name][2, 3] + top + CLEARANCE - float(own[:, 2].min())
    world.place(name, pose)
    return _settle_and_judge(world, name, before)


def _settle_and_judge(world: PhysicalWorld, name: str, before: Mapping[str, FloatArray]) -> tuple[str, ...]:
    """Wait until all is at rest, take out what fell off the table, and name what else was disturbed."""
    world.settle(SETTLE)
    after = world.poses()
    others = [other for other in before if other != name]
    found = [o for o in others if move_between(world, o, before[o], after[o]).share > 1.0]
    for other, pose in after.items():
        if pose[2, 3] < FALLEN:
            world.remove(other)
    return tuple(found)
