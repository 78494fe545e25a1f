"""A plan followed action by action: where everything is and what is in the hand is what the arm makes of it.

Nothing is believed of what a plan declares. An object moves because the hand closed on it or the cup sealed,
and went somewhere; it stays where the hand let go of it. What the plan says of the same is held against that.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from typing import Any, NamedTuple, TypeVar, cast

import numpy as np

from topple.planner.formats.plan_structs import PlanData, Step
from topple.planner.placement.away import IN_HAND, Away
from topple.planner.transfer.segments import Segment, SegmentKind
from topple.planner.verify.grip import Grip
from topple.planner.verify.tolerances import OPENED
from topple.robots.arm.arm import Arm
from topple.robots.arm.gripper import ToolState
from topple.robots.poses import angle_between, inverse
from topple.topology.base.arrays import FloatArray
from topple.topology.bodies.solids import move_parts
from topple.topology.scene.scene import Scene
from topple.topology.situation.situation import Situation

Made = TypeVar("Made")


class NoScene(Exception):
    """A check asks for a scene that was not given."""


class Finding(NamedTuple):
    """One thing that was measured: its value, where, and the index of the step it is of, if it is of one."""

    value: float
    where: str
    step: int | None = None


@dataclass(frozen=True, eq=False)
class Piece:
    """One segment as it is played.

    Attributes:
        index: Of the step.
        step: The step.
        segment: The segment.
        start: (n,) joint values before it.
        states: (m, n) joint values, densely along the motion; one state for grasp and release.
        poses: Rigid transforms (4, 4) since the plan began of the objects that are not in the hand.
        held: What is in the hand: transforms (4, 4) from the world at the plan's begin to the tool.
        before: Transforms (4, 4) since the plan began of all objects, as the step began; what was handed on
            or went into a box by then is left out.
    """

    index: int
    step: Step
    segment: Segment
    start: FloatArray
    states: FloatArray
    poses: dict[str, FloatArray]
    held: dict[str, FloatArray]
    before: dict[str, FloatArray]

    @property
    def where(self) -> str:
        """Step and segment, in words."""
        return f"step {self.index + 1} ({self.step.object}), {self.segment.kind}"

    @property
    def at_rest(self) -> int:
        """The state in which what is held lies where it lay or is to lie: the last of a way down."""
        return -1 if self.segment.kind == SegmentKind.PLACE else 0

    @property
    def hand(self) -> ToolState:
        """How the hand stands."""
        return self.segment.hand

    @property
    def may_touch(self) -> frozenset[frozenset[str]]:
        """Pairs of names that are meant to touch."""
        return frozenset(frozenset(pair) for pair in self.segment.may_touch)

    def finds(self, value: float, words: str = "") -> Finding:
        """Something that was measured here."""
        return Finding(value, f"{self.where}: {words}" if words else self.where, self.index)


class Replay:
    """A plan as the arm carries it out, and what its hand disagrees in with what the plan declares.

    Args:
        plan: The plan.
        arm: The arm.
        spacing: Largest change of a joint between two states [rad].
        situation: What was seen, where that is given.

    Attributes:
        parts: Convex parts (V, 3) of every object, where it was when the plan began [m].
        wholes: The same with the hidden sides [m].
        poses: Transforms (4, 4) of the objects since the plan began, in the end.
        pieces: Every segment, in order.
        taken: Objects that were taken and let go again, with the indices of the steps, in order.
        empty: Grasps that hold nothing.
        unmoved: Steps that do not move their object.
        kept: What is in the hand when a step ends.
        closed: What stays in the hand as it is let go.
        changed: How far the hand moves while it holds [m].
        misplaced: How far things are let go from their places [m].
        beside: What is put into a thing that it is not over.
    """

    def __init__(self, plan: PlanData, arm: Arm, spacing: float, situation: Situation | None = None) -> None:
        self.plan, self.arm, self.spacing, self._situation = plan, arm, spacing, situation
        self.up, self.base = np.array(plan.up), np.array(plan.pose_base_to_world)
        self.parts = {thing.name: [np.array(part) for part in thing.parts] for thing in plan.objects}
        self.wholes = {
            thing.name: [np.array(part) for part in thing.whole or thing.parts] for thing in plan.objects
        }
        self.fixed = {thing.name for thing in plan.objects if thing.fixed}
        self.poses = {name: np.eye(4) for name in self.parts}
        self.taken: list[tuple[int, str]] = []
        found = cast(list[list[Finding]], [[] for _ in range(7)])
        self.empty, self.unmoved, self.kept, self.closed, self.changed, self.misplaced, self.beside = found
        self._grip, self._made = Grip(self.parts, self.wholes, arm, self.up), dict[Any, Any]()
        self._held, self._gone = dict[str, FloatArray](), set[str]()
        self._tool, self._hand = "", ToolState()
        self.pieces = tuple(self._follow())

    @property
    def situation(self) -> Situation:
        """The situation as seen.

        Raises:
            NoScene: It is not given.
        """
        if self._situation is None:
            raise NoScene("no scene was given")
        return self._situation

    @property
    def scene(self) -> Scene:
        """The scene of the situation, likewise."""
        return self.situation.scene

    def weighing_scene(self) -> Scene | None:
        """The scene for what was weighed and tried in it; None where none is given: everything is guessed."""
        return None if self._situation is None else self._situation.scene

    def once(self, make: "Callable[[Replay], Made]") -> Made:
        """Make data that several checks ask of a replay when the first of them does."""
        if make not in self._made:
            self._made[make] = make(self)
        return self._made[make]

    def of_kind(self, *kinds: SegmentKind) -> Iterator[Piece]:
        """The pieces of some kinds, in order."""
        return (piece for piece in self.pieces if piece.segment.kind in kinds)

    def last(self) -> Iterator[Piece]:
        """The last piece of every step that has one, in order."""
        return (piece for piece in self.pieces if piece.segment is piece.step.segments[-1])

    def tools(self, piece: Piece, states: FloatArray) -> FloatArray:
        """Poses (m, 4, 4) of a piece's tool in the world, in states (m, n)."""
        return np.matmul(self.base, self.arm.tool_pose(states, piece.segment.tool))

    def pads(self, piece: Piece) -> FloatArray:
        """(4, 4) pose of the pads at the grasp's width, or of the lip, in the tool's frame."""
        return self.arm.tool(piece.segment.tool).pads(piece.step.grasp.width)

    def body(self, piece: Piece, name: str) -> tuple[FloatArray, ...]:
        """Convex parts (V, 3) of an object where it is as a piece ends, in the hand or not."""
        held = name in piece.held
        tool = self.tools(piece, piece.states[-1:])[0] if held else np.eye(4)
        return move_parts(self.parts[name], tool @ (piece.held if held else piece.poses)[name])

    def _follow(self) -> Iterator[Piece]:
        q = np.array(self.plan.q_start)
        for index, step in enumerate(self.plan.steps):
            before = {name: pose for name, pose in self.poses.items() if name not in self._gone}
            count, where = len(self.taken), f"step {index + 1} ({step.object})"
            for segment in step.segments:
                piece = Piece(index, step, segment, q, resample(segment, q, self.spacing), {}, {}, before)
                q = piece.states[-1]
                if segment.kind == SegmentKind.GRASP:
                    self._take(piece)
                elif segment.kind == SegmentKind.RELEASE:
                    self._let_go(piece)
                elif self._held:
                    opened = abs(piece.hand.opening - self._hand.opening)
                    slid = abs(piece.hand.cup_extension - self._hand.cup_extension)
                    self.changed.append(piece.finds(max(opened, slid)))
                self._hand = piece.hand
                away = self._gone.union(self._held)
                rest = {name: pose for name, pose in self.poses.items() if name not in away}
                yield replace(piece, poses=rest, held=dict(self._held))
                if (
                    segment is step.segments[-1]
                    and step.placement.how in IN_HAND
                    and step.object in self._held
                ):
                    self._leave(piece, np.zeros(3))
            if step.placement.how == Away.BIN or step.placement.how in IN_HAND:
                self._gone.update(name for _, name in self.taken[count:])
            self.kept += [Finding(1.0, f"{where}: {name}", index) for name in self._held]
            if not any(name == step.object for _, name in self.taken[count:]):
                self.unmoved.append(Finding(1.0, f"{where}: it is never taken and let go", index))

    def _take(self, piece: Piece) -> None:
        """Close the hand: what is then in it moves with it."""
        step, tool = piece.step, self.tools(piece, piece.states[-1:])[0]
        words = "something is in it already" if self._held else None
        words = f"{step.object} is gone by then" if step.object in self._gone else words
        pads = tool @ self.pads(piece)
        words = words or self._grip.fails(step, piece.segment.tool, self._hand, piece.hand, pads, self.poses)
        if words is not None:
            self.empty.append(piece.finds(1.0, words))
            return
        self._tool = piece.segment.tool
        for name in (step.object, *(held.object for held in step.attachments if held.object != step.object)):
            if name == step.object or self._grip.rides(name, step.object, self.poses):
                self._held[name] = inverse(tool) @ self.poses[name]
            else:
                self.empty.append(piece.finds(1.0, f"{name} does not lie in {step.object}"))

    def _let_go(self, piece: Piece) -> None:
        """Open the hand: what was in it lies there, or falls as far as its step says."""
        if not self._held:
            return
        closes = bool(self.arm.tools[self._tool].gripper.limits.opening)
        if closes and piece.hand.opening <= self._hand.opening + OPENED:
            self.closed.append(piece.finds(1.0, "the pads stay closed"))
            return
        place, name = piece.step.placement, piece.step.object
        self._leave(piece, place.drop * self.up)
        if place.into is not None and not self._grip.rides(name, place.into, self.poses):
            self.beside.append(piece.finds(1.0, f"it is not over {place.into}"))

    def _leave(self, piece: Piece, fall: FloatArray) -> None:
        """Leave the held objects where they are, but for a fall (3,) [m]; a step says where."""
        tool = self.base @ self.arm.tool_pose(piece.states[-1], self._tool)[0]
        declared = np.array(piece.step.placement.pose_before_to_after)
        for name, to_tool in self._held.items():
            self.poses[name] = tool @ to_tool
            if name in piece.before:
                self.misplaced.append(
                    piece.finds(off_by(self.poses[name], declared @ piece.before[name]), name)
                )
            self.poses[name][:3, 3] -= fall
            self.taken.append((piece.index, name))
        self._held = {}


def off_by(a: FloatArray, b: FloatArray) -> float:
    """How far two poses (4, 4) are apart: metres, or a tenth of the angle [rad] where that is more."""
    return max(float(np.linalg.norm(a[:3, 3] - b[:3, 3])), angle_between(a, b) / 10.0)


def resample(segment: Segment, q: FloatArray, spacing: float) -> FloatArray:
    """States (m, n) along a segment's motion, `spacing` [rad] apart in the joint that moves most.

    Args:
        segment: The segment; without a motion the arm stays at q.
        q: (n,) where the arm is before it.
        spacing: Between states.
    """
    if segment.motion is None:
        return q[None]
    rows = segment.motion.positions
    if len(rows) < 2:
        return rows
    way = np.concatenate([[0.0], np.cumsum(np.abs(np.diff(rows, axis=0)).max(axis=1))])
    count = max(int(np.ceil(way[-1] / spacing)), 1)
    at = np.linspace(0.0, way[-1], count + 1)
    return np.stack([np.interp(at, way, column) for column in rows.T], axis=1)
