"""What moves when an object is lifted: a rigid hold, the furthest that everything else got to at any time.

Unlike in `topple.planner.simulate.lifts`, which topple asks, the lifted body is made heavy for the lift, as a
hand holds it: what is light would otherwise pass through what is heavy above it. And what was lifted along
and fell back to where it stood has moved.
"""

from collections.abc import Mapping, Sequence

import numpy as np

from topple.benchmarks.piles import label
from topple.planner.simulate.lift import Move, move_between
from topple.planner.simulate.lifts import set_friction
from topple.planner.simulate.tolerances import FRICTIONS, LIFT, SETTLE, SPEED
from topple.robots.engine import pybullet
from topple.robots.world.world import World

HELD = 100.0  # [kg] of what is held: nothing on a table moves it
PAUSE = 12  # steps between looks: 4 mm of the lift
FREE = 0.005  # [m] above all that lies in its way the lift meets nothing any more
BESIDE = 0.01  # [m] things this far beside the way are in it: they may fall into it


def labels_of(world: World, movable: Sequence[str]) -> dict[str, dict[str, int | None]]:
    """Lift every object in turn, at every friction.

    Args:
        world: At rest; left as it was but for friction.
        movable: What is lifted.

    Returns:
        then -> first -> 1, 0 or None (too close to call).
    """
    moves: dict[str, list[Mapping[str, Move]]] = {name: [] for name in movable}
    for between, table in FRICTIONS:
        set_friction(world, between, table)
        for name in movable:
            moves[name].append(_lifted(world, name))
    return {
        then: {first: label(found, first) for first in movable if first != then}
        for then, found in moves.items()
    }


def _lifted(world: World, name: str) -> dict[str, Move]:
    """Furthest move of everything else while an object is lifted and taken away."""
    client, number = world.client, world.ids[name]
    kept, before = world.snapshot(), world.poses()
    furthest = {other: Move(0.0, 0.0) for other in before if other != name}

    def look() -> None:
        for other, most in furthest.items():
            move = move_between(world, other, before[other], world.pose(other))
            furthest[other] = Move(max(most.distance, move.distance), max(most.angle, move.angle))

    mass, inertia = pybullet.getDynamicsInfo(number, -1, physicsClientId=client)[0:3:2]
    _weigh(world, number, HELD, [value * HELD / mass for value in inertia])
    position, turn = pybullet.getBasePositionAndOrientation(number, physicsClientId=client)
    for step in range(1, round(LIFT / SPEED / world.time_step) + 1):
        at = (position[0], position[1], position[2] + step * SPEED * world.time_step)
        pybullet.resetBasePositionAndOrientation(number, at, turn, physicsClientId=client)
        pybullet.resetBaseVelocity(number, (0, 0, SPEED), (0, 0, 0), physicsClientId=client)
        world.step()
        if step % PAUSE == 0:
            look()
            if _is_free(world, name):
                break
    look()
    _weigh(world, number, mass, inertia)
    away = (0, 0, 1e3)  # where it falls for as long as the others settle
    pybullet.resetBasePositionAndOrientation(number, away, turn, physicsClientId=client)
    for _ in range(round(SETTLE / world.time_step / (2 * PAUSE))):
        world.step(2 * PAUSE)
        if all(max(world.speeds(other)) < 1e-3 for other in furthest):
            break
    look()
    world.restore(kept)
    pybullet.removeState(kept.number, physicsClientId=client)
    return furthest


def _weigh(world: World, number: int, mass: float, inertia: Sequence[float]) -> None:
    pybullet.changeDynamics(
        number, -1, mass=mass, localInertiaDiagonal=list(inertia), physicsClientId=world.client
    )


def _is_free(world: World, name: str) -> bool:
    """Whether the way up is clear, or barred by something that never moves."""
    low, high = (
        np.array(corner) for corner in pybullet.getAABB(world.ids[name], physicsClientId=world.client)
    )
    for other, number in world.ids.items():
        if other == name:
            continue
        least, most = (np.array(corner) for corner in pybullet.getAABB(number, physicsClientId=world.client))
        beside = ((least[:2] > high[:2] + BESIDE) | (most[:2] < low[:2] - BESIDE)).any()
        if not beside and low[2] < most[2] + FREE:
            met = pybullet.getContactPoints(world.ids[name], number, physicsClientId=world.client) or ()
            return other in world.fixed and any(point[7][2] < -0.7 for point in met)
    return True
