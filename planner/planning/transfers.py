"""How one object can be moved in a situation: to a free place, or to given ones, by what the arm has."""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace
from functools import partial

from topple.planner.failure import Check, FailedCheck, TransferFailure
from topple.planner.fallbacks import Fallback
from topple.planner.grasp.given import GraspsByObject, doable
from topple.planner.grasp.grasp import Grasp
from topple.planner.placement.drops import standing
from topple.planner.placement.placement import Placement, placements
from topple.planner.placement.proof import Proof
from topple.planner.placement.shortage import shortage
from topple.planner.planning.step import Station
from topple.planner.planning.tolerances import BESIDE
from topple.planner.transfer.segments import SegmentKind
from topple.planner.transfer.transfer import (
    NO_PLACE,
    TRANSFER_LIMITS,
    Transfer,
    TransferLimits,
    plan_transfer,
)
from topple.robots.collision.fcl_bodies import apart
from topple.topology.situation import Situation
from topple.topology.sixim.table import Relation

INSIDE = (Relation.WITHIN, Relation.PARTIAL_WITHIN)
MORE_HANDS = TransferLimits(grasps=60, reached=80)  # all hands that a search for grasps finds


class Transfers:
    """The transfers that an arm can make in one situation.

    Args:
        situation: What is seen, or what should be there by now.
        station: The arm as it stands.
        given_up: Objects that are not to be tried again, with the reason.
        avoid: Grasps that failed, by object.
        grasps: Grasps of the caller's own, in the world.
        upright: Objects that are kept upright, with what is in them.
        simulate: Whether a place has to hold in simulation before it is used: where no look follows.
        allow_drop: Whether what holds nowhere may then be let go to fall.
        seed: Of every search.
    """

    def __init__(
        self,
        situation: Situation,
        station: Station,
        *,
        given_up: Mapping[str, str],
        avoid: Mapping[str, Sequence[Grasp]],
        grasps: GraspsByObject,
        upright: Collection[str],
        simulate: bool,
        allow_drop: bool,
        seed: int,
    ) -> None:
        self.situation, self.station, self.given_up, self.upright = situation, station, given_up, upright
        self._avoid, self._grasps, self._seed = avoid, grasps, seed
        self._simulate, self._allow_drop = simulate, allow_drop

    def aside(self, name: str, remaining: Collection[str]) -> Transfer | TransferFailure:
        """Move an object to a free place on a top, or say why it cannot be.

        Args:
            name: The object.
            remaining: What is still to be taken, and not to be put in the way of.
        """
        if name in self.given_up:
            return self._refused(name)
        base, own = self.station.pose_base_to_world, self.situation.scene.clouds[name]
        find = partial(
            placements,
            name,
            self.situation.with_completed(name),
            pose_base_to_world=base,
            remaining=remaining,
        )
        places = find(avoid=[own]) or find()
        return self.to(name, standing(places, name, self.situation))

    def to(
        self, name: str, places: Sequence[Placement], limits: TransferLimits = TRANSFER_LIMITS
    ) -> Transfer | TransferFailure:
        """Move an object to one of some places, or say why it cannot be.

        Args:
            name: The object.
            places: Where it may go, best first.
            limits: How hard to look.
        """
        if name in self.given_up:
            return self._refused(name)
        transfer = partial(
            plan_transfer, name, self.situation, self.station.arm, self.station.pose_base_to_world,
            self.station.q, places, grasps=self._own_grasps(name), avoid=self._avoid.get(name, ()),
            riding=self.riding(name), upright=name in self.upright, seed=self._seed, limits=limits,
        )  # fmt: skip
        if not self._simulate:
            return transfer()
        with Proof(name, self.situation, self.riding(name)) as proof:
            found = transfer(holds=proof.holds)
            if isinstance(found, TransferFailure) and self._allow_drop:
                found = transfer()
                return found if isinstance(found, TransferFailure) else _falling(found, proof)
            return found

    def explained(self, failure: TransferFailure) -> TransferFailure:
        """A failure for want of a place with its reason; any other as it is."""
        if NO_PLACE not in failure.reasons:
            return failure
        station, name = self.station, failure.object
        why = shortage(name, self.situation.with_completed(name), station.arm, station.pose_base_to_world)
        return TransferFailure(name, {why: 1}, None, FailedCheck(SegmentKind.PLACE, Check.ROOM, why))

    def barring(self, failure: TransferFailure) -> list[str]:
        """Movable objects whose removal may help: those met in the search, and those beside.

        What reaches down least comes first: least may lean on it that was not seen to.
        """
        solids, up, scene = self.situation.solids, self.situation.up, self.situation.scene
        movable = set(scene.movable) - {failure.object, *self.given_up}
        own = solids[failure.object]
        near = [n for n in movable if n in failure.barring or not apart(own, solids[n], BESIDE)]
        bottom = {name: round(float((scene.clouds[name] @ up).min()), 2) for name in near}
        return sorted(near, key=lambda name: (-bottom[name], name))

    def riding(self, name: str) -> tuple[str, ...]:
        """What lies in an object that is kept upright."""
        return self.inside(name) if name in self.upright else ()

    def inside(self, name: str) -> tuple[str, ...]:
        """What lies in an object."""
        between = self.situation.relations.between
        movable = self.situation.movable
        return tuple(n for n in movable if n != name and between(n, name).relation in INSIDE)

    def _refused(self, name: str) -> TransferFailure:
        return TransferFailure(name, {self.given_up[name]: 1}, None)

    def _own_grasps(self, name: str) -> list[Grasp] | None:
        """The caller's grasps of an object that can be done now; None where they are to be searched for."""
        if name not in self._grasps:
            return None
        station, scene = self.station, self.situation.scene
        return doable(self._grasps[name], scene, station.arm, station.pose_base_to_world)


def _falling(transfer: Transfer, proof: Proof) -> Transfer:
    """A transfer to a place where the object need not stay, which then says what becomes of it."""
    place = transfer.placement
    if proof.holds(place):
        return transfer
    words = f"{place.rest}: let go, {proof.settled(place)}"
    return replace(
        transfer,
        placement=replace(place, rest=words, falls=True),
        fallbacks=(*transfer.fallbacks, Fallback.LET_FALL),
    )
