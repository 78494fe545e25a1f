"""What of a goal truly holds in a simulated world: by its bodies' poses and contact forces alone.

Nothing here asks for a relation or a support as `topple.topology` decides them: a run is not judged by what
planned it.
"""

from dataclasses import replace

import numpy as np

from topple.planner.decide.goal import Goal, Place, PlaceRelation
from topple.planner.execution.tolerances import BEARS, BURDENS, PRESSED
from topple.planner.stability.state import State
from topple.robots.world.physical_world import PhysicalWorld
from topple.topology.base.arrays import FloatArray


def truly_unmet(goal: Goal, world: PhysicalWorld, up: FloatArray) -> tuple[str, ...]:
    """Find the clauses of a goal that the world does not meet, whatever the cameras make of it.

    A thing is on another one that bears half its weight, or in whose hollow it is. It is in a hollow where
    its centre of mass is over the other's outline, its lowest point below the rim and above the other's
    lowest one, and it meets the other or what else is in it. What is to be free bears and holds nothing.

    Args:
        goal: What shall hold.
        world: The world at rest, a step after which its contacts are those of its poses.
        up: (3,) unit vector against gravity.

    Returns:
        The clauses that do not hold, in words.
    """
    state = replace(State.of(world), up=up)
    gone = [f"{name} is not free: it is gone" for name in goal.free if name not in world.names]
    burdened = [
        f"{name} is not free: it carries {other}" for name in goal.free for other in _carried_by(name, state)
    ]
    missing = [f"{p.object} is not {p.how} {p.where}" for p in goal.places if not _is_attained(p, state)]
    left = [
        f"{name} is still in {container}"
        for container in goal.empty
        for name in world.movable
        if container in state.names and state.within(name, container)
    ]
    return (*gone, *burdened, *missing, *left)


def _is_attained(place: Place, state: State) -> bool:
    """Whether a thing is where it shall be."""
    if not {place.object, place.where} <= set(state.names):
        return False
    if state.within(place.object, place.where):
        return True  # what is in a plate's rim is on the plate, too
    borne = state.lift(place.object, place.where)
    return place.how is PlaceRelation.ON and borne >= BEARS * state.weights.get(place.object, np.inf)


def _carried_by(name: str, state: State) -> list[str]:
    """Objects that an object carries, holds up, or has in its hollow."""
    found: list[str] = []
    for other, weight in state.weights.items():
        if other == name:
            continue
        size = float(np.linalg.norm(state.pushes.get((other, name), np.zeros(3))))
        upward = size > BURDENS * weight and state.lift(other, name) > PRESSED * size
        if upward or (name in state.names and state.within(other, name)):
            found.append(other)
    return found
