"""One pick and place: grasps, inverse kinematics and placements screened together, then the motions."""

from collections import Counter
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache, partial
from itertools import chain, islice, tee

import numpy as np

from topple.planner.failure import Check, FailedCheck, FailureLog, TransferFailure
from topple.planner.fallbacks import RELAXATIONS, Relaxation
from topple.planner.grasp.candidates import grasp_candidates
from topple.planner.grasp.grasp import Grasp
from topple.planner.grasp.load import beyond_arm
from topple.planner.grasp.shape import shapes_of
from topple.planner.grasp.surroundings import Dropped
from topple.planner.motion.upright import Upright
from topple.planner.placement.away import IN_HAND
from topple.planner.placement.placement import Placement, placements
from topple.planner.transfer.handling import Handling, Reached
from topple.planner.transfer.limits import TRANSFER_LIMITS, TransferLimits
from topple.planner.transfer.segments import Segment, SegmentKind
from topple.planner.transfer.stages import Stage, segments_of
from topple.planner.transfer.tolerances import LEVEL, MARGIN, NARROW, TIRED
from topple.robots.arm.arm import Station
from topple.robots.arm.home import scale_of, workplace_of
from topple.topology.base.arrays import FloatArray, freeze
from topple.topology.base.errors import UnknownObject
from topple.topology.bodies.solids import Solids
from topple.topology.scene.scene import Scene
from topple.topology.situation.situation import Situation

NO_GRASP, NO_PLACE = "no grasp that holds and has room", "no free place within reach"
FALLS = "place: it would not stay as it is let go there, and no drop is allowed"


@dataclass(frozen=True, eq=False)
class Transfer:
    """A pick and place that was found free of collisions.

    Attributes:
        object: What is moved.
        grasp: How it is held.
        placement: Where it goes.
        segments: What the arm does, in order.
        q_end: (n,) joint values afterwards [rad].
        tried: What was dropped on the way here, with counts.
        riding: What lies in the object and goes with it.
        upright: Whether the object was kept upright.
        fallbacks: What was tried to find it where the plain way failed.
    """

    object: str
    grasp: Grasp
    placement: Placement
    segments: tuple[Segment, ...]
    q_end: FloatArray
    tried: Mapping[str, int]
    riding: tuple[str, ...] = ()
    upright: bool = False
    fallbacks: tuple[Relaxation, ...] = ()

    def __post_init__(self) -> None:
        object.__setattr__(self, "q_end", freeze(self.q_end))

    @property
    def seconds(self) -> float:
        """Duration of the motions [s]."""
        return sum(segment.seconds for segment in self.segments)


@dataclass(frozen=True, eq=False)
class TransferRequest:
    """What is asked of a transfer: how an object may be taken, and where to.

    Attributes:
        places: Where it may go, best first; free places on the table where None.
        grasps: How it may be held, best first; found from the clouds where None.
        avoid: Grasps that failed: none near them is tried while there are others.
        riding: What lies in the object and goes with it.
        upright: Whether it is kept upright on the way; where something rides in it, if None.
        holds: Whether the object stays where a place has it; where None, all do.
        held: The grasp by which the hand has closed on it already; the transfer begins with the lift then.
        obstacles: Bodies that are in the way and no part of the scene: another arm, as it stands.
        relaxations: What may be tried where the plain way fails.
    """

    places: Sequence[Placement] | None = None
    grasps: Sequence[Grasp] | None = None
    avoid: Sequence[Grasp] = ()
    riding: Sequence[str] = ()
    upright: bool | None = None
    holds: Callable[[Placement], bool] | None = None
    held: Reached | None = None
    obstacles: Solids | None = None
    relaxations: Collection[str] = RELAXATIONS

    @property
    def level(self) -> bool:
        """Whether the object is kept upright."""
        return bool(self.riding) if self.upright is None else self.upright


def plan_transfer(
    name: str,
    scene: Scene | Situation,
    station: Station,
    asked: TransferRequest | None = None,
    seed: int = 0,
    limits: TransferLimits = TRANSFER_LIMITS,
) -> Transfer | TransferFailure:
    """Plan taking one object and putting it somewhere else.

    Args:
        name: The object.
        scene: What is seen now, with `up`, or the situation it was read as.
        station: The arm as it stands now.
        asked: How it may be taken, and where to; anyhow, and to a free place, where None.
        seed: For inverse kinematics and sampling planners.
        limits: How hard to look and how fast to move.

    Returns:
        The transfer, or why there is none. Deterministic for one seed.

    Raises:
        UnknownObject: The scene has no such object.
    """
    situation = Situation.of(scene)
    scene = situation.scene
    if name not in scene.clouds:
        raise UnknownObject(name, scene.names)
    arm, asked = station.arm, asked or TransferRequest()
    grasps, avoid = asked.grasps, asked.avoid
    if asked.held is not None:
        grasps, avoid = [asked.held.grasp], ()
    searched, dropped, changed, few = grasps is None, Dropped(), False, list[Grasp]()
    places = asked.places
    if places is None:
        workplace = station.pose_base_to_world @ workplace_of(arm)
        places = placements(name, situation, pose_base_to_world=workplace, scale=scale_of(arm))
    handling = Handling(name, situation, station, tuple(asked.riding), seed, asked.obstacles)
    find = partial(grasp_candidates, name, situation, wide=bool(avoid), out=handling.shared_way_out(places))
    spare = {tool: shape for tool, shape in shapes_of(arm).items() if shape.spare}
    spare = spare if Relaxation.OTHER_TOOL in asked.relaxations else {}
    if grasps is None:
        few = find(arm, enough=limits.enough) if limits.enough < np.inf and not avoid else []
        grasps = few or _others(find(arm, dropped=dropped), avoid)
        if grasps and spare and all(grasp.tool in _tired_tools(avoid) for grasp in grasps):
            grasps = _others(find(tools=list(spare.values())), avoid) or grasps
            changed = True
    else:
        grasps = _others(list(grasps), avoid)
    if words := beyond_arm(handling.load[0], arm):
        return TransferFailure(name, {words: 1}, None, FailedCheck(SegmentKind.GRASP, Check.STRENGTH, words))
    if asked.level:
        places = [place for place in places if place.tilt(situation.up) < LEVEL]
    if not grasps:
        return no_grasp(name, dropped, scene)
    if not places:
        return TransferFailure.no_place(name, NO_PLACE)
    search = _Search(handling, replace(asked, places=tuple(places)), limits.of(arm))
    spared = searched and bool(spare) and not any(grasp.tool in spare for grasp in grasps)

    def other() -> list[Grasp]:
        return _others(find(tools=list(spare.values())), avoid) if spared else find(arm) if few else []

    found = search.run_seen_first(grasps, cache(other))
    if isinstance(found, TransferFailure):
        return found
    changed |= spared and found.grasp.tool in spare
    said = [Relaxation.OTHER_TOOL] * changed + [Relaxation.UNSEEN] * found.grasp.unseen
    return replace(found, fallbacks=(*said, *found.fallbacks)) if said else found


def no_grasp(name: str, dropped: Dropped, scene: Scene) -> TransferFailure:
    """The certificate that says what every grasp that was looked at failed of."""
    reasons = dict(dropped.reasons.most_common()) or {NO_GRASP: 1}
    barring = {other: count for other, count in dropped.barring.most_common() if other not in scene.fixed}
    failed = FailedCheck(SegmentKind.GRASP, Check.ROOM, next(iter(reasons)))
    return TransferFailure(name, reasons, next(iter(barring), None), failed, barring)


def _others(grasps: list[Grasp], avoid: Sequence[Grasp]) -> list[Grasp]:
    """The grasps by a tool that did not fail time and again, and not near one that failed, if there are."""
    tired = _tired_tools(avoid)
    far = [grasp for grasp in grasps if not any(grasp.near(other) for other in avoid)]
    return [grasp for grasp in far if grasp.tool not in tired] or far or grasps


def _tired_tools(failed: Sequence[Grasp]) -> set[str]:
    """Tools that failed so often that another one should be tried."""
    counts = Counter(grasp.tool for grasp in failed)
    return {tool for tool, count in counts.items() if count >= TIRED}


@dataclass(frozen=True)
class _Way:
    """One way to go about a transfer: to which places, and how much is kept clear of."""

    places: tuple[Placement, ...]
    lenient: bool
    margin: float
    fallbacks: tuple[Relaxation, ...]


class _Search:
    """The state of one search: what was tried and what it failed of."""

    def __init__(self, handling: Handling, asked: TransferRequest, limits: TransferLimits) -> None:
        self.handling, self.asked, self.limits = handling, asked, limits
        self.places = asked.places or ()
        self.log = FailureLog(frozenset(handling.bodies) - {handling.name})
        self._ahead: dict[Reached, tuple[Stage, Stage]] = {}
        self._roomy: dict[tuple[Grasp, tuple[Placement, ...]], list[Placement]] = {}

    def run_seen_first(
        self, grasps: Sequence[Grasp], more: Callable[[], Sequence[Grasp]]
    ) -> Transfer | TransferFailure:
        """Complete a transfer by one of some grasps or of more of them, by one that comes unseen last."""
        for unseen in (False, True) if Relaxation.UNSEEN in self.asked.relaxations else (False,):
            for some in (lambda: grasps, more):
                found = self.run([grasp for grasp in some() if grasp.unseen == unseen])
                if isinstance(found, Transfer):
                    return found
        return self.log.failure(self.handling.name)

    def run(self, grasps: Sequence[Grasp]) -> Transfer | TransferFailure:
        """Complete a transfer that starts with one of some grasps, best first, or say why there is none."""
        self._barred: list[tuple[Reached, _Way]] = []
        reached: list[Iterator[Reached]]
        if self.asked.held is None:
            both = tee(self.handling.hands(grasps[: self.limits.grasps], self.handling.q_start, self.log))
            reached = [self.handling.reach(hands, bool(k), self.log) for k, hands in enumerate(both)]
        else:
            reached = [iter([self.asked.held]), iter([self.asked.held])]
        for way in self._ways():
            if not set(way.fallbacks) <= set(self.asked.relaxations):
                continue
            states, reached[way.lenient] = tee(reached[way.lenient])  # looked for once, when asked
            for state in islice(states, self.limits.reached):
                transfer = self._with(state, way)
                if transfer is not None:
                    return transfer
        for state, way in self._barred[: NARROW if Relaxation.NARROW in self.asked.relaxations else 0]:
            narrow = replace(way, margin=0.0, fallbacks=(*way.fallbacks, Relaxation.NARROW))
            transfer = self._with(state, narrow)
            if transfer is not None:
                return transfer
        return self.log.failure(self.handling.name)

    def _ways(self) -> Iterator[_Way]:
        """The ways in the order in which they are tried, the plain one first."""
        steady = [place for place in self.places if not place.rolls]
        low = [place for place in steady if place.into is None and place.how not in IN_HAND]
        flat = [place.higher(self.limits.fall, self.handling.up) for place in low]
        choices: tuple[tuple[tuple[Relaxation, ...], list[Placement]], ...] = (
            ((), steady),
            ((Relaxation.LET_FALL_A_LITTLE,), flat),
            ((Relaxation.WHERE_IT_ROLLS,), [place for place in self.places if place.rolls]),
        )
        for names, places in choices:
            if places:
                yield _Way(tuple(places), False, MARGIN, names)
                yield _Way(tuple(places), True, MARGIN, (*names, Relaxation.THROUGH_GUESSES))

    def _with(self, state: Reached, way: _Way) -> Transfer | None:
        """Complete a transfer in one way that starts with one reachable grasp."""
        grasp, limits, handling, log = state.grasp, self.limits, self.handling, self.log
        room = self._room(grasp, way.places)
        if not room:
            return None
        if state not in self._ahead:
            if state is self.asked.held:  # the way in is behind it
                approach = lift = handling.lift(state, limits.lift, log)
            else:
                approach = handling.approach(state, limits.approach, log)
                lift = handling.lift(state, limits.lift, log) if approach.path is not None else approach
            self._ahead[state] = approach, lift
        approach, lift = self._ahead[state]
        if approach.path is None or lift.path is None:
            return None
        top = lift.way[-1]
        free = handling.ends(state, room, top, limits.drop, limits.retreat, log)
        ends = list(islice(free, limits.goals))
        if not ends or not approach.prove() or not lift.prove():
            return None
        carrying = handling.checker(SegmentKind.TRANSFER, grasp, margin=way.margin)
        carry = Stage(SegmentKind.TRANSFER, carrying, log)
        upright, goal = self._upright(grasp), None
        while goal is None or not self._stays(ends[goal].placement):
            if goal is not None:  # refuted: only where it stays from now on
                ends = list(islice((e for e in chain(ends, free) if self._stays(e.placement)), limits.goals))
                if not ends:
                    return None
            goals = np.array([end.lower[0] for end in ends])
            goal = carry.search(top, goals, handling.seed, limits.rounds, upright)
            if goal is None:
                self._barred += [(state, way)] if way.margin > 0.0 else []
                return None
        if not handling.bears(carry, grasp):
            return None
        end, held = ends[goal], ends[goal].placement.how in IN_HAND
        lower, retreat = (
            Stage(kind, handling.checker(kind, grasp, end.placement), log, path)
            for kind, path in ((SegmentKind.PLACE, end.lower), (SegmentKind.RETREAT, end.retreat))
        )
        if not held and not (lower.prove() and retreat.prove()):
            return None
        stages = (lift, carry) if held else (lift, carry, lower, retreat)
        if state is not self.asked.held:
            move = Stage(SegmentKind.MOVE, handling.checker(SegmentKind.MOVE, grasp), log)
            if move.search(self.handling.q_start, approach.way[:1], handling.seed, limits.rounds) is None:
                return None
            stages = (move, approach, *stages)
        segments = segments_of(stages, grasp, limits)
        if state is self.asked.held:
            segments = segments[1:]  # the hand is closed
        return Transfer(
            handling.name, grasp, end.placement, segments, end.retreat[-1], dict(log.reasons),
            handling.riding, self.asked.level, way.fallbacks,
        )  # fmt: skip

    def _upright(self, grasp: Grasp) -> Upright | None:
        """How the tool is kept while it carries what must not tilt."""
        if not self.asked.level:
            return None
        return Upright(grasp.tool, self.handling.world_to_base[:3, :3] @ self.handling.up, self.limits.tilt)

    def _room(self, grasp: Grasp, places: tuple[Placement, ...]) -> list[Placement]:
        """Places where the hand has room, looked for once for all states of a grasp."""
        key = (grasp, places)
        if key not in self._roomy:
            way = self.limits.drop, self.limits.retreat
            found = (
                places if places[0].how in IN_HAND else self.handling.open_ends(grasp, places, *way, self.log)
            )
            self._roomy[key] = list(found)
        return self._roomy[key]

    def _stays(self, place: Placement) -> bool:
        """Whether the object holds at a place; where it does not, that is noted."""
        if self.asked.holds is None or self.asked.holds(place):
            return True
        self.log.note(SegmentKind.PLACE, Check.STAND, FALLS)
        return False
