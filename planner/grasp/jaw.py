"""Fingers in a search for grasps: what they find, how they stand, what they hold and where they are."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import product
from typing import TYPE_CHECKING, ClassVar

import numpy as np

from topple.planner.grasp.cells import Region, swept
from topple.planner.grasp.frames import frames
from topple.planner.grasp.grasp import PINCH, Grasp
from topple.planner.grasp.hand import HandShape
from topple.planner.grasp.load import jaw_load
from topple.planner.grasp.pads import Between, antipodality, between, extents
from topple.planner.grasp.pinch import SLIDES, pinches, score_of
from topple.planner.grasp.rims import rim_frames
from topple.planner.grasp.shape import Sought, hand_bodies, in_world
from topple.planner.grasp.surface import Surface
from topple.planner.grasp.tolerances import (
    FEW,
    GRASP_TOLERANCES,
    OPENING_STEP,
    PAST_PADS,
    RELEASE_GAP,
    ROUGH,
    SHARES_ASKED,
    STRONGEST,
    UPRIGHT,
    WIDEST,
)
from topple.planner.grasp.widen import widen_pinches
from topple.robots.arm.gripper import FINGERS, ToolState
from topple.robots.arm.jaw import ParallelJaw
from topple.robots.collision.prisms import fill_prisms
from topple.topology.base.arrays import BoolArray, FloatArray
from topple.topology.base.errors import InvalidInput
from topple.topology.geometry.hull import Hull

if TYPE_CHECKING:
    from topple.planner.grasp.room import Room
    from topple.robots.arm.arm import Arm


@dataclass(frozen=True, eq=False)
class Jaw(HandShape):
    """Fingers, parallel or hinged."""

    kind: ClassVar[str] = PINCH
    where: ClassVar[str] = "between its pads"
    holder: ClassVar[str] = "the pads hold"
    spare: ClassVar[bool] = True

    # -- what it finds, and what that holds

    def grasps(self, sought: Sought) -> list[Grasp]:
        """Pinch across narrow sides at points all over the object, straight down and tilted, and at rims."""
        found = self._pinches(sought)
        pierced = self.stand_in(found, sought.solid)
        clear = [grasp for grasp, bad in zip(found, pierced, strict=True) if not bad]
        sought.dropped.note("fingers would stand in what it fills", len(found) - len(clear))
        return clear

    def _pinches(self, sought: Sought) -> list[Grasp]:
        surface, tolerances = sought.surface, sought.tolerances
        found, roomy = list[Grasp](), 0
        for tilts in (tolerances.tilts, tolerances.steep_tilts):
            if len(found) >= tolerances.enough:
                break
            for directions in frames(surface, sought.out, tilts):
                some = pinches(directions, sought, self)
                found += some
                roomy += sum(grasp.terms["clearance"] == 1.0 for grasp in some)
                if roomy >= sought.enough:
                    return found
        if len(found) < tolerances.enough:
            for directions in rim_frames(sought, self):
                found += pinches(directions, sought, self)
        return found

    def score(self, terms: Mapping[str, float]) -> float:
        """Multiply the terms: one that is nil spoils the grasp alone."""
        return score_of(terms)

    def max_weight(self, friction: float | None) -> float:
        """Weight [N] that two pads lift at most."""
        return 2.0 * (STRONGEST if friction is None else friction) * self.force

    def load(
        self, weight: float, centre: FloatArray, down: FloatArray, width: float, own: FloatArray
    ) -> float:
        """How much of what the pads hold a weight takes; see `jaw_load`."""
        depth = np.array([max(self.tip - float(own[:, 2].min()), 0.0)])
        wide, friction = np.array([width]), GRASP_TOLERANCES.friction
        return float(jaw_load(centre[None], down[None], weight, wide, depth, self, friction)[0])

    def widened(self, grasps: Sequence[Grasp], sought: Sought) -> list[Grasp]:
        """Pinches with the fingers as far apart as there is room."""
        return widen_pinches(grasps, sought, self)

    def turns(self, grasp: Grasp) -> list[Grasp]:
        """A jaw turned half is the same."""
        return [grasp, grasp.turn()]

    # -- how it stands

    def ready(self, grasp: Grasp) -> ToolState:
        """On the way in."""
        return ToolState(self._round_opening(grasp.opening))

    def closed(self, grasp: Grasp) -> ToolState:
        """With the object."""
        return ToolState(grasp.width)

    def released(self, grasp: Grasp, into: str | None, up: FloatArray) -> ToolState:
        """After letting go: wide open, so that the object stays where it is when the hand leaves.

        In a vessel only as far as it takes: fingers would push aside what else is in it. A level hand, whose
        lower finger is below the object, opens wide everywhere, or it would draw the object along.
        """
        below = grasp.kind == PINCH and abs(float(grasp.closing_axis @ up)) > UPRIGHT
        if into is not None and not below:
            return ToolState(self._round_opening(grasp.width + RELEASE_GAP))
        return self.hand

    def _round_opening(self, opening: float) -> float:
        return min(self.max_opening, step_up(opening))

    # -- where it is

    def filled(self, grasps: Sequence[Grasp], length: float, layers: int) -> FloatArray:
        """Points (G, N, 3) in both open fingers, some metres back from their fronts, in the tool frames."""
        half = np.array([grasp.opening / 2.0 for grasp in grasps])[:, None, None] * np.array([0.0, 1.0, 0.0])
        right = fill_prisms(self.finger, length, layers) + half
        return np.concatenate([right, right * np.array([1.0, -1.0, 1.0])], axis=1)

    def stand_in(self, grasps: Sequence[Grasp], solid: Sequence[Hull]) -> BoolArray:
        """(G,) whose open fingers would stand in what their object fills: its cloud may have a hole there."""
        found = np.zeros(len(grasps), dtype=np.bool_)
        if not grasps:
            return found
        points = in_world(grasps, self.filled(grasps, self.pad_length, 3)).swapaxes(0, 1)
        for layer, hull in product(range(SHARES_ASKED), solid):
            rows = np.flatnonzero(~found)  # most of those that stand in it do so with the first points asked
            asked = points[layer::SHARES_ASKED, rows]
            inside = np.logical_and.reduce(
                [
                    (asked[..., axis] > hull.lower[axis]) & (asked[..., axis] < hull.upper[axis])
                    for axis in range(3)
                ]
            )
            deep = (asked[inside] @ hull.normals.T + hull.offsets).max(axis=1, initial=-np.inf)
            found[rows[np.nonzero(inside)[1][deep < -GRASP_TOLERANCES.into_solid]]] = True
        return found

    def holds(self, count: int) -> Region:
        """Between the open pads."""
        half = [self.pad_width, self.max_opening, self.pad_length + 2.0 * PAST_PADS]
        bound = np.tile(np.array(half) / 2.0, (count, 1))
        return Region(-bound, bound)

    def sweeps(self, openings: FloatArray) -> tuple[list[Region], list[Region]]:
        """Regions that open hands (P,) sweep on their way in, as far as they open where 0."""
        opening = np.where(openings > 0.0, np.minimum(self.max_opening, openings), self.max_opening)
        return [swept(len(opening), *bounds) for bounds in self.footprints(opening)], []

    def below(self, poses: FloatArray, up: FloatArray, floors: FloatArray) -> BoolArray:
        """Whether finger tips at poses (P, 4, 4) would be below the ground, its height (P,) [m]."""
        return np.asarray((poses[:, :3, 3] + self.tip * poses[:, :3, 2]) @ up < floors)

    def measured(self, grasp: Grasp, room: "Room") -> tuple[Grasp, list[str], Callable[[], str]]:
        """A grasp with the width and opening it takes, what is against these, and whether pads slide off."""
        name, widest = grasp.object, self.max_opening
        opening = min(grasp.opening, widest) or widest
        found = _between_pads(grasp.pose_tool_to_world, opening, room.surface(name), room.hulls(name), self)
        if found is None:
            return replace(grasp, opening=opening), [f"nothing of {name} is {self.where}"], str
        (width, through, holds), wide = found, list[str]()
        if through > widest:
            wide = [
                f"{name} is {1e3 * through:.0f} mm wide between the pads, which open {1e3 * widest:.0f} mm"
            ]
        opening = min(max(opening, width + 2.0 * GRASP_TOLERANCES.least_side_clearance), widest)
        friction = room.scene.friction.get(name, STRONGEST)  # as given, or as no surface has more of it
        taken = replace(grasp, width=width, opening=opening)
        return taken, wide, lambda: "" if holds(opening, friction) else SLIDES


def _between_pads(
    pose: FloatArray, opening: float, surface: Surface, solid: Sequence[Hull], hand: HandShape
) -> tuple[float, float, Callable[[float, float], bool]] | None:
    """Measure the object between the open pads of a hand at a pose (4, 4); None where nothing is.

    Seen and guessed sides tell, and what is between them: of a block that hides its far side, all of it is.

    Returns:
        Its extent there [m], how far it goes on to both sides without a gap that a finger could enter [m],
        and what tells at an opening [m] and a coefficient of friction whether the pads hold it at all.
    """
    offsets, turn, step = surface.points - pose[:3, 3], pose[:3, :3], GRASP_TOLERANCES.spacing
    beside = np.abs(offsets @ turn[:, 0]) <= hand.pad_width / 2.0
    held = between(offsets, surface.normals, turn[None], beside[None])
    y, z = held.points[:, :, 1], held.points[:, :, 2]
    for past in (0.0, PAST_PADS):  # depth noise and a finger's play count where nothing else is there
        front, back = hand.tip + past, hand.tip - hand.pad_length - past
        ways = [pose[:3, 3] + height * turn[:, 2] for height in (back, (back + front) / 2.0, front)]
        inside = [_through(hull, place, turn[:, 1]) for hull in solid for place in ways]
        filled = [np.arange(low, high, step) for low, high in inside if low < high]
        at = held.there & (z <= front) & (z >= back)
        there = np.sort(np.concatenate([y[at], *filled]))
        closed = there[np.abs(there) <= opening / 2.0]
        if len(closed) > GRASP_TOLERANCES.stray_points:
            low, high = extents(there[None], np.ones((1, len(there)), dtype=np.bool_), GRASP_TOLERANCES)
            ends = closed[[len(closed) // FEW, -1 - len(closed) // FEW]]
            window = at & (y >= ends[0]) & (y <= ends[1])
            if window.any():
                holds = partial(_is_held, held, window, hand)
                return float(np.ptp(ends)), float(high[0] - low[0]), holds
    return None


def _through(hull: Hull, place: FloatArray, way: FloatArray) -> tuple[float, float]:
    """From where to where [m] a line along a way (3,) from a place (3,) is deep in a hull, up to `WIDEST`."""
    along = hull.normals @ way
    ends = -(hull.normals @ place + hull.offsets + GRASP_TOLERANCES.into_solid)
    ins, outs = along < -ROUGH, along > ROUGH
    if (ends[~(ins | outs)] < 0.0).any():
        return 0.0, 0.0
    low = float((ends[ins] / along[ins]).max(initial=-WIDEST))
    return low, float((ends[outs] / along[outs]).min(initial=WIDEST))


def _is_held(held: Between, window: BoolArray, hand: HandShape, opening: float, friction: float) -> bool:
    y = held.points[window][:, 1]
    low, high = y.min(keepdims=True), y.max(keepdims=True)
    tolerances = replace(GRASP_TOLERANCES, friction=friction)
    apart = np.array([opening])
    return bool(antipodality(held, window, low, high, apart, hand, tolerances, lenient=True)[0] > 0.0)


def step_up(opening: float) -> float:
    """An opening [m] rounded up to a step."""
    return float(np.ceil(opening / OPENING_STEP - 1e-9)) * OPENING_STEP


def hand_shape(arm: "Arm") -> Jaw:
    """Measure an arm's hand: the prisms its collision hulls sweep when it comes in along the approach.

    Args:
        arm: An arm with a tool named "fingers".

    Returns:
        The shape.
    """
    tool = arm.tools[FINGERS]
    jaw: ParallelJaw | None = tool.gripper.jaw
    if jaw is None:
        raise InvalidInput(f"robot {arm.name!r}: its tool 'fingers' is no jaw")
    finger, palm, tip = jaw.prisms(
        lambda opening: hand_bodies(arm, tool.name, ToolState(opening)), GRASP_TOLERANCES.side_clearance
    )
    size = jaw.pad_size
    return Jaw(tool, palm, jaw.max_opening, *size, tip, finger, jaw.grip, jaw.give, arm.open_hand)
