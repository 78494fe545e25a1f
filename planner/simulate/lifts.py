"""Take something away in simulation: what moves?"""

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING

import numpy as np

from topple.planner.simulate.lift import Move, lift, move_between
from topple.planner.simulate.tolerances import SETTLE, SLOW, STILL, WATCHED
from topple.robots.engine import pybullet
from topple.robots.world.world import World
from topple.topology.base.arrays import FloatArray

if TYPE_CHECKING:
    from topple.planner.simulate.rebuild import Rebuilt


def take_away(
    world: World,
    name: str,
    before: Mapping[str, FloatArray] | None = None,
    watch: Callable[[World], None] | None = None,
) -> dict[str, Move]:
    """Lift an object straight up, rigidly, take it out of the world, and see what became of the others.

    The world is left as it was.

    Args:
        world: A world at rest.
        name: What is lifted.
        before: name -> (4, 4) pose that the others are compared with: where they would be had nothing been
            lifted. Where they are now, if not given.
        watch: Called after every step of the lift, and once all is over, before the world is put back.

    Returns:
        name -> move, for everything else that can move.
    """
    client = world.client
    kept = world.snapshot()
    before = world.poses() if before is None else before
    number = world.ids[name]
    lift(world, name, watch)
    turn = pybullet.getBasePositionAndOrientation(number, physicsClientId=client)[1]
    # Out of reach of everything, where it falls for as long as the others settle.
    pybullet.resetBasePositionAndOrientation(number, (0, 0, 1e3), turn, physicsClientId=client)
    for _ in range(round(SETTLE / world.time_step / 24)):
        world.step(24)
        if _at_rest(world, name):
            break
    if watch is not None:
        watch(world)
    after = world.poses()
    world.restore(kept)
    pybullet.removeState(kept.number, physicsClientId=client)
    others = {other: pose for other, pose in before.items() if other != name}
    return {other: move_between(world, other, pose, after[other]) for other, pose in others.items()}


def _at_rest(world: World, lifted: str) -> bool:
    """Whether nothing moves but the lifted body."""
    for name in world.movable:
        if name != lifted:
            speed, turn = world.speeds(name)
            if speed > STILL or turn > 10 * STILL:
                return False
    return True


class Stage:
    """A rebuilt world at rest, from which things are taken away one at a time; to be closed.

    Attributes:
        world: The world.
        sagged: name -> how far it moved before anything was taken: how wrong its rebuilt body is.
    """

    def __init__(self, rebuilt: "Rebuilt", between: float, table: float) -> None:
        """Build the world, let it come to rest, and see where everything stays if nothing is done.

        Args:
            rebuilt: The bodies.
            between: Friction between objects, where it is not known.
            table: Friction with what is fixed, likewise.
        """
        self.world = World()
        rebuilt.fill(self.world)
        set_friction(self.world, between, table, rebuilt.friction)
        before = self.world.poses()
        _come_to_rest(self.world)
        kept = self.world.snapshot()
        for _ in range(round(WATCHED / self.world.time_step / 24)):
            self.world.step(24)
            if _at_rest(self.world, ""):
                break
        self._rest = self.world.poses()
        self.world.restore(kept)
        self.sagged = {
            name: move_between(self.world, name, before[name], self._rest[name]) for name in before
        }

    def without(self, name: str) -> dict[str, Move]:
        """Take something away: how far the others get from where they would be with it."""
        return take_away(self.world, name, before=self._rest)

    def close(self) -> None:
        """End the simulation."""
        self.world.close()


def _come_to_rest(world: World) -> None:
    """Settle slowly: bodies that overlap a little are pushed apart without being thrown."""
    for _ in range(SLOW):
        world.step()
        for number in (world.ids[name] for name in world.movable):
            pybullet.resetBaseVelocity(number, (0, 0, 0), (0, 0, 0), physicsClientId=world.client)
    for _ in range(20):
        world.step(12)
        if _at_rest(world, ""):
            break


def set_friction(
    world: World, between: float, table: float, known: Mapping[str, float] | None = None
) -> None:
    """Give every contact one coefficient of friction, as far as nothing else is known.

    Args:
        world: The world.
        between: Coefficient between objects; PyBullet multiplies those of the two bodies.
        table: Coefficient between an object and anything fixed.
        known: Coefficients of surfaces by name, which stay as they are.
    """
    own, known = float(np.sqrt(between)), known or {}
    for name, number in world.ids.items():
        value = known.get(name, table / own if name in world.fixed else own)
        pybullet.changeDynamics(number, -1, lateralFriction=value, physicsClientId=world.client)
