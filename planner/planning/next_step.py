"""The next thing to do for a goal: which object, why, and a collision-free transfer of it.

Planning a whole sequence and running one in closed loop ask the same question again: of the scene as it
should be by then, and of the scene as it is seen.
"""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace
from functools import partial

import numpy as np

from topple.planner.decide.arrange import Order
from topple.planner.decide.beliefs import Beliefs
from topple.planner.decide.dependency import dependencies
from topple.planner.decide.goal import Goal, Place, holds
from topple.planner.decide.turn import may_go, out_of_turn, says, why_first
from topple.planner.errors import NoSafePlan
from topple.planner.failure import Setback, TransferFailure
from topple.planner.grasp.given import GraspsByObject, doable
from topple.planner.grasp.grasp import Grasp
from topple.planner.placement.drops import standing, staying
from topple.planner.placement.placement import Placement, placements
from topple.planner.placement.proof import Proof
from topple.planner.placement.shortage import shortage
from topple.planner.placement.stacking import GENTLE, over, placements_on
from topple.planner.planning.order import ordered
from topple.planner.planning.step import FREE, PLACE, REMOVE, NextStep, Orderer, Station
from topple.planner.transfer.transfer import (
    NO_PLACE,
    TRANSFER_LIMITS,
    Transfer,
    TransferLimits,
    plan_transfer,
)
from topple.robots.collision.fcl_bodies import apart
from topple.topology.errors import InvalidInput, UnknownObject
from topple.topology.scene import Scene
from topple.topology.situation import Situation
from topple.topology.sixim.table import Relation

INSIDE = (Relation.WITHIN, Relation.PARTIAL_WITHIN)
CHOICE = 48  # placements on or into a thing to choose from: a dozen spots, four headings each
MORE_CHOICE = 192  # where no more room can be made: also the spots from higher up, each a drop in simulation
MORE_HANDS = TransferLimits(grasps=60, reached=80)  # then, too: all hands that a search for grasps finds
BESIDE = 0.05  # [m] what is closer to an object than this bars a hand: half an open hand's width


class StepChooser:
    """Chooses the next step in one scene.

    Args:
        situation: What is seen, or what should be there by now.
        goal: What shall hold in the end.
        station: The arm as it stands.
        done: Steps that were done, as (object, action): a freed target stays free, and nobody is taken out
            of the way twice.
        observed: Whether the scene was looked at after what was done: a placement that is not seen to hold
            is then made again.
        given_up: Objects that are not to be tried again, with the reason.
        avoid: Grasps that failed, by object.
        beliefs: What earlier looks made of the same things.
        upright: Objects that are kept upright, with what is in them.
        allow_drop: Whether what stays nowhere the arm can put it may be let go to fall. Where the scene is
            observed it always may: the next look shows where it lies.
        orderer: Who decides the order.
        grasps: Grasps of the caller's own, in the world: an object that has an entry is taken by those alone.
        seed: Of every search.
    """

    def __init__(
        self,
        situation: Situation,
        goal: Goal,
        station: Station,
        *,
        done: Collection[tuple[str, str]] = (),
        observed: bool = False,
        given_up: Mapping[str, str] | None = None,
        avoid: Mapping[str, Sequence[Grasp]] | None = None,
        beliefs: Beliefs | None = None,
        upright: Collection[str] = (),
        allow_drop: bool = False,
        orderer: Orderer = ordered,
        grasps: GraspsByObject | None = None,
        seed: int = 0,
    ) -> None:
        self.situation, self.scene = situation, situation.scene
        self.goal, self.station, self.done, self.seed = goal, station, done, seed
        self._orderer, self._grasps = orderer, grasps or {}
        self.observed, self.given_up, self.avoid = observed, given_up or {}, avoid or {}
        self._beliefs = beliefs
        self.upright, self._allow_drop = upright, allow_drop
        self._needed: set[str] = set()  # what orders said has to be taken

    def unmet(self) -> tuple[str, ...]:
        """What is still missing for the goal, in words."""
        free = [f"{name} is not free" for name in self._not_free()]
        return (*free, *self.goal.unmet(self.situation.relations, self.scene.fixed, self.situation.supports))

    def choose(self) -> NextStep | None:
        """The next step; None where nothing is left to do.

        Raises:
            NoSafePlan: Something is left to do, and nothing that may be done now can be.
        """
        lost = [name for name in self.goal.names if name not in self.scene.clouds]
        if lost and self.unmet():
            raise NoSafePlan(words := f"{', '.join(lost)}: seen nowhere any more", (words,))
        if targets := self._not_free():
            return self._take_off(targets, FREE)
        if held := [name for names in self._contents().values() for name in names]:
            return self._take_off(held, FREE)
        for place in self.goal.places:
            planned = not self.observed and (place.object, PLACE) in self.done
            if not planned and not holds(place, self.situation.relations, self.situation.supports):
                return self._place(place)
        return None

    def _not_free(self) -> list[str]:
        return [name for name in self.goal.free if (name, FREE) not in self.done]

    def _contents(self) -> dict[str, tuple[str, ...]]:
        return self.goal.contents(self.situation.relations, self.scene.fixed)

    def _take_off(
        self, targets: Sequence[str], action: str, why: str = "", doubting: bool = True
    ) -> NextStep:
        """The first object of the safe order for some targets that can be taken now, or out of turn."""
        chosen = self._ordered(targets)
        failures: list[TransferFailure] = []
        for name in may_go(chosen):
            found = self._transfer(name, None)
            if isinstance(found, Transfer):
                is_target = name in targets
                reason = (why or "nothing has to go before it") if is_target else why_first(name, chosen)
                role = action if is_target else REMOVE
                return NextStep(found, role, "; ".join([reason, *map(str, failures)]), chosen)
            failures.append(found)
        step = self._make_room(failures) or (self._out_of_turn(targets, action) if doubting else None)
        if step is not None:
            return step
        failures = [self._explained(failure) for failure in failures]
        waiting = f"each of {', '.join(chosen.order)} has to go before another one"
        words = [str(failure) for failure in failures] or [waiting]
        raise NoSafePlan("; ".join(words), tuple(words), tuple(failures))

    def _out_of_turn(self, targets: Sequence[str], action: str) -> NextStep | None:
        """The step that goes against the least likely dependencies: hand and order wait for each other."""
        chosen = self._ordered(targets)
        graph = dependencies(self.situation, direct=False)
        for name, against in out_of_turn(chosen.order, graph, self.situation.supports).items():
            found = self._transfer(name, None)
            if isinstance(found, Transfer):
                role = action if name in targets else REMOVE
                return NextStep(found, role, says(against), chosen, against)
        return None

    def _make_room(self, failures: Sequence[TransferFailure]) -> NextStep | None:
        """What bars the way to an object that could not be taken, or stands beside it: it goes first.

        Nobody goes twice to make room, so this comes to an end.
        """
        barred = {failure.object for failure in failures}
        for failure in failures:
            for other in self._barring(failure):
                step = self._taken_away(other, barred, f"it is in the way to {failure.object} ({failure})")
                if step is not None:
                    return step
        return None

    def _taken_away(self, other: str, barred: Collection[str], why: str) -> NextStep | None:
        """The first step to take an object away, once, that is about none of the barred ones."""
        try:
            chosen = self._ordered([other])
        except NoSafePlan:
            return None
        for first in may_go(chosen):
            if first in barred or (first, REMOVE) in self.done:
                continue
            found = self._transfer(first, None)
            if isinstance(found, Transfer):
                return NextStep(found, REMOVE, why, chosen)
        return None

    def _barring(self, failure: TransferFailure) -> list[str]:
        """Movable objects whose removal may help: those met in the search, and those beside.

        What reaches down least comes first: least may lean on it that was not seen to.
        """
        own, up = self.situation.solids[failure.object], self.situation.up
        movable = set(self.scene.movable) - {failure.object, *self.given_up}
        near = [
            n for n in movable if n in failure.barring or not apart(own, self.situation.solids[n], BESIDE)
        ]
        bottom = {name: round(float((self.scene.clouds[name] @ up).min()), 2) for name in near}
        return sorted(near, key=lambda name: (-bottom[name], name))

    def _place(self, place: Place) -> NextStep:
        """The object to where the goal wants it, or first what has to go before it or is in the way there."""
        name, where = place.object, place.where
        if place.how == "on" and (others := self._standing_on(place)):
            return self._take_off(others, REMOVE, f"it is where {name} shall be")
        chosen = self._ordered([name])
        if len(chosen.order) > 1:
            return self._take_off([name], PLACE)
        if (later := self._stands_on_later(place)) is not None:
            why = f"{later} below it has to come out before {name} is put there"
            return self._take_off([where], REMOVE, why)
        contents = self._in_the_way(place) if place.how == "within" else []
        places, gentle, kept = self._spots(place, CHOICE)
        room, found = self._into(place, gentle if contents else gentle or kept or places, contents)
        if (
            isinstance(found, TransferFailure) and contents
        ):  # taking things out of a heap stirs it: look longer
            places, gentle, kept = self._spots(place, MORE_CHOICE)
            room, found = self._into(place, gentle, contents, MORE_HANDS)
        if isinstance(found, Transfer):
            return NextStep(found, PLACE, f"it shall be {place.how} {where}", chosen)
        if contents:
            try:
                return self._take_off(contents, REMOVE, f"{name} needs room in {where}", doubting=False)
            except NoSafePlan as error:
                why = f"no more room can be made in {where} ({error})"
                step = (
                    self._put(name, (gentle, kept), why, chosen)
                    or self._out_of_turn(contents, REMOVE)
                    or self._put(name, (places,), why, chosen)
                )
                if step is not None:
                    return step
                raise
        if room and (name, REMOVE) not in self.done and name not in self.given_up:
            aside = self._transfer(name, None)
            if isinstance(aside, Transfer):
                words = f"it is put down to be taken otherwise, as it cannot go straight to {where} ({found})"
                return NextStep(aside, REMOVE, words, chosen)
        raise NoSafePlan(str(found), (str(found),), (found,))

    def _into(
        self,
        place: Place,
        spots: list[Placement],
        contents: Sequence[str],
        limits: TransferLimits = TRANSFER_LIMITS,
    ) -> tuple[list[Placement], Transfer | TransferFailure]:
        """The spots that a fall is not too high to, and the transfer to one of them."""
        room = [spot for spot in spots if spot.drop <= GENTLE]
        if (place.object, PLACE) in self.done and contents:
            room = []  # it was tried, and it is not there: more room is needed
        return room, self._transfer(place.object, room, limits) if room else _no_room(place)

    def _put(self, name: str, tries: Sequence[list[Placement]], why: str, chosen: Order) -> NextStep | None:
        """The step to the first of some lists of placements that the arm can make."""
        for places in filter(None, tries):
            found = self._transfer(name, places)
            if isinstance(found, Transfer):
                return NextStep(found, PLACE, why, chosen)
        return None

    def _spots(self, place: Place, limit: int) -> tuple[list[Placement], list[Placement], list[Placement]]:
        """Where an object could go, where it stays there and pushes nothing, and all where it stays."""
        name, where = place.object, place.where
        found = placements_on(name, self.situation, where, place.how, limit=limit)
        if place.how != "within":
            return found, found, found
        lying = [other for other in self._inside(where) if other != name]
        return found, *staying(found, name, where, self.situation, lying)

    def _stands_on_later(self, place: Place) -> str | None:
        """An object that a later placement moves and that comes out only once the base is off: base first."""
        for later in self.goal.places[self.goal.places.index(place) + 1 :]:
            if later.object != place.where and (later.object, PLACE) not in self.done:
                if place.where in self._ordered([later.object]).order:
                    return later.object
        return None

    def _in_the_way(self, place: Place) -> list[str]:
        """What is in a container and does not belong there."""
        settled = {other.object for other in self.goal.places if other.where == place.where}
        return [other for other in self._inside(place.where) if other not in settled | {place.object}]

    def _standing_on(self, place: Place) -> tuple[str, ...]:
        """What stands on a supporter and is not what shall stand there."""
        settled = {other.object for other in self.goal.places if other.where == place.where}
        return tuple(
            support.supported
            for support in self.situation.supports
            if support.supporter == place.where
            and support.supported not in settled
            and (support.kind == "rests" or over(self.situation, support.supported, place.where))
        )

    def _ordered(self, targets: Sequence[str]) -> Order:
        situation = self._loaded(targets)
        chosen = self._orderer(situation, targets, seed=self.seed, beliefs=self._beliefs)
        _check_order(chosen, situation.scene)
        if chosen.unresolved:
            cycles = tuple("cycle: " + " before ".join([*cycle, cycle[0]]) for cycle in chosen.unresolved)
            raise NoSafePlan(f"no safe order frees {', '.join(targets)}: {cycles[0]}", cycles)
        self._needed.update(chosen.order)
        return chosen

    def _loaded(self, targets: Sequence[str]) -> Situation:
        """The situation to order: what rides in a container that is kept upright is one thing with it."""
        scene = self.scene
        for name in self.upright:
            riders = [rider for rider in self._riding(name) if rider not in targets]
            for rider in riders:
                cloud = np.vstack([scene.clouds[name], scene.clouds[rider]])
                together: dict[str, float] = {}
                if name in scene.masses or rider in scene.masses:
                    guessed = {one: self.situation.statics.weights[one].mass for one in (name, rider)}
                    together = {name: sum({**guessed, **scene.masses}[one] for one in (name, rider))}
                scene = scene.without(rider).with_cloud(name, cloud).weighed(together)
        return self.situation if scene is self.scene else Situation(scene)

    def _transfer(
        self, name: str, places: list[Placement] | None, limits: TransferLimits = TRANSFER_LIMITS
    ) -> Transfer | TransferFailure:
        """A transfer of an object, or why there is none."""
        if name in self.given_up:
            return TransferFailure(name, {self.given_up[name]: 1}, None)
        base = self.station.pose_base_to_world
        if places is None:
            seen, own, left = self.situation.standing(name), self.scene.clouds[name], self._remaining(name)
            elsewhere = placements(name, seen, pose_base_to_world=base, avoid=[own], remaining=left)
            places = elsewhere or placements(name, seen, pose_base_to_world=base, remaining=left)
            places = standing(places, name, self.situation)
        transfer = partial(
            plan_transfer, name, self.situation, self.station.arm, base, self.station.q, places,
            grasps=self._own_grasps(name), avoid=self.avoid.get(name, ()),
            riding=self._riding(name), upright=name in self.upright, seed=self.seed, limits=limits,
        )  # fmt: skip
        if self.observed:
            return transfer()
        with Proof(name, self.situation, self._riding(name)) as proof:
            found = transfer(holds=proof.holds)
            if isinstance(found, TransferFailure) and self._allow_drop:
                found = transfer()
                return found if isinstance(found, TransferFailure) else _falling(found, proof)
            return found

    def _explained(self, failure: TransferFailure) -> TransferFailure:
        """A failure for want of a place with its reason; any other as it is."""
        if NO_PLACE not in failure.reasons:
            return failure
        station, name = self.station, failure.object
        why = shortage(name, self.situation.standing(name), station.arm, station.pose_base_to_world)
        return TransferFailure(name, {why: 1}, None, Setback("place", "room", why))

    def _own_grasps(self, name: str) -> list[Grasp] | None:
        """The caller's grasps of an object that can be done now; None where they are to be searched for."""
        if name not in self._grasps:
            return None
        return doable(self._grasps[name], self.scene, self.station.arm, self.station.pose_base_to_world)

    def _remaining(self, name: str) -> frozenset[str]:
        """What is still to be taken once an object is gone, or to have something put on or into it."""
        left = (place for place in self.goal.places if (place.object, PLACE) not in self.done)
        named = {other for place in left for other in (place.object, place.where)}
        return frozenset(named.union(self._needed, self._not_free()) - {name})

    def _riding(self, name: str) -> tuple[str, ...]:
        """What lies in an object that is kept upright."""
        return self._inside(name) if name in self.upright else ()

    def _inside(self, name: str) -> tuple[str, ...]:
        """What lies in an object."""
        between = self.situation.relations.between
        return tuple(n for n in self.scene.movable if n != name and between(n, name).relation in INSIDE)


def _falling(transfer: Transfer, proof: Proof) -> Transfer:
    """A transfer to a place where the object need not stay, which then says what becomes of it."""
    place = transfer.placement
    if proof.holds(place):
        return transfer
    words = f"{place.rest}: let go, {proof.settled(place)}"
    return replace(transfer, placement=replace(place, rest=words, falls=True))


def _check_order(chosen: object, scene: Scene) -> None:
    """Refuse what an orderer of the caller's own must not answer."""
    if not isinstance(chosen, Order):
        raise InvalidInput(
            f"the orderer gave {type(chosen).__name__}, expected an Order: topple.planner.order "
            "gives one, and topple.planner.arrange makes one"
        )
    for name in chosen.order:
        if name not in scene.movable:
            raise UnknownObject(name, scene.movable, role="object in the orderer's order")


def _no_room(place: Place) -> TransferFailure:
    text = f"{place.object} would not stay {place.how} {place.where}"
    return TransferFailure(place.object, {text: 1}, None, Setback("place", "room", text))
