"""The next thing to do for a goal: which object, why, and a collision-free transfer of it.

Planning a whole sequence and running one in closed loop ask the same question again: of the scene as it
should be by then, and of the scene as it is seen.
"""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

from topple.planner.errors import NoSafePlan
from topple.planner.goal import Goal, Place
from topple.planner.order import Order, order
from topple.planner.placement import Placement, placements
from topple.planner.solids import Solids, solids_of
from topple.planner.stacking import placements_on
from topple.planner.transfer import Transfer, TransferFailure, plan_transfer
from topple.robots.arm import Arm
from topple.topology.arrays import FloatArray
from topple.topology.relate import Relations, relate
from topple.topology.scene import Scene
from topple.topology.support import supports

FREE, REMOVE, PLACE = "free", "remove", "place"
"""free: take a target clear, put it down; remove: take away what is in the way; place: as the goal says."""


@dataclass(frozen=True, eq=False)
class NextStep:
    """A step that can be done now.

    Attributes:
        transfer: What the arm does.
        action: One of free, remove, place.
        reason: Why this object and why now.
        order: The order the step was chosen from.
    """

    transfer: Transfer
    action: str
    reason: str
    order: Order


@dataclass(frozen=True, eq=False)
class Station:
    """The arm as it stands before a step.

    Attributes:
        arm: The arm.
        pose_base_to_world: (4, 4) where it stands.
        q: (n,) its joint values [rad].
    """

    arm: Arm
    pose_base_to_world: FloatArray
    q: FloatArray


class StepChooser:
    """Chooses the next step in one scene.

    Args:
        scene: What is seen, or what should be there by now, with `up`.
        goal: What shall hold in the end.
        station: The arm as it stands.
        done: Steps that were done, as (object, action): a freed target stays free.
        relations: The scene's relations where they are known.
        given_up: Objects that are not to be tried again, with the reason.
        seed: Of every search.
    """

    def __init__(
        self,
        scene: Scene,
        goal: Goal,
        station: Station,
        *,
        done: Collection[tuple[str, str]] = (),
        relations: Relations | None = None,
        given_up: Mapping[str, str] | None = None,
        seed: int = 0,
    ) -> None:
        self.scene, self.goal, self.station, self.done, self.seed = scene, goal, station, done, seed
        self.relations = relate(scene) if relations is None else relations
        self.given_up = given_up or {}

    @cached_property
    def _solids(self) -> Solids:
        return solids_of(self.scene)

    def unmet(self) -> tuple[str, ...]:
        """What is still missing for the goal, in words."""
        free = [f"{name} is not free" for name in self.goal.free if (name, FREE) not in self.done]
        return (*free, *self.goal.unmet(self.relations, self.scene.fixed))

    def choose(self) -> NextStep | None:
        """The next step; None where nothing is left to do.

        Raises:
            NoSafePlan: Something is left to do, and nothing that may be done now can be.
        """
        targets = [name for name in self.goal.free if (name, FREE) not in self.done]
        if targets:
            return self._take_off(targets, FREE)
        inside = self.goal.contents(self.relations, self.scene.fixed)
        held = [name for names in inside.values() for name in names]
        if held:
            return self._take_off(held, FREE)
        for place in self.goal.places:
            if (place.object, PLACE) not in self.done:
                return self._place(place)
        return None

    def _take_off(self, targets: Sequence[str], action: str) -> NextStep:
        """The first object of the safe order for some targets that can be taken now."""
        chosen = self._ordered(targets)
        rank = {name: place for place, name in enumerate(chosen.order)}
        # within a cycle's group the order says who starts, so only what comes earlier is waited for
        waiting = {
            edge.then
            for edge in chosen.graph.dependencies
            if edge.first in rank and edge.then in rank and rank[edge.first] < rank[edge.then]
        }
        failures: list[str] = []
        for name in (name for name in chosen.order if name not in waiting):
            found = self._transfer(name, None)
            if isinstance(found, Transfer):
                if name in targets:
                    return NextStep(found, action, "nothing has to go before it", chosen)
                return NextStep(found, REMOVE, _why(name, chosen), chosen)
            failures.append(found)
        if not failures:
            failures = [f"each of {', '.join(chosen.order)} has to go before another one"]
        raise NoSafePlan("; ".join(failures), tuple(failures))

    def _place(self, place: Place) -> NextStep:
        """The object to where the goal wants it, or first what has to go before it or stands there."""
        others = self._standing_on(place) if place.how == "on" else ()
        if others:
            return self._take_off(others, REMOVE)
        chosen = self._ordered([place.object])
        if len(chosen.order) > 1:
            return self._take_off([place.object], PLACE)
        places = placements_on(place.object, self.scene, place.where, place.how, self._solids)
        if not places:
            words = f"{place.object} would not stay {place.how} {place.where}"
            raise NoSafePlan(words, (words,))
        found = self._transfer(place.object, places)
        if isinstance(found, str):
            raise NoSafePlan(found, (found,))
        return NextStep(found, PLACE, f"it shall be {place.how} {place.where}", chosen)

    def _standing_on(self, place: Place) -> tuple[str, ...]:
        """What stands on a supporter and is not what shall stand there."""
        settled = {other.object for other in self.goal.places if other.where == place.where}
        return tuple(
            support.supported
            for support in supports(self.scene, self.relations)
            if support.supporter == place.where
            and support.kind == "rests"
            and support.supported not in settled
        )

    def _ordered(self, targets: Sequence[str]) -> Order:
        chosen = order(self.scene, targets, relations=self.relations, seed=self.seed)
        if chosen.unresolved:
            cycles = tuple("cycle: " + " before ".join([*cycle, cycle[0]]) for cycle in chosen.unresolved)
            raise NoSafePlan(f"no safe order frees {', '.join(targets)}: {cycles[0]}", cycles)
        return chosen

    def _transfer(self, name: str, places: list[Placement] | None) -> Transfer | str:
        """A transfer of an object, or why there is none."""
        if name in self.given_up:
            return f"cannot move {name}: {self.given_up[name]}"
        base = self.station.pose_base_to_world
        if places is None:
            places = placements(name, self.scene, self._solids, pose_base_to_world=base)
        found = plan_transfer(
            name, self.scene, self._solids, self.station.arm, base, self.station.q, places, seed=self.seed
        )
        return str(found) if isinstance(found, TransferFailure) else found


def _why(name: str, chosen: Order) -> str:
    after = [
        f"{edge.then} ({edge.reason})"
        for edge in chosen.graph.dependencies
        if edge.first == name and edge.then in chosen.order
    ]
    return f"it has to go before {' and '.join(after)}" if after else "it is in the way"
