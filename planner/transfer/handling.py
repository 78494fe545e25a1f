"""What the arm reaches of one object's grasps and places, and the straight ways there and out."""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from topple.planner.failure import Check, FailureLog
from topple.planner.grasp.grasp import Grasp
from topple.planner.grasp.shape import coming_unseen, shapes_of
from topple.planner.motion.cartesian import straight_lines
from topple.planner.motion.collision import Checker
from topple.planner.motion.shortcut import densely
from topple.planner.placement.away import IN_HAND
from topple.planner.placement.placement import Placement
from topple.planner.placement.tolerances import OFF_BOARD
from topple.planner.transfer.checks import Checks
from topple.planner.transfer.segments import SegmentKind
from topple.planner.transfer.stages import Stage
from topple.planner.transfer.tolerances import AT_ONCE, MARGIN, SEEDS, STRAIN_STEP
from topple.robots.poses import inverse
from topple.topology.base.arrays import FloatArray
from topple.topology.geometry.rigid import move_points
from topple.topology.statics.way_out import leads_up


@dataclass(frozen=True, eq=False)
class Reached:
    """A grasp with joint values that make it.

    Attributes:
        grasp: The grasp.
        q: (n,) joint values [rad].
        lenient: Whether fingers may enter the inferred bodies of neighbours, whose clouds they are clear of.
    """

    grasp: Grasp
    q: FloatArray
    lenient: bool


@dataclass(frozen=True, eq=False)
class End:
    """The last part of a transfer.

    Attributes:
        placement: Where the object goes.
        lower: (k, n) straight way down to it.
        retreat: (m, n) straight way out.
    """

    placement: Placement
    lower: FloatArray
    retreat: FloatArray


class Handling(Checks):
    """Everything that is asked about moving one object in one scene."""

    def hands(
        self, grasps: Sequence[Grasp], near: FloatArray, log: FailureLog
    ) -> Iterator[tuple[Grasp, FloatArray]]:
        """Hand poses for grasps, each also turned half, with all joint values that are found.

        Args:
            grasps: In the world.
            near: (n,) joint values solutions should be close to.
            log: Notes what grasps are dropped for.

        Yields:
            In the grasps' order, but hands that come in unseen, turned and opened as they are, last.
        """
        both = [hand for grasp in grasps for hand in self.hand(grasp).turns(grasp)]
        poses = [self.tool_pose(grasp) for grasp in both]
        checkers = [self.checker(SegmentKind.APPROACH, grasp, lenient=True) for grasp in both]
        clear = self._clear_of(both, poses, checkers, "grasp", log)
        both = self._seen_first([grasp for grasp, free in zip(both, clear, strict=True) if free])
        for first in range(0, len(both), AT_ONCE):
            some = both[first : first + AT_ONCE]
            solutions = self._inverse(some, [self.tool_pose(grasp) for grasp in some], near)
            for grasp, states in zip(some, solutions, strict=True):
                if len(states):
                    yield grasp, states
                else:
                    log.note(SegmentKind.GRASP, Check.REACH, "grasp out of reach")

    def _seen_first(self, hands: Sequence[Grasp]) -> list[Grasp]:
        """Hands as they come in, each marked if no camera saw its way to be empty; those come last."""
        opened = [replace(grasp, opening=self.hand(grasp).ready(grasp).opening) for grasp in hands]
        unseen = coming_unseen(opened, self.situation, shapes_of(self.arm)).tolist()
        marked = [replace(hand, unseen=hidden) for hand, hidden in zip(hands, unseen, strict=True)]
        return sorted(marked, key=lambda hand: hand.unseen)

    def reach(
        self, hands: Iterable[tuple[Grasp, FloatArray]], lenient: bool, log: FailureLog
    ) -> Iterator[Reached]:
        """States of hand poses in which the open hand is free.

        Args:
            hands: As `hands` gives them.
            lenient: Whether fingers may enter inferred bodies of neighbours.
            log: Notes what grasps are dropped for.

        Yields:
            Free states, at most two for each hand pose.
        """
        for grasp, states in hands:
            checker = self.checker(SegmentKind.APPROACH, grasp, lenient=lenient)
            free = checker.free(states)
            if not free.any():
                Stage(SegmentKind.APPROACH, checker, log).blame(states[0], "grasp")
            yield from (Reached(grasp, q, lenient) for q in states[free][:2])

    def _clear_of(
        self,
        grasps: Sequence[Grasp],
        poses_tool_to_world: Sequence[FloatArray],
        checkers: Sequence[Checker],
        step: str,
        log: FailureLog,
    ) -> list[bool]:
        """Which hands in tool poses meet nothing, whatever the arm behind them does."""
        clear = [True] * len(grasps)
        for checker in dict.fromkeys(checkers):
            index = [i for i, other in enumerate(checkers) if other is checker]
            flange = [
                self.world_to_base @ poses_tool_to_world[i] @ self._to_flange(grasps[i].tool) for i in index
            ]
            for i, pair in zip(index, checker.hand_meets(np.array(flange)), strict=True):
                if pair is not None:
                    clear[i] = False
                    q = None
                    if log.further(step, stands=True):  # the one that is told says how the arm would stand
                        states = self._inverse([grasps[i]], [poses_tool_to_world[i]], self.arm.home)[0]
                        q = states[0] if len(states) else None
                    log.note(step, Check.COLLISION, f"{step}: {pair[0]} meets {pair[1]}", q, pair)
        return clear

    def _to_flange(self, tool: str) -> FloatArray:
        """(4, 4) pose of the flange in a tool's frame."""
        return inverse(self.arm.tool_to_flange(tool))

    def _inverse(
        self, grasps: Sequence[Grasp], poses_tool_to_world: Sequence[FloatArray], near: FloatArray
    ) -> list[FloatArray]:
        """Joint values for tool poses, grasp by grasp; one batch for each tool."""
        found: list[FloatArray] = [np.empty((0, len(self.arm.joints)))] * len(grasps)
        for tool in self.arm.tools:
            index = [i for i, grasp in enumerate(grasps) if grasp.tool == tool]
            if index:
                poses = self.world_to_base @ np.array([poses_tool_to_world[i] for i in index])
                rng = np.random.default_rng(self.seed)
                for i, states in zip(
                    index, self.arm.inverse(poses, tool, seeds=SEEDS, rng=rng, near=near), strict=True
                ):
                    found[i] = states
        return found

    # -- straight ways

    def approach(self, state: Reached, length: float, log: FailureLog) -> Stage:
        """Straight from before the object to the grasp."""
        back = np.eye(4)
        back[2, 3] = -length
        stage = self._stage(SegmentKind.APPROACH, state, log)
        self._straight(stage, state, self.tool_pose(state.grasp) @ back, backwards=True)
        return stage

    def _stage(self, kind: SegmentKind, state: Reached, log: FailureLog) -> Stage:
        return Stage(kind, self.checker(kind, state.grasp, lenient=state.lenient), log)

    def lift(self, state: Reached, length: float, log: FailureLog) -> Stage:
        """Straight the way out with the object: off what it stands on first, where that is not up."""
        stage = self._stage(SegmentKind.LIFT, state, log)
        moves = self._moves(self.situation.way_out(self.name), length)
        self._straight(stage, state, *(_translate(self.tool_pose(state.grasp), move) for move in moves))
        self.bears(stage, state.grasp)
        return stage

    def bears(self, stage: Stage, grasp: Grasp) -> bool:
        """Whether the joints hold what is carried all along a way, if there is one; else it is given up."""
        if stage.path is None:
            return False
        states = densely(stage.path, STRAIN_STEP)
        asked = self.strain(grasp, states)
        if asked.share > 1.0:
            text = f"{stage.kind}: {asked}"
            stage.log.note(stage.kind, Check.STRENGTH, text, states[asked.state])
            stage.path = None
        return stage.path is not None

    def _straight(self, stage: Stage, state: Reached, *targets: FloatArray, backwards: bool = False) -> None:
        """Give a stage the straight way from a state past tool poses (4, 4) in the world, if there is one."""
        stage.straight(self._continue(state.q[None], state.grasp, *targets), state.q, backwards)

    def _continue(self, path: FloatArray | None, grasp: Grasp, *targets: FloatArray) -> FloatArray | None:
        """A path (k, n) and the straight way on from its end past tool poses (4, 4) in the world, if any."""
        for target in targets:
            if path is not None:
                line = straight_lines(self.arm, path[-1:], (self.world_to_base @ target)[None], grasp.tool)[0]
                path = None if line is None else np.concatenate([path, line[1:]])
        return path

    def shared_way_out(self, places: Sequence[Placement]) -> FloatArray | None:
        """(3,) the way out of the first of some places, as the object is now, if all are left level.

        No hand from above gets into any of them: fingers have to come in against that way.
        """
        held = any(place.how in IN_HAND for place in places[:1])
        ways = [] if held else [self._moves_out(place, 1.0) for place in places]
        if not ways or any(len(way) == 1 for way in ways):
            return None
        return places[0].pose_before_to_after[:3, :3].T @ (ways[0][1] - ways[0][0])

    def _moves_out(self, place: Placement, length: float) -> tuple[FloatArray, ...]:
        """(3,) moves from a place out: to above it, or where something fixed is over it to before it."""
        points = move_points(self.scene.clouds[self.name], place.pose_before_to_after)
        return self._moves(self.situation.way_out_from(points), length)

    def _moves(self, out: FloatArray, length: float) -> tuple[FloatArray, ...]:
        """(3,) moves along a way out: off what it stands on first, where that is not up."""
        off = OFF_BOARD * self.up
        return (length * out,) if leads_up(out, self.up) else (off, off + length * out)

    def open_ends(
        self, grasp: Grasp, places: Sequence[Placement], drop: float, retreat: float, log: FailureLog
    ) -> list[Placement]:
        """Places where the hand is free: with the object there and above, without it there and drawn back.

        Whether the arm gets there is not asked.

        Args:
            grasp: The grasp.
            places: Placements.
            drop: Straight way down, or in [m].
            retreat: Straight way out [m].
            log: Notes what placements are dropped for.
        """
        carrying = self.checker(SegmentKind.PLACE, grasp, places[0])
        leaving = self.checker(SegmentKind.RETREAT, grasp, places[0], placed=False)
        found = list(places)
        for checker, step, way in (
            (carrying, "place", 0.0),
            (carrying, "place", drop),
            (leaving, "retreat", 0.0),
            (leaving, "retreat", retreat),
        ):
            back = np.eye(4)
            back[2, 3] = -way if checker is leaving else 0.0
            poses = [p.pose_before_to_after @ self.tool_pose(grasp) @ back for p in found]
            if checker is carrying and way:
                both = zip(poses, found, strict=True)
                poses = [_translate(pose, self._moves_out(place, way)[-1]) for pose, place in both]
            clear = self._clear_of([grasp] * len(found), poses, [checker] * len(found), step, log)
            found = [place for place, free in zip(found, clear, strict=True) if free]
        return found

    def ends(
        self,
        state: Reached,
        places: Sequence[Placement],
        near: FloatArray,
        drop: float,
        retreat: float,
        log: FailureLog,
    ) -> Iterator[End]:
        """Ways of ending a transfer that are free from above the place until the hand is out.

        Args:
            state: The grasp.
            places: Placements, best first, as `open_ends` leaves them.
            near: (n,) joint values to stay close to.
            drop: Straight way down, or in [m].
            retreat: Straight way out [m].
            log: Notes what placements are dropped for.

        Yields:
            Ends, best placements first, each placement once.
        """
        grasp, held = state.grasp, places[0].how in IN_HAND
        checker = self.checker(SegmentKind.PLACE, grasp, places[0], margin=MARGIN if held else 0.0)
        for first in range(0, len(places), AT_ONCE):
            some = places[first : first + AT_ONCE]
            targets = [place.pose_before_to_after @ self.tool_pose(grasp) for place in some]
            solved = self._inverse([grasp] * len(some), targets, near)
            tried: list[tuple[Placement, FloatArray, FloatArray]] = []
            for place, target, states in zip(some, targets, solved, strict=True):
                if len(states) == 0:
                    log.note(SegmentKind.PLACE, Check.REACH, "place out of reach")
                    continue
                free = checker.free(states)
                if not free.any():
                    Stage(SegmentKind.PLACE, checker, log).blame(states[0])
                tried += [(place, target, q) for q in states[free][:2]]
            if held:
                yield from (End(place, q[None], q[None]) for place, _, q in tried)
            elif tried:
                yield from self._free_ends(grasp, tried, (drop, retreat), checker, log)

    def _free_ends(
        self,
        grasp: Grasp,
        tried: Sequence[tuple[Placement, FloatArray, FloatArray]],
        ways: tuple[float, float],
        carrying: Checker,
        log: FailureLog,
    ) -> Iterator[End]:
        """Of places with tool poses and states there those with straight ways in and out."""
        states, to_base = np.array([q for _, _, q in tried]), self.world_to_base
        above, back = np.array([to_base @ target for _, target, _ in tried]), np.eye(4)
        moves = [self._moves_out(place, ways[0]) for place, _, _ in tried]
        above[:, :3, 3] += [to_base[:3, :3] @ first for first, *_ in moves]
        back[2, 3] = -ways[1]
        out = np.array([to_base @ target @ back for _, target, _ in tried])
        raised = straight_lines(self.arm, states, above, grasp.tool)
        for k, ((_, target, _), (_, *then)) in enumerate(zip(tried, moves, strict=True)):
            raised[k] = self._continue(raised[k], grasp, *(_translate(target, move) for move in then))
        drawn = straight_lines(self.arm, states, out, grasp.tool)
        found: list[Placement] = []
        for (place, _, q), rising, leaving in zip(tried, raised, drawn, strict=True):
            if any(place is other for other in found):
                continue
            lower = Stage(SegmentKind.PLACE, carrying, log)
            left = self.checker(SegmentKind.RETREAT, grasp, place, placed=False)
            retreat = Stage(SegmentKind.RETREAT, left, log)
            lowered = lower.straight(rising, q, backwards=True) and self.bears(lower, grasp)
            if lowered and retreat.straight(leaving, q):
                found.append(place)
                yield End(place, lower.way, retreat.way)


def _translate(pose: FloatArray, move: FloatArray) -> FloatArray:
    """A pose (4, 4) that is elsewhere by (3,) [m]."""
    shifted = pose.copy()
    shifted[:3, 3] += move
    return shifted
