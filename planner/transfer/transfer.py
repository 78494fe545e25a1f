"""One pick and place: grasps, inverse kinematics and placements screened together, then the motions."""

from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np

from topple.planner.failure import Setback, Tally, TransferFailure
from topple.planner.grasp.candidates import grasp_candidates
from topple.planner.grasp.grasp import Grasp
from topple.planner.grasp.hand import hand_shape
from topple.planner.grasp.surroundings import Dropped
from topple.planner.motion.certificate import Certifier
from topple.planner.motion.collision import Checker
from topple.planner.motion.planner import Motion, MotionFailure, plan_motion
from topple.planner.motion.upright import plan_upright
from topple.planner.placement.placement import Placement, placements
from topple.planner.transfer.checks import MARGIN
from topple.planner.transfer.handling import Handling, Reached
from topple.planner.transfer.legs import Leg, segments_of
from topple.planner.transfer.segments import Segment
from topple.robots.arm.arm import Arm
from topple.topology.arrays import FloatArray, frozen
from topple.topology.bodies.solids import GRAIN
from topple.topology.errors import UnknownObject
from topple.topology.geometry.samples import sampled
from topple.topology.scene import Scene
from topple.topology.situation import Situation


@dataclass(frozen=True)
class TransferLimits:
    """How hard to look, and how fast to move.

    Attributes:
        grasps: Best grasps to ask inverse kinematics for; each is tried with the hand turned half as well.
        reached: Reachable grasp states to follow up.
        goals: Placements a motion is planned to at once.
        approach: Straight way in before the grasp [m].
        lift: Straight way up after it [m].
        drop: Straight way down before the release [m].
        fall: How far more a thing may fall where no hand gets down with it [m]: crockery stands it.
        retreat: Straight way out after it [m].
        straight_speed: Of the tool on straight ways [m/s]: lifts at it are known to disturb little.
        speed: Share of the joints' velocity limits for the other motions.
        budget: Seconds for one free motion.
        tilt: Largest tilt of what is carried upright [rad]: a glass filled to nine tenths does not spill.
    """

    grasps: int = 24
    reached: int = 12
    goals: int = 4
    approach: float = 0.08
    lift: float = 0.10
    drop: float = 0.06
    fall: float = 0.02
    retreat: float = 0.08
    straight_speed: float = 0.08
    speed: float = 0.5
    budget: float = 2.0
    tilt: float = 0.15


TRANSFER_LIMITS = TransferLimits()
TIRED = 2  # failures of one tool after which another has its turn: a surface that leaks leaks elsewhere too
NARROW = 3  # ways barred at the usual distance that are tried again at any distance, before giving up
LEVEL = 0.02  # [rad] a placement that tilts a thing less keeps it upright: noise of the up direction
ROUNDING = 2e-5  # [m] proven clearance that writing a plan with six digits cannot use up
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
    """

    object: str
    grasp: Grasp
    placement: Placement
    segments: tuple[Segment, ...]
    q_end: FloatArray
    tried: Mapping[str, int]
    riding: tuple[str, ...] = ()
    upright: bool = False

    def __post_init__(self) -> None:
        object.__setattr__(self, "q_end", frozen(self.q_end))

    @property
    def seconds(self) -> float:
        """Duration of the motions [s]."""
        return sum(float(s.trajectory.times[-1]) for s in self.segments if s.trajectory is not None)


def plan_transfer(
    name: str,
    scene: Scene | Situation,
    arm: Arm,
    pose_base_to_world: FloatArray,
    q_start: FloatArray,
    places: Sequence[Placement] | None = None,
    *,
    grasps: Sequence[Grasp] | None = None,
    avoid: Sequence[Grasp] = (),
    riding: Sequence[str] = (),
    upright: bool | None = None,
    holds: Callable[[Placement], bool] | None = None,
    seed: int = 0,
    limits: TransferLimits = TRANSFER_LIMITS,
) -> Transfer | TransferFailure:
    """Plan taking one object and putting it somewhere else.

    Args:
        name: The object.
        scene: What is seen now, with `up`, or the situation it was read as.
        arm: The arm.
        pose_base_to_world: (4, 4) where it stands.
        q_start: (n,) joint values now [rad].
        places: Where it may go, best first; free places on the table where None.
        grasps: How it may be held, best first; found from the clouds where None.
        avoid: Grasps that failed: none near them is tried while there are others.
        riding: What lies in the object and goes with it.
        upright: Whether it is kept upright on the way; where something rides in it, if None.
        holds: Whether the object stays where a place has it; where None, all do.
        seed: For inverse kinematics and sampling planners.
        limits: How hard to look and how fast to move.

    Returns:
        The transfer, or why there is none. Deterministic for one seed while no planner runs out of budget.

    Raises:
        UnknownObject: The scene has no such object.
    """
    situation = Situation.of(scene)
    scene = situation.scene
    if name not in scene.clouds:
        raise UnknownObject(name, scene.names)
    searched, dropped = grasps is None, Dropped()
    find = partial(grasp_candidates, name, situation, wide=bool(avoid))
    if grasps is None:
        grasps = _others(find(arm, dropped=dropped), avoid)
        if grasps and "fingers" in arm.tools and all(grasp.tool in _tired(avoid) for grasp in grasps):
            grasps = _others(find(hand=hand_shape(arm)), avoid) or grasps
    else:
        grasps = _others(list(grasps), avoid)
    if places is None:
        places = placements(name, situation, pose_base_to_world=pose_base_to_world)
    level = bool(riding) if upright is None else upright
    if level:
        places = [place for place in places if place.tilt(situation.up) < LEVEL]
    if not grasps:
        return _no_grasp(name, dropped, scene)
    if not places:
        return TransferFailure(name, {NO_PLACE: 1}, None, Setback("place", "room", NO_PLACE))
    handling = Handling(name, situation, arm, np.asarray(pose_base_to_world), tuple(riding), seed)
    search = _Search(handling, tuple(places), np.asarray(q_start), level, seed, limits, holds)
    found = search.run(grasps)
    by_cup_alone = searched and all(grasp.tool == "suction" for grasp in grasps) and "fingers" in arm.tools
    if isinstance(found, TransferFailure) and by_cup_alone:
        return search.run(_others(find(hand=hand_shape(arm)), avoid))
    return found


def _no_grasp(name: str, dropped: Dropped, scene: Scene) -> TransferFailure:
    """The certificate that says what every grasp that was looked at failed of."""
    reasons = dict(dropped.reasons.most_common()) or {NO_GRASP: 1}
    barring = {other: count for other, count in dropped.barring.most_common() if other not in scene.fixed}
    setback = Setback("grasp", "room", next(iter(reasons)))
    return TransferFailure(name, reasons, next(iter(barring), None), setback, barring)


def _others(grasps: list[Grasp], avoid: Sequence[Grasp]) -> list[Grasp]:
    """The grasps by a tool that did not fail time and again, and not near one that failed, if there are."""
    tired = _tired(avoid)
    far = [grasp for grasp in grasps if not any(grasp.near(other) for other in avoid)]
    return [grasp for grasp in far if grasp.tool not in tired] or far or grasps


def _tired(failed: Sequence[Grasp]) -> set[str]:
    """Tools that failed so often that another one should be tried."""
    counts = Counter(grasp.tool for grasp in failed)
    return {tool for tool, count in counts.items() if count >= TIRED}


class _Search:
    """The state of one search: what was tried and what it failed of."""

    def __init__(
        self,
        handling: Handling,
        places: tuple[Placement, ...],
        q_start: FloatArray,
        level: bool,
        seed: int,
        limits: TransferLimits,
        holds: Callable[[Placement], bool] | None = None,
    ) -> None:
        self.handling, self.places, self.q_start, self.level = handling, places, q_start, level
        self.seed, self.limits, self._holds = seed, limits, holds
        self.tally = Tally(frozenset(handling.bodies) - {handling.name})
        self._known: dict[Reached, tuple[FloatArray, FloatArray] | None] = {}
        self._roomy: dict[tuple[Grasp, tuple[Placement, ...]], list[Placement]] = {}
        self._margin = MARGIN  # least distance kept while carrying
        self._barred: list[tuple[Reached, tuple[Placement, ...]]] = []

    def run(self, grasps: Sequence[Grasp]) -> Transfer | TransferFailure:
        hands = self.handling.hands(grasps[: self.limits.grasps], self.q_start, self.tally)
        reached = dict[bool, list[Reached]]()
        for places in self._choices():
            for lenient in (False, True):
                if lenient not in reached:
                    reached[lenient] = self.handling.reached(hands, lenient, self.tally)
                for state in reached[lenient][: self.limits.reached]:
                    transfer = self._with(state, places)
                    if transfer is not None:
                        return transfer
        self._margin = 0.0
        for state, places in self._barred[:NARROW]:
            transfer = self._with(state, places)
            if transfer is not None:
                return transfer
        return self.tally.failure(self.handling.name)

    def _choices(self) -> list[tuple[Placement, ...]]:
        """Places where it neither rolls nor bars a way out, and only if none can be reached the others.

        Fingers that reach below a flat thing have no room between it and the table: it may fall that far.
        """
        steady = [place for place in self.places if not place.rolls]
        flat = [place for place in steady if place.into is None]
        groups = (
            [place for place in steady if not place.bars],
            [place for place in steady if place.bars],
            [place.higher(self.limits.fall, self.handling.up) for place in flat],
            [place for place in self.places if place.rolls],
        )
        return [tuple(places) for places in groups if places]

    def _with(self, state: Reached, places: tuple[Placement, ...]) -> Transfer | None:
        """Complete a transfer to one of some places that starts with one reachable grasp."""
        grasp, limits, handling = state.grasp, self.limits, self.handling
        room = self._room(grasp, places)
        if not room or (ways := self._ways(state)) is None:
            return None
        approach, lift = ways
        ends = handling.ends(state, room, lift[-1], limits.drop, limits.retreat, limits.goals, self.tally)
        if not ends:
            return None
        ahead = [Leg("approach", approach, handling.approaching(grasp, state.lenient), straight=True)]
        ahead.append(Leg("lift", lift, handling.lifting(grasp, state.lenient), straight=True))
        if not self._proven(ahead):
            return None
        carrying = handling.carrying(grasp, self._margin)
        tops = np.array([end.lower[0] for end in ends])
        carry = self._way("transfer", carrying, lift[-1], tops, grasp.tool if self.level else None)
        if carry is None:
            self._barred += [(state, places)] if self._margin > 0.0 else []
            return None
        end = ends[carry.goal]
        lowering = handling.carrying(grasp, 0.0, end.placement.into)
        behind = [Leg("place", end.lower, lowering, straight=True)]
        behind.append(Leg("retreat", end.retreat, handling.parting(grasp, end.placement), straight=True))
        emptied = handling.empty(grasp.opening)
        move = self._way("move", emptied, self.q_start, approach[:1]) if self._proven(behind) else None
        if move is None:
            return None
        legs = [Leg("move", move.path, emptied, certificate=move.certificate), *ahead]
        legs += [Leg("transfer", carry.path, carrying, certificate=carry.certificate), *behind]
        segments = segments_of(legs, handling, grasp, end.placement, limits.speed, limits.straight_speed)
        q_end, tried = end.retreat[-1], dict(self.tally.reasons)
        return Transfer(
            handling.name, grasp, end.placement, segments, q_end, tried, handling.riding, self.level
        )

    def _room(self, grasp: Grasp, places: tuple[Placement, ...]) -> list[Placement]:
        """Places where the hand has room and the object stays, looked for once for all states of a grasp."""
        key = (grasp, places)
        if key not in self._roomy:
            way = self.limits.drop, self.limits.retreat
            room = self.handling.open_ends(grasp, places, *way, self.tally)
            self._roomy[key] = [place for place in room if self._stays(place)]
        return self._roomy[key]

    def _stays(self, place: Placement) -> bool:
        """Whether the object holds at a place; where it does not, that is noted."""
        if self._holds is None or self._holds(place):
            return True
        self.tally.note("place", "stand", FALLS)
        return False

    def _ways(self, state: Reached) -> tuple[FloatArray, FloatArray] | None:
        """Straight ways in and up at a state, looked for once for all places; None where there is none."""
        if state not in self._known:
            approach = self.handling.way_in(state, self.limits.approach, self.tally)
            lift = None if approach is None else self.handling.way_up(state, self.limits.lift, self.tally)
            self._known[state] = None if approach is None or lift is None else (approach, lift)
        return self._known[state]

    def _proven(self, legs: Sequence[Leg]) -> bool:
        """Certify straight legs; what touches between their samples is noted."""
        for leg in legs:
            leg.certificate = Certifier(leg.checker).path(leg.path, ROUNDING)
            if not leg.certificate.proven:
                found = leg.certificate.contact
                pair = None if found is None else (found.a, found.b)
                words = "something" if pair is None else " and ".join(pair)
                text = f"{leg.kind}: {words} too close between samples"
                self.tally.note(leg.kind, "proof", text, leg.certificate.state, pair)
                return False
        return True

    def _way(
        self, kind: str, checker: Checker, start: FloatArray, goals: FloatArray, level: str | None = None
    ) -> Motion | None:
        """A proven free motion, with the tool named `level` kept as it stands against up; or None, noted."""
        if level is None:
            found = plan_motion(checker, start, goals, seed=self.seed, budget=self.limits.budget)
        else:
            up = self.handling.world_to_base[:3, :3] @ self.handling.up
            found = plan_upright(
                checker, start, goals, level, up, self.limits.tilt, seed=self.seed, budget=self.limits.budget
            )
        if isinstance(found, MotionFailure):
            check = "collision" if found.stage in ("start", "goals") else "search"
            self.tally.note(kind, check, f"{kind}: {found.reason}", start, found.witness)
            return None
        if found.certificate is None or not found.certificate.proven:
            contact = None if found.certificate is None else found.certificate.contact
            pair = None if contact is None else (contact.a, contact.b)
            self.tally.note(kind, "proof", f"{kind}: too close between samples", start, pair)
            return None
        return found


def after(situation: Situation, transfer: Transfer) -> Situation:
    """Predict the situation once a transfer is done.

    What was put down on a table rests there on its underside, which cameras will see the edge of: where its
    cloud ends above that, points of its body are added below.

    Args:
        situation: Before it.
        transfer: The transfer.

    Returns:
        The situation with the object and what rides in it at its place; all else is where it was.
    """
    up, name = situation.up, transfer.object
    pose = transfer.placement.pose_at_rest(up)
    hidden = None
    if transfer.placement.into is None:
        body = sampled(situation.solids[name], 2.0 * GRAIN)
        seen_above = float((situation.scene.clouds[name] @ pose[:3, :3].T @ up).min())
        hidden = body[body @ pose[:3, :3].T @ up < seen_above]
    return situation.moved((name, *transfer.riding), pose, hidden)
