"""What speaks against grasps, whoever proposes them: the one check of rankings and of plans."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from topple.planner.grasp.fingers import coming_unseen, standing_in
from topple.planner.grasp.grasp import Grasp
from topple.planner.grasp.hand import HandShape
from topple.planner.grasp.load import BY_CUP, BY_PADS, beyond_arm, beyond_hand
from topple.planner.grasp.pads import Between, antipodality, between, extents
from topple.planner.grasp.pinch import SLIDES
from topple.planner.grasp.room import Room
from topple.planner.grasp.surface import Surface
from topple.planner.grasp.tolerances import FEW, GRASP_TOLERANCES, PAST_PADS, ROUGH, STRONGEST, WIDEST
from topple.robots.arm.gripper import ToolName
from topple.topology.base.arrays import BoolArray, FloatArray
from topple.topology.bodies.matter import MATTER
from topple.topology.geometry.hull import Hull

WHERE: dict[str, str] = {ToolName.FINGERS: "between its pads", ToolName.SUCTION: "under its cup"}


@dataclass(frozen=True, eq=False)
class Judged:
    """A grasp as a hand would make it, and what speaks against that.

    Attributes:
        grasp: With the width that its object measures between the pads, an opening, and whether it is unseen.
        refused: Why it cannot be used, in words; empty where it can.
        met: Objects that the open hand meets on its way in.
    """

    grasp: Grasp
    refused: tuple[str, ...] = ()
    met: tuple[str, ...] = ()


def judged(grasps: Sequence[Grasp], room: Room) -> list[Judged]:
    """Judge grasps as a search of our own judges those that it finds.

    Args:
        grasps: In the world; those of no object are as they are.
        room: The scene.

    Returns:
        Each of them: refused where the hand meets anything on its straight way in or goes below the ground,
        where nothing of the object is between the pads or more than they open for, where a finger would stand
        in what it fills, where it is known to weigh more than hand or arm hold, and where none of these
        holds, where the pads would slide off.
    """
    found = [Judged(grasp) for grasp in grasps]
    rows = [row for row, grasp in enumerate(grasps) if grasp.object]
    some = [_measured(grasps[row], room) for row in rows]
    taken = [grasp for grasp, _, _ in some]
    met = in_the_way(taken, room)
    deep = _in_solids(taken, room)
    weights = {asked: _too_heavy(*asked, room) for asked in {(grasp.object, grasp.tool) for grasp in taken}}
    for row, (grasp, words, hold), (names, ways), inside in zip(rows, some, met, deep, strict=True):
        stands = [f"a finger would stand in what {grasp.object} fills"] * bool(inside)
        refused = [*weights[grasp.object, grasp.tool], *words, *ways, *stands]
        if not refused and hold is not None and not _holds(grasp, hold, room):
            refused = [SLIDES]
        found[row] = Judged(grasp, tuple(refused), names)
    left = [row for row in rows if not found[row].refused]
    unseen = coming_unseen([found[row].grasp for row in left], room.situation, room.hand, room.cup)
    for row, hidden in zip(left, unseen.tolist(), strict=True):
        found[row] = replace(found[row], grasp=replace(found[row].grasp, unseen=hidden))
    return found


@dataclass(frozen=True, eq=False)
class _Pinched:
    """What of an object is between the pads of one hand.

    Attributes:
        held: Its points within the pads' width.
        window: (1, S) which of them the open pads have between them.
        width: Its extent there [m].
        through: How far it goes on to both sides without a gap that a finger could enter [m].
    """

    held: Between
    window: BoolArray
    width: float
    through: float


def _measured(grasp: Grasp, room: Room) -> tuple[Grasp, list[str], _Pinched | None]:
    """A grasp with the width and opening it takes, what its width has against it, and what the pads hold."""
    name, least = grasp.object, 2.0 * GRASP_TOLERANCES.least_side_clearance
    if grasp.tool == ToolName.SUCTION:
        under = room.under_cup(grasp.pose_tool_to_world[None])[0, room.scene.movable.index(name)]
        nothing = under <= GRASP_TOLERANCES.stray_points
        opened = replace(grasp, opening=grasp.opening or room.cup.opening)
        return opened, [f"nothing of {name} is under its cup"] * bool(nothing), None
    widest = room.hand.max_opening
    opening = min(grasp.opening, widest) or widest
    found = _pinched(grasp.pose_tool_to_world, opening, room.surface(name), room.hulls(name), room.hand)
    if found is None:
        return replace(grasp, opening=opening), [f"nothing of {name} is between its pads"], None
    width, wide = found.width, list[str]()
    if found.through > widest:
        wide = [
            f"{name} is {1e3 * found.through:.0f} mm wide between the pads, which open {1e3 * widest:.0f} mm"
        ]
    opening = min(max(opening, width + least), widest)
    return replace(grasp, width=width, opening=opening), wide, found


def _pinched(
    pose: FloatArray, opening: float, surface: Surface, solid: Sequence[Hull], hand: HandShape
) -> _Pinched | None:
    """What is between the open pads of a hand at a pose (4, 4); None where nothing is.

    Seen and guessed sides tell, and what is between them: of a block that hides its far side, all of it is.
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
                return _Pinched(held, window, float(np.ptp(ends)), float(high[0] - low[0]))
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


def _holds(grasp: Grasp, found: _Pinched, room: Room) -> bool:
    """Whether the pads hold at all: by friction as it is given, or as no surface has more of it."""
    friction = room.scene.friction.get(grasp.object, STRONGEST)
    opening, tolerances = np.array([grasp.opening]), replace(GRASP_TOLERANCES, friction=friction)
    y = found.held.points[found.window][:, 1]
    low, high = y.min(keepdims=True), y.max(keepdims=True)
    held = antipodality(found.held, found.window, low, high, opening, room.hand, tolerances, lenient=True)
    return bool(held[0] > 0.0)


def _too_heavy(name: str, tool: str, room: Room) -> list[str]:
    """What an object's weight, where that is known, has against one tool and the arm."""
    mass, friction = room.scene.masses.get(name), room.scene.friction.get(name)
    if mass is None:
        return []
    if tool == ToolName.FINGERS:
        by_hand = beyond_hand(mass, friction, room.hand.force, BY_PADS)
    else:
        by_hand = beyond_hand(mass, 1.0, room.cup.max_force / 2.0, BY_CUP)
    by_arm = "" if room.arm is None else beyond_arm(mass, room.arm)
    return [words for words in (by_hand, by_arm) if words]


def _in_solids(grasps: Sequence[Grasp], room: Room) -> BoolArray:
    """(G,) whose fingers would stand in what their own object fills."""
    found = np.zeros(len(grasps), dtype=np.bool_)
    for name in dict.fromkeys(grasp.object for grasp in grasps):
        rows = [
            row for row, each in enumerate(grasps) if each.object == name and each.tool == ToolName.FINGERS
        ]
        some = [grasps[row] for row in rows]
        found[rows] = standing_in(some, room.hand, room.hulls(name)) if rows else False
    return found


def in_the_way(grasps: Sequence[Grasp], room: Room) -> list[tuple[tuple[str, ...], list[str]]]:
    """Say what the open hand meets on its straight way in.

    Args:
        grasps: In the world, each with its object.
        room: The scene.

    Returns:
        For each grasp what it meets, and what speaks against it, in words; nothing where it has room.
    """
    found: list[tuple[tuple[str, ...], list[str]]] = [((), []) for _ in grasps]
    names = [*room.scene.clouds, MATTER]
    for tool in (ToolName.FINGERS, ToolName.SUCTION):
        rows = [row for row, grasp in enumerate(grasps) if grasp.tool == tool]
        if not rows:
            continue
        poses, own = poses_of(grasps[row] for row in rows), [grasps[row].object for row in rows]
        if tool == ToolName.FINGERS:
            met = room.met_by_fingers(poses, np.array([grasps[row].opening for row in rows]))
            low = room.below_ground(poses, own)
        else:
            met, low = room.met_by_cup(poses, own), np.zeros(len(rows), dtype=np.bool_)
        for row, hits, under in zip(rows, met, low, strict=True):
            hit = tuple(names[place] for place in np.flatnonzero(hits))
            words = [f"the hand meets {', '.join(hit)}"] if hit else []
            found[row] = hit, words + ["the fingers would go below the ground"] * bool(under)
    return found


def poses_of(grasps: Iterable[Grasp]) -> FloatArray:
    """(P, 4, 4) pose_tool_to_world of grasps."""
    return np.array([grasp.pose_tool_to_world for grasp in grasps]).reshape(-1, 4, 4)
