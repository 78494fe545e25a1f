"""What of a goal truly holds in a simulated world: by its bodies' poses and contact forces alone.

Nothing here asks for a relation or a support as `topple.topology` decides them: a run is not judged by what
planned it.
"""

import networkx as nx
import numpy as np

from topple.planner.decide.goal import Goal, Place, PlaceRelation
from topple.planner.execution.tolerances import BEARS, BURDENS, PRESSED
from topple.robots.world.physical_world import PhysicalWorld
from topple.topology.arrays import FloatArray
from topple.topology.geometry.axes import level_axes
from topple.topology.geometry.hull import Hull


def truly_unmet(goal: Goal, world: PhysicalWorld, up: FloatArray) -> tuple[str, ...]:
    """What of a goal does not hold in the world as it is, whatever the cameras make of it.

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
    rest = _Rest(world, up)
    gone = [f"{name} is not free: it is gone" for name in goal.free if name not in world.names]
    burdened = [
        f"{name} is not free: it carries {other}" for name in goal.free for other in rest.carried_by(name)
    ]
    missing = [f"{p.object} is not {p.how} {p.where}" for p in goal.places if not rest.attained(p)]
    left = [
        f"{name} is still in {container}"
        for container in goal.empty
        for name in world.movable
        if name != container and rest.within(name, container)
    ]
    return (*gone, *burdened, *missing, *left)


class _Rest:
    """A world as it is at one instant."""

    def __init__(self, world: PhysicalWorld, up: FloatArray) -> None:
        self._world, self._up, self._level = world, up, np.stack(level_axes(up), axis=1)
        self._force: dict[tuple[str, str], FloatArray] = {}
        for contact in world.contacts():
            push = contact.force * contact.normal  # of b on a
            for one, other, force in ((contact.a, contact.b, push), (contact.b, contact.a, -push)):
                self._force[one, other] = self._force.get((one, other), np.zeros(3)) + force
        self._corners = {name: np.vstack(world.parts(name)) for name in world.names}

    def _middle(self, name: str) -> FloatArray:
        pose = self._world.pose(name)
        return pose[:3, :3] @ self._world.body(name).centre_of_mass + pose[:3, 3]

    def _weight(self, name: str) -> float:
        return self._world.body(name).mass * self._world.physics.gravity

    def attained(self, place: Place) -> bool:
        """Whether a thing is where it shall be."""
        if not {place.object, place.where} <= self._corners.keys():
            return False
        if self.within(place.object, place.where):
            return True  # what is in a plate's rim is on the plate, too
        borne = float(self._force.get((place.object, place.where), np.zeros(3)) @ self._up)
        return place.how is PlaceRelation.ON and borne >= BEARS * self._weight(place.object)

    def within(self, name: str, container: str) -> bool:
        """Whether a thing is in the hollow of another one, carried by it."""
        if not self._surrounded(name, container):
            return False
        inside = [other for other in self._world.movable if self._surrounded(other, container)]
        touching: nx.Graph[str] = nx.Graph()
        touching.add_nodes_from((*inside, container))
        touching.add_edges_from(pair for pair in self._force if set(pair) <= {*inside, container})
        return nx.has_path(touching, name, container)

    def _surrounded(self, name: str, container: str) -> bool:
        if name == container or not {name, container} <= self._corners.keys():
            return False  # somebody may have taken it out of the world
        around, height = self._corners[container], self._corners[container] @ self._up
        lowest = float((self._corners[name] @ self._up).min())
        if not height.min() < lowest < height.max():
            return False
        flat = around @ self._level
        plan = Hull.of(np.column_stack([flat, np.zeros(len(flat))]))
        place = np.append(self._middle(name) @ self._level, 0.0)
        return bool(plan.facet_distance(place[None])[0] <= 0.0)

    def carried_by(self, name: str) -> list[str]:
        """What a thing carries, holds up, or has in its hollow."""
        found: list[str] = []
        for other in self._world.movable:
            if other == name:
                continue
            push = self._force.get((other, name), np.zeros(3))
            size = float(np.linalg.norm(push))
            upward = size > BURDENS * self._weight(other) and float(push @ self._up) > PRESSED * size
            if upward or self.within(other, name):
                found.append(other)
        return found
