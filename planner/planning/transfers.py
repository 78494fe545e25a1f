"""How one object can be moved in a situation: to a free place, or to given ones, by what the arm has."""

from collections.abc import Collection, Sequence
from dataclasses import replace
from functools import partial

from topple.planner.failure import FailureLog, TransferFailure
from topple.planner.fallbacks import Relaxation
from topple.planner.grasp.candidates import grasp_candidates
from topple.planner.grasp.given import doable
from topple.planner.grasp.grasp import Grasp
from topple.planner.grasp.surroundings import Dropped
from topple.planner.placement.away import Away
from topple.planner.placement.drops import try_standing
from topple.planner.placement.placement import Placement, placements
from topple.planner.placement.proof import Proof
from topple.planner.placement.shortage import shortage
from topple.planner.planning.step import Context
from topple.planner.planning.tolerances import BESIDE, MORE_PLACES
from topple.planner.transfer.handling import Handling, Reached
from topple.planner.transfer.limits import TRANSFER_LIMITS, TransferLimits
from topple.planner.transfer.transfer import NO_PLACE, Transfer, TransferRequest, no_grasp, plan_transfer
from topple.robots.arm.home import scale_of, workplace_of
from topple.robots.collision.fcl_bodies import apart
from topple.topology.base.arrays import FloatArray
from topple.topology.situation.situation import Situation
from topple.topology.sixim.table import Relation

INSIDE = (Relation.WITHIN, Relation.PARTIAL_WITHIN)
MORE_HANDS = TransferLimits(grasps=60, reached=80)  # all hands that a search for grasps finds


class Transfers:
    """The transfers that an arm can make in one situation.

    Args:
        situation: What is seen, or what should be there by now.
        context: What they are made in. Where no look follows, a place has to hold in simulation.
        held: The grasp by which the arm has closed on an object already: it can move that one alone.
    """

    def __init__(self, situation: Situation, context: Context, held: Reached | None = None) -> None:
        self.situation, self.context, self._held = situation, context, held

    def aside(
        self,
        name: str,
        remaining: Collection[str],
        wanted: Sequence[FloatArray] = (),
        longer: bool = False,
    ) -> Transfer | TransferFailure:
        """Move an object to a free place on a top, or say why it cannot be.

        Args:
            name: The object.
            remaining: What is still to be taken, and not to be put in the way of.
            wanted: (N, 3) points each [m]: places that other things shall have.
            longer: Look at more places, and more hands.
        """
        if name in self.context.given_up:
            return self._refuse(name)
        station, own, away = self.context.station, self.situation.scene.clouds[name], self.context.away
        if away is not None:
            places = away.places(name, self.situation.with_completed(name), self.context.obstacles)
            if away.how is Away.ZONE:
                places = try_standing(places, name, self.situation, away.bodies, self.context.sandbox)
            return self.to(name, places)
        find = partial(
            placements,
            name,
            self.situation.with_completed(name),
            pose_base_to_world=station.pose_base_to_world @ workplace_of(station.arm),
            remaining=remaining,
            **({"limit": MORE_PLACES} if longer else {}),
            scale=scale_of(station.arm),
        )
        places = find(avoid=[own, *wanted]) or find(avoid=wanted) or (find() if wanted else [])
        limits = MORE_HANDS if longer else TRANSFER_LIMITS
        places = try_standing(places, name, self.situation, sandbox=self.context.sandbox)
        return self.to(name, places, limits)

    def to(
        self, name: str, places: Sequence[Placement], limits: TransferLimits = TRANSFER_LIMITS
    ) -> Transfer | TransferFailure:
        """Move an object to one of some places, or say why it cannot be.

        Args:
            name: The object.
            places: Where it may go, best first.
            limits: How hard to look.
        """
        if name in self.context.given_up:
            return self._refuse(name)
        context = self.context
        places = [place for place in places if not any(map(place.same, context.barred))] or places
        grasps, refused = self._own_grasps(name)
        if refused.reasons and not grasps:
            return no_grasp(name, refused, self.situation.scene)
        asked = TransferRequest(
            places, grasps, context.avoid.get(name, ()), self.riders(name), name in context.upright,
            held=self._held, obstacles=context.obstacles, relaxations=context.relaxations,
        )  # fmt: skip
        transfer = partial(plan_transfer, name, self.situation, context.station, seed=context.seed)
        if context.observed:  # what is seen of it may be wrong: the best of all hands takes it
            return transfer(asked, limits=replace(limits, enough=float("inf")))
        beside = {} if context.away is None else context.obstacles
        proof = Proof(name, self.situation, self.riders(name), beside, context.sandbox)
        found = transfer(replace(asked, holds=proof.holds), limits=limits)
        drop = context.allow_drop and Relaxation.LET_FALL in context.relaxations
        if isinstance(found, TransferFailure) and drop:
            found = transfer(asked, limits=limits)
            return found if isinstance(found, TransferFailure) else _as_drop(found, proof)
        return found

    def explain(self, failure: TransferFailure) -> TransferFailure:
        """A failure for want of a place with its reason; any other as it is."""
        if NO_PLACE not in failure.reasons:
            return failure
        station, name = self.context.station, failure.object
        why = shortage(name, self.situation.with_completed(name), station.arm, station.pose_base_to_world)
        return TransferFailure.no_place(name, why)

    def barriers(self, failure: TransferFailure) -> list[str]:
        """Movable objects whose removal may help: those met in the search, and those beside.

        What reaches down least comes first: least may lean on it that was not seen to.
        """
        solids, up, scene = self.situation.solids, self.situation.up, self.situation.scene
        movable = set(scene.movable) - {failure.object, *self.context.given_up}
        own = solids[failure.object]
        near = [n for n in movable if n in failure.barring or not apart(own, solids[n], BESIDE)]
        bottom = {name: round(float((scene.clouds[name] @ up).min()), 2) for name in near}
        return sorted(near, key=lambda name: (-bottom[name], name))

    def riders(self, name: str) -> tuple[str, ...]:
        """Contents of an object that is kept upright."""
        return self.inside(name) if name in self.context.upright else ()

    def inside(self, name: str) -> tuple[str, ...]:
        """Contents of an object."""
        between = self.situation.relations.between
        movable = self.situation.movable
        return tuple(n for n in movable if n != name and between(n, name).relation in INSIDE)

    def hands(self, name: str) -> list[Reached]:
        """How the arm could stand to take an object, wherever it would be put."""
        if name in self.context.given_up:
            return []
        station, seed = self.context.station, self.context.seed
        grasps, _ = self._own_grasps(name)
        found = grasp_candidates(name, self.situation, station.arm) if grasps is None else grasps
        handling = Handling(name, self.situation, station, (), seed, self.context.obstacles)
        log = FailureLog(frozenset())
        most = found[: TRANSFER_LIMITS.grasps]
        return list(handling.reach(handling.hands(most, station.q, log), True, log))

    def _refuse(self, name: str) -> TransferFailure:
        return TransferFailure(name, {self.context.given_up[name]: 1}, None)

    def _own_grasps(self, name: str) -> tuple[list[Grasp] | None, Dropped]:
        """The caller's grasps of an object that can be done now, and why the others cannot be.

        None where they are to be searched for.
        """
        if name not in self.context.grasps:
            return None, Dropped()
        station = self.context.station
        return doable(self.context.grasps[name], self.situation, station.arm, station.pose_base_to_world)


def _as_drop(transfer: Transfer, proof: Proof) -> Transfer:
    """A transfer to a place where the object need not stay, which then says what becomes of it."""
    place = transfer.placement
    if proof.holds(place):
        return transfer
    words = f"{place.rest}: let go, {proof.settle(place)}"
    return replace(
        transfer,
        placement=replace(place, rest=words, falls=True),
        fallbacks=(*transfer.fallbacks, Relaxation.LET_FALL),
    )
