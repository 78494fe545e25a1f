"""Grasps of the caller's own for a plan or a run: whose they are, and which can be done now."""

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import replace

from topple.planner.grasp.candidates import pick_varied
from topple.planner.grasp.grasp import Grasp
from topple.planner.grasp.judge import judge_grasps, reachable
from topple.planner.grasp.rank import RankedGrasp
from topple.planner.grasp.room import Room
from topple.planner.grasp.surroundings import Dropped
from topple.planner.grasp.tolerances import MOST_GIVEN
from topple.robots.arm.arm import Arm
from topple.topology.base.arrays import FloatArray
from topple.topology.base.errors import InvalidInput, UnknownObject
from topple.topology.scene.scene import Scene
from topple.topology.situation.situation import Situation

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
            found[_known_name(name, scene)] = [_check_entry(entry, name, arm) for entry in some]
        return found
    for index, entry in enumerate(grasps):
        name = _plain(entry).object
        if not name and not isinstance(entry, RankedGrasp):
            raise InvalidInput(f"grasp {index} names no object: rank_grasps says what it holds")
        if name:
            found.setdefault(_known_name(name, scene), []).append(_check_entry(entry, name, arm))
    return found


def doable(
    grasps: Sequence[Grasp], situation: Situation, arm: Arm, pose_base_to_world: FloatArray
) -> tuple[list[Grasp], Dropped]:
    """Of one object's grasps those to try now.

    Args:
        grasps: In the world.
        situation: What is there now.
        arm: The arm.
        pose_base_to_world: (4, 4) where it stands.

    Returns:
        Those that `rank_grasps` would not refuse, with width and opening, that are within reach, or all where
        none is, for the plan to say so: seen ones first, then by score, no near copies. And why the others
        are refused, with counts.
    """
    dropped, left = Dropped(), list[Grasp]()
    counts: Counter[str] = Counter()
    for entry in judge_grasps(grasps, Room.of(situation, arm)) if grasps else ():
        if not entry.refused:
            left.append(entry.grasp)
        counts.update(entry.refused)
        dropped.barring.update(other for other in entry.met if other != entry.grasp.object)
    for words, count in counts.items():
        dropped.note(f"{words} ({count} of {len(grasps)} grasps given)", count)
    reached = reachable(left, arm, pose_base_to_world)
    best = [grasp for grasp, yes in zip(left, reached, strict=True) if yes]
    return pick_varied(best or left, MOST_GIVEN), dropped


def _plain(entry: Grasp | RankedGrasp) -> Grasp:
    return entry.grasp if isinstance(entry, RankedGrasp) else entry


def _known_name(name: str, scene: Scene) -> str:
    if name not in scene.movable:
        raise UnknownObject(name, scene.movable, role="object to grasp")
    return name


def _check_entry(entry: Grasp | RankedGrasp, name: str, arm: Arm) -> Grasp:
    grasp = _plain(entry)
    if grasp.object not in ("", name):
        raise InvalidInput(f"a grasp of {grasp.object!r} is given for {name!r}")
    if grasp.tool not in arm.tools:
        raise InvalidInput(f"{arm.name} has no {grasp.tool}: it has {', '.join(arm.tools)}")
    return grasp if grasp.object else replace(grasp, object=name)
