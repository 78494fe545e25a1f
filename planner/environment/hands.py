"""Ideal hands: they take and put without touching anything else, and what still moves, moves of itself."""

import numpy as np

from topple.planner.environment.tolerances import CLEARANCE, FALLEN, NEAR, SETTLE
from topple.planner.simulate.lifts import Move, move_between, take_away
from topple.planner.tolerances import DISTURBED, TURNED
from topple.robots.world.world import World
from topple.topology.arrays import FloatArray


def take(world: World, name: str) -> tuple[str, ...]:
    """Lift an object straight up and out of the world.

    Args:
        world: At rest; it goes on from where the lift left it.
        name: What is taken.

    Returns:
        The others that were disturbed: moved by more than 1 cm or turned by more than 10 degrees.
    """
    poses: dict[str, FloatArray] = {}

    def keep(world: World) -> None:
        poses.update(world.poses())

    moves = take_away(world, name, watch=keep)
    world.remove(name)
    for other in moves:
        world.place(other, poses[other])
    _come_to_rest(world)
    return _disturbed(moves)


def put(world: World, name: str, where: str) -> tuple[str, ...]:
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
    _come_to_rest(world)
    after = world.poses()
    moves = {
        other: move_between(world, other, pose, after[other])
        for other, pose in before.items()
        if other != name and other in after
    }
    return (*_disturbed(moves), *(other for other in before if other not in after))


def _come_to_rest(world: World) -> None:
    """Wait, and take out what fell off the table."""
    world.settle(SETTLE)
    for name, pose in world.poses().items():
        if pose[2, 3] < FALLEN:
            world.remove(name)


def _disturbed(moves: dict[str, Move]) -> tuple[str, ...]:
    return tuple(name for name, move in moves.items() if move.beyond(DISTURBED, float(np.degrees(TURNED))))
