"""Grasps of any pipeline ranked for clutter: safe order first, then what can be done, then their score."""

import os
from collections.abc import Callable, Iterable, Mapping, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass, replace
from functools import partial
from itertools import zip_longest
from typing import Any

import numpy as np

from topple.planner.decide.dependency import DependencyGraph, dependencies
from topple.planner.grasp.foreign import ForeignGrasps, grasps_from_array, read_grasps
from topple.planner.grasp.grasp import PINCH, Grasp
from topple.planner.grasp.judge import judge_grasps, poses_of, reachable
from topple.planner.grasp.room import Room
from topple.planner.grasp.shape import shapes_of
from topple.planner.grasp.tolerances import GRASP_TOLERANCES, HAND_REACH
from topple.robots.arm.arm import Arm
from topple.robots.catalog import robot as robot_named
from topple.topology.base.arguments import checked_arguments
from topple.topology.base.arrays import FloatArray
from topple.topology.base.checks import as_pose
from topple.topology.base.errors import InvalidInput, UnknownObject
from topple.topology.base.public_names import old_attribute
from topple.topology.base.values import ByValue
from topple.topology.base.workers import all_of
from topple.topology.io.load import AnyScene, as_scene
from topple.topology.kernels.neighbours import PointTree
from topple.topology.scene.scene import Scene
from topple.topology.situation.situation import Situation
from topple.topology.statics.gravity import check_up

GivenGrasps = ForeignGrasps | Sequence[Grasp] | FloatArray
"""Grasps of `read_grasps`, of this project, or an (N, 4, 4) or (N, 17) array."""

SOME = 256  # grasps asked at a time whether they are near anything
Reach = Callable[[Sequence[Grasp]], Sequence[bool | str]]
"""Whether an arm gets to each of some grasps in the world: True, False, or why not in words."""


@dataclass(frozen=True, eq=False)
class RankedGrasp(ByValue):
    """One grasp and what speaks against it.

    Attributes:
        index: Which of the given grasps.
        grasp: The grasp, with the object it holds; "" where it holds none.
        before: Objects that have to go first; none where it may be taken now.
        why: Why it cannot be used now, in words; None where it can.
    """

    index: int
    grasp: Grasp
    before: tuple[str, ...]
    why: str | None
    dropped = old_attribute("dropped")

    @property
    def feasible(self) -> bool:
        """Whether it can be used now."""
        return self.why is None


@checked_arguments
def rank_grasps(
    scene: AnyScene,
    grasps: GivenGrasps,
    robot: Arm | str | None = None,
    *,
    scores: Sequence[float] | FloatArray | None = None,
    widths: Sequence[float] | FloatArray | None = None,
    names: Mapping[int, str] | Mapping[str, str] | None = None,
    pose_source_to_world: FloatArray | None = None,
    pose_base_to_world: FloatArray | None = None,
    reach: Reach | None = None,
    graph: DependencyGraph | None = None,
) -> list[RankedGrasp]:
    """Rank grasps by what may be taken first.

    Each grasp is given to the object that its file names, or else to the one between its pads; then come: how
    many others have to go before that object, whether the hand has room and holds it and the arm reaches it,
    whether cameras saw the hand's way to be empty, and the score it came with.

    Args:
        scene: What is seen, with `up`.
        grasps: Grasps of this project, of `read_grasps`, or an (N, 4, 4) or (N, 17) array. Bare poses are
            those of the lip where the arm has a cup and no fingers.
        robot: The arm, or its name; without one the hand of a Panda is taken, or its cup, and reach is not
            asked.
        scores: (N,) of an array of grasps, larger is better.
        widths: (N,) openings of the hand [m] of an array of grasps.
        names: What the scene calls the segments or objects of a file of grasps: {0: "cup"}. Without it
            their numbers are names, "3", where the scene has any of those, and mean nothing otherwise.
            GraspNet counts objects from 0, and from 1 in its label images.
        pose_source_to_world: (4, 4) for grasps given in a camera's or object's frame; where None, that of
            the scene's own camera if more of a file's grasps are at things by it (`camera_frame`).
        pose_base_to_world: (4, 4) where the arm stands; the scene's `robot_base`; without both, reach is not
            asked.
        reach: Asked instead of the arm's kinematics: takes the grasps that nothing else speaks against, gives
            for each True, False, or why not: "joint 4 at its limit". Poses are of the tool, in the world.
        graph: What has to go before what; found in the scene where None.

    Returns:
        All grasps, best first; those that cannot be used now say all that speaks against them.

    Raises:
        InvalidInput: The grasps, a pose or the scene are not what they should be, no grasp is near anything
            in the scene, the arm has no tool for them, or `reach` gives something else.
        UnknownObject: A grasp names an object that is not in the scene.

    Examples:
        >>> poses = np.tile(np.diag([1.0, -1, -1, 1]), (2, 1, 1))  # from above
        >>> poses[:, :3, 3] = [0.5, 0, 0.1], [0.55, 0, 0.03]
        >>> for ranked in rank_grasps(scene, poses, "panda", scores=[0.4, 0.9], widths=[0.07, 0.07]):
        ...     print(ranked.index, ranked.grasp.object, ranked.before)
        0 cup ()
        1 book ('cup',)
    """
    scene = as_scene(scene)
    if isinstance(grasps, np.ndarray):
        source = grasps_from_array(grasps, scores=scores, widths=widths)
    elif scores is not None or widths is not None:
        raise InvalidInput("scores and widths go with an array of grasps: these grasps have their own")
    else:
        source = grasps
    told = _told_objects(source, scene, names) if isinstance(source, ForeignGrasps) else {}
    arm = robot_named(robot) if isinstance(robot, str) else robot
    if pose_source_to_world is None and isinstance(source, ForeignGrasps):
        pose_source_to_world = camera_frame(scene, source)
    given = _as_grasps(source, pose_source_to_world, arm)
    if not given:
        return []
    _check(given, scene, arm)
    check_up(scene)
    situation = Situation(scene)
    graph = dependencies(situation) if graph is None else graph
    room = Room.of(situation, arm)
    found = _held_objects(given, told, room)
    against = judge_grasps([entry.grasp for entry in found], room)
    before = {
        name: tuple(sorted(graph.before(name))) for name in {entry.grasp.object for entry in found} - {""}
    }
    for row, entry in enumerate(found):
        if name := entry.grasp.object:
            first = before[name]
            waits = [f"{', '.join(first)} would move: has to go before {name}"] if first else []
            asked, speaks = against[row].grasp, (*against[row].refused, *waits)
            grasp = replace(entry.grasp, width=asked.width, unseen=asked.unseen)
            found[row] = replace(entry, grasp=grasp, before=first, why="; ".join(speaks) or None)
    base = scene.robot_base if pose_base_to_world is None else pose_base_to_world
    if reach is None and arm is not None and base is not None:
        reach = partial(reachable, arm=arm, pose_base_to_world=as_pose(base, "pose_base_to_world"))
    if reach is not None:
        found = _reachable(found, reach)
    return sorted(found, key=_key)


def camera_frame(scene: Scene, grasps: ForeignGrasps) -> FloatArray | None:
    """Tell whether grasps are in the frame of a camera that saw the scene.

    Args:
        scene: The scene, with its pictures.
        grasps: The grasps of a file.

    Returns:
        The pose (4, 4) of that camera, by which more of the grasps are near what can be taken than as they
        are; None where there is none.
    """
    if not len(grasps) or not scene.movable:
        return None
    tree = PointTree(np.concatenate([scene.clouds[name] for name in scene.movable]))
    frames = [np.eye(4), *(image.pose_camera_to_world for image in scene.images)]
    places = [(frame @ grasps.poses_tool_to_source[:SOME])[:, :3, 3] for frame in frames]
    near = [int((tree.query(some)[0] <= HAND_REACH).sum()) for some in places]
    return frames[int(np.argmax(near))] if max(near) > near[0] else None


@checked_arguments
def rank_all(
    scenes: Iterable[AnyScene],
    grasps: Iterable[GivenGrasps | str | os.PathLike[str]],
    robot: Arm | str | None = None,
    *,
    executor: Executor | None = None,
    reach: Reach | None = None,
) -> list[list[RankedGrasp]]:
    """Rank the grasps of many scenes, on the workers of an executor where one is given.

    Args:
        scenes: Scenes, or paths of their files, which the workers then read.
        grasps: The grasps of each, in its frame; or paths, for `read_grasps`.
        robot: As for `rank_grasps`; each arm stands where its scene has `robot_base`.
        executor: Any executor of `concurrent.futures`, or that of a dask client; `reach` then has to be a
            function that can go to another process.
        reach: As for `rank_grasps`.

    Returns:
        The ranking of each scene, in order.

    Raises:
        InvalidInput: As `rank_grasps`, or there are more scenes than grasps or the other way round.
        WorkerLost: The worker of a scene was lost twice.

    Examples:
        >>> pose = np.diag([1.0, -1, -1, 1])
        >>> pose[:3, 3] = 0.5, 0, 0.1
        >>> [ranked[0].grasp.object for ranked in rank_all([scene], [pose[None]])]
        ['cup']
    """
    pairs = list(zip_longest(scenes, grasps))
    short = [number for number, pair in enumerate(pairs) if any(part is None for part in pair)]
    if short:
        raise InvalidInput(f"scenes and grasps differ in number from {short[0]} on: expected one for each")
    each = partial(_rank_pair, robot=robot, reach=reach)
    return list(all_of(each, pairs, executor))


def _rank_pair(
    pair: tuple[AnyScene, GivenGrasps | str | os.PathLike[str]],
    robot: Arm | str | None,
    reach: Reach | None,
) -> list[RankedGrasp]:
    scene, grasps = pair
    given = read_grasps(os.fspath(grasps)) if isinstance(grasps, (str, os.PathLike)) else grasps
    return rank_grasps(scene, given, robot, reach=reach)


def _key(ranked: RankedGrasp) -> tuple[float, bool, bool, float, int]:
    held = len(ranked.before) if ranked.grasp.object else np.inf
    return (held, not ranked.feasible, ranked.grasp.unseen, -ranked.grasp.score, ranked.index)


def _as_grasps(
    grasps: ForeignGrasps | Sequence[Grasp], pose_source_to_world: FloatArray | None, arm: Arm | None
) -> list[Grasp]:
    """Grasps in the world; bare poses are those of the lip where the arm has a cup and no fingers."""
    to_world = (
        np.eye(4) if pose_source_to_world is None else as_pose(pose_source_to_world, "pose_source_to_world")
    )
    if not isinstance(grasps, ForeignGrasps):
        return [grasp.move(to_world) for grasp in grasps]
    poses, openings = to_world @ grasps.poses_tool_to_source, np.nan_to_num(grasps.widths)
    kind: str = PINCH
    if arm is not None and arm.tools and not arm.hand_limits.opening and bool(np.isnan(grasps.widths).all()):
        kind = next(iter(shapes_of(arm).values())).kind
    return [
        Grasp("", kind, pose, 0.0, opening, score, grasps.source)
        for pose, opening, score in zip(poses, openings.tolist(), grasps.scores.tolist(), strict=True)
    ]


def _told_objects(
    grasps: ForeignGrasps, scene: Scene, names: Mapping[int, str] | Mapping[str, str] | None
) -> dict[int, str]:
    """Objects that grasps hold according to their file, by index."""
    for name in () if names is None else names.values():
        if name not in scene.movable:
            raise UnknownObject(name, scene.movable, role="object to grasp")
    told = {index: label for index, label in enumerate(grasps.labels) if label}
    if names is not None:
        called = {str(number): name for number, name in names.items()}
        return {index: called[label] for index, label in told.items() if label in called}
    return told if scene.clouds.keys() & set(told.values()) else {}


def _check(grasps: Sequence[Grasp], scene: Scene, arm: Arm | None) -> None:
    """Refuse grasps of nothing that can move, by tools that are not there, or in another frame or unit."""
    for grasp in grasps:
        if grasp.object and grasp.object not in scene.movable:
            raise UnknownObject(grasp.object, scene.movable, role="object to grasp")
        if arm is not None and grasp.tool not in arm.tools:
            raise InvalidInput(f"{arm.name} has no {grasp.tool}: it has {', '.join(arm.tools)}")
    places = poses_of(grasps)[:, :3, 3]
    trees = {name: PointTree(scene.clouds[name]) for name in scene.movable}
    away = dict.fromkeys(trees, np.inf)
    for first in range(0, len(places), SOME):  # the first few are near enough, or none is
        for name, tree in trees.items():
            away[name] = min(away[name], float(tree.query(places[first : first + SOME])[0].min()))
        if min(away.values(), default=0.0) <= HAND_REACH:
            return
    nearest = min(away, key=lambda name: away[name])
    raise InvalidInput(
        f"no grasp is near anything: the nearest is {away[nearest]:.2f} m from {nearest}: give them "
        "in metres in the frame of the scene or its camera, or pose_source_to_world=POSE"
    )


def _held_objects(given: Sequence[Grasp], told: Mapping[int, str], room: Room) -> list[RankedGrasp]:
    """Each grasp with the object it holds, those that hold none dropped."""
    found = [RankedGrasp(index, grasp, (), None) for index, grasp in enumerate(given)]
    movable = room.scene.movable
    for index, counts in _within_tools(given, room).items():
        largest = max(counts, default=0)
        most = movable[counts.index(largest)] if largest > GRASP_TOLERANCES.stray_points else ""
        name, grasp = told.get(index, most), given[index]
        if not most:
            found[index] = RankedGrasp(index, grasp, (), f"nothing is {room.shape(grasp.tool).where}")
        elif name not in movable:
            why = "never moves" if name in room.scene.fixed else "is not in the scene"
            found[index] = RankedGrasp(index, grasp, (), f"its file has it hold {name}, which {why}")
        elif counts[movable.index(name)] <= GRASP_TOLERANCES.stray_points:
            why = f"its file has it hold {name}, but {room.shape(grasp.tool).where} is {most}"
            found[index] = RankedGrasp(index, grasp, (), why)
        else:
            found[index] = RankedGrasp(index, replace(grasp, object=name), (), None)
    return found


def _within_tools(given: Sequence[Grasp], room: Room) -> dict[int, list[int]]:
    """Points of each movable object between the pads, or under the cup, of grasps that name none."""
    within: dict[int, list[int]] = {}
    for tool in dict.fromkeys(grasp.tool for grasp in given if not grasp.object):
        rows = [index for index, grasp in enumerate(given) if not grasp.object and grasp.tool == tool]
        counted = room.within(tool, poses_of(given[row] for row in rows))
        within.update(zip(rows, counted.tolist(), strict=True))
    return within


def _reachable(found: list[RankedGrasp], reach: Reach) -> list[RankedGrasp]:
    """Ask about what is left whether the arm gets there."""
    left = [ranked for ranked in found if ranked.feasible]
    said = list(reach([ranked.grasp for ranked in left])) if left else []
    if len(said) != len(left):
        raise InvalidInput(f"reach gave {len(said)} answers for {len(left)} grasps: expected one for each")
    why: dict[int, str] = {}
    for ranked, answer in zip(left, said, strict=True):
        told: Any = answer  # whatever a stranger's function gave
        if not isinstance(told, (bool, np.bool_, str)):
            raise InvalidInput(f"reach gave {told!r} for a grasp: expected True, False, or why not in words")
        if isinstance(told, str) or not told:
            why[ranked.index] = (told if isinstance(told, str) else "") or "out of reach"
    return [replace(ranked, why=why.get(ranked.index, ranked.why)) for ranked in found]
