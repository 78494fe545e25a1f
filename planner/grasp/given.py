"""Grasps of the caller's own for a plan or a run: whose they are, and which can be done now."""

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from topple.planner.grasp.candidates import varied
from topple.planner.grasp.grasp import Grasp
from topple.planner.grasp.hand import HandShape
from topple.planner.grasp.rank import RankedGrasp, in_the_way
from topple.planner.grasp.reach import reachable
from topple.planner.grasp.room import Room
from topple.planner.grasp.tolerances import GRASP_TOLERANCES, MOST_GIVEN, OUTER, PAST_PADS
from topple.robots.arm.arm import Arm
from topple.robots.arm.gripper import ToolName
from topple.topology.arrays import FloatArray
from topple.topology.bodies.solids import up_of
from topple.topology.errors import InvalidInput, UnknownObject
from topple.topology.scene import Scene

OwnGrasps = Sequence[Grasp | RankedGrasp] | Mapping[str, Sequence[Grasp | RankedGrasp]]
"""Grasps with their objects, as `rank_grasps` gives them or one's own, or those of each object."""

GraspsByObject = Mapping[str, Sequence[Grasp]]


def own_grasps(grasps: OwnGrasps, scene: Scene, arm: Arm) -> dict[str, list[Grasp]]:
    """Sort the caller's grasps by object.

    Args:
        grasps: In the scene's frame; those of `rank_grasps` that hold nothing are left out.
        scene: What is seen.
        arm: The arm that is to make them.

    Returns:
        The grasps of each object that has any, or for which an empty list was given.

    Raises:
        UnknownObject: One is of an object that is not in the scene, or cannot move.
        InvalidInput: One names no object or another one, or the arm has no tool for it.
    """
    found: dict[str, list[Grasp]] = {}
    if isinstance(grasps, Mapping):
        for name, some in grasps.items():
            found[_known(name, scene)] = [_checked(entry, name, arm) for entry in some]
        return found
    for index, entry in enumerate(grasps):
        name = _plain(entry).object
        if not name and not isinstance(entry, RankedGrasp):
            raise InvalidInput(f"grasp {index} names no object: rank_grasps says what it holds")
        if name:
            found.setdefault(_known(name, scene), []).append(_checked(entry, name, arm))
    return found


def doable(grasps: Sequence[Grasp], scene: Scene, arm: Arm, pose_base_to_world: FloatArray) -> list[Grasp]:
    """Of one object's grasps those to try now.

    A width of 0 is measured in the object's cloud, an opening of 0 is as wide as the hand opens.

    Args:
        grasps: In the world.
        scene: What is there now.
        arm: The arm.
        pose_base_to_world: (4, 4) where it stands.

    Returns:
        Those that have room and are within reach, those with the highest scores first and no near copies; the
        others only where there are none, for the plan to say what they fail of.
    """
    if not grasps:
        return []
    room = Room.of(scene, up_of(scene), arm)
    met = in_the_way(grasps, room)
    roomy = [grasp for grasp, words in zip(grasps, met, strict=True) if not words]
    reached = reachable(roomy, arm, pose_base_to_world)
    best = [grasp for grasp, yes in zip(roomy, reached, strict=True) if yes]
    return [_complete(grasp, room) for grasp in varied(best or roomy or list(grasps), MOST_GIVEN)]


def _plain(entry: Grasp | RankedGrasp) -> Grasp:
    return entry.grasp if isinstance(entry, RankedGrasp) else entry


def _known(name: str, scene: Scene) -> str:
    if name not in scene.movable:
        raise UnknownObject(name, scene.movable, role="object to grasp")
    return name


def _checked(entry: Grasp | RankedGrasp, name: str, arm: Arm) -> Grasp:
    grasp = _plain(entry)
    if grasp.object not in ("", name):
        raise InvalidInput(f"a grasp of {grasp.object!r} is given for {name!r}")
    if grasp.tool not in arm.tools:
        raise InvalidInput(f"{arm.name} has no {grasp.tool}: it has {', '.join(arm.tools)}")
    return grasp if grasp.object else replace(grasp, object=name)


def _complete(grasp: Grasp, room: Room) -> Grasp:
    """A grasp that says how wide its object is between the pads and how wide they open."""
    if grasp.tool == ToolName.SUCTION:
        return grasp if grasp.opening > 0.0 else replace(grasp, opening=room.cup.opening)
    widest = room.hand.max_opening
    width = grasp.width if grasp.width > 0.0 else _width(grasp, room.scene.clouds[grasp.object], room.hand)
    least = width + 2.0 * GRASP_TOLERANCES.least_side_clearance
    opening = max(grasp.opening, least) if grasp.opening > 0.0 else widest
    return replace(grasp, width=min(width, widest), opening=min(opening, widest))


def _width(grasp: Grasp, cloud: FloatArray, hand: HandShape) -> float:
    """Extent of an object between the pads [m], 0 where nothing of it is there."""
    pose = grasp.pose_tool_to_world
    local = (cloud - pose[:3, 3]) @ pose[:3, :3]
    half = np.array([hand.pad_width, hand.max_opening, hand.pad_length + 2.0 * PAST_PADS]) / 2.0
    between = local[(np.abs(local) < half).all(axis=1), 1]
    low, high = np.quantile(between, [OUTER, 1.0 - OUTER]) if len(between) else (0.0, 0.0)
    return float(high - low)
