"""What speaks against grasps, whoever proposes them: the one check of rankings and of plans."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from topple.planner.grasp.grasp import HALF_TURN, Grasp
from topple.planner.grasp.load import beyond_arm
from topple.planner.grasp.room import Room
from topple.planner.grasp.shape import coming_unseen
from topple.robots.arm.arm import Arm
from topple.robots.poses import inverse
from topple.topology.base.arrays import FloatArray
from topple.topology.bodies.matter import MATTER


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


def judge_grasps(grasps: Sequence[Grasp], room: Room) -> list[Judged]:
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
    some = [room.shape(grasps[row].tool).measured(grasps[row], room) for row in rows]
    taken = [grasp for grasp, _, _ in some]
    met = in_the_way(taken, room)
    deep, heavy = np.zeros(len(taken), dtype=np.bool_), dict[tuple[str, str], list[str]]()
    for asked in dict.fromkeys((grasp.object, grasp.tool) for grasp in taken):
        these = [place for place, grasp in enumerate(taken) if (grasp.object, grasp.tool) == asked]
        name, shape = asked[0], room.shape(asked[1])
        deep[these] = shape.stand_in([taken[place] for place in these], room.hulls(name))
        mass, friction = room.scene.masses.get(name), room.scene.friction.get(name)
        by_arm = beyond_arm(mass, room.arm) if mass is not None and room.arm is not None else ""
        heavy[asked] = [words for words in (shape.too_heavy(mass, friction), by_arm) if words]
    for row, (grasp, words, slides), (names, ways), inside in zip(rows, some, met, deep, strict=True):
        stands = [f"a finger would stand in what {grasp.object} fills"] * bool(inside)
        refused = [*heavy[grasp.object, grasp.tool], *words, *ways, *stands]
        found[row] = Judged(grasp, tuple(refused or filter(None, [slides()])), names)
    left = [row for row in rows if not found[row].refused]
    shapes = {tool: room.shape(tool) for tool in {grasp.tool for grasp in taken}}
    unseen = coming_unseen([found[row].grasp for row in left], room.situation, shapes)
    for row, hidden in zip(left, unseen.tolist(), strict=True):
        found[row] = replace(found[row], grasp=replace(found[row].grasp, unseen=hidden))
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
    for tool in dict.fromkeys(grasp.tool for grasp in grasps):
        rows = [row for row, grasp in enumerate(grasps) if grasp.tool == tool]
        poses, own = poses_of(grasps[row] for row in rows), [grasps[row].object for row in rows]
        met = room.met(tool, poses, np.array([grasps[row].opening for row in rows]), own)
        low = room.below_ground(tool, poses, own)
        for row, hits, under in zip(rows, met, low, strict=True):
            hit = tuple(names[place] for place in np.flatnonzero(hits))
            words = [f"the hand meets {', '.join(hit)}"] if hit else []
            found[row] = hit, words + ["the fingers would go below the ground"] * bool(under)
    return found


def poses_of(grasps: Iterable[Grasp]) -> FloatArray:
    """(P, 4, 4) pose_tool_to_world of grasps."""
    return np.array([grasp.pose_tool_to_world for grasp in grasps]).reshape(-1, 4, 4)


def reachable(grasps: Sequence[Grasp], arm: Arm, pose_base_to_world: FloatArray) -> list[bool]:
    """Ask inverse kinematics about grasps, each with the hand turned half as well.

    Args:
        grasps: In the world.
        arm: The arm.
        pose_base_to_world: (4, 4) where it stands.

    Returns:
        For each grasp whether joint values within the limits take the tool there. What is in the arm's way
        is not asked.
    """
    world_to_base = inverse(np.asarray(pose_base_to_world, dtype=np.float64))
    found = [False] * len(grasps)
    for tool in {grasp.tool for grasp in grasps}:
        places = [place for place, grasp in enumerate(grasps) if grasp.tool == tool]
        poses = world_to_base @ np.array([grasps[place].pose_of(arm.tools[tool]) for place in places])
        both = np.stack([poses, poses @ HALF_TURN], axis=1)
        for place, yes in zip(places, arm.reaches(both, tool).tolist(), strict=True):
            found[place] = yes
    return found
