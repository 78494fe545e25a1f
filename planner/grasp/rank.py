"""Grasps of any pipeline ranked for clutter: safe order first, then what can be done, then their score."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.spatial import KDTree

from topple.planner.grasp.foreign import ForeignGrasps, grasps_from_array
from topple.planner.grasp.grasp import Grasp
from topple.planner.grasp.hand import HAND_REACH, HandShape, hand_shape
from topple.planner.grasp.reach import reachable
from topple.planner.grasp.suction import CupShape, cup_shape
from topple.planner.grasp.surroundings import surroundings
from topple.planner.grasp.tolerances import GRASP_TOLERANCES
from topple.planner.order import order
from topple.planner.solids import up_of
from topple.robots.arm import Arm
from topple.robots.catalog import robot as robot_named
from topple.topology.arrays import FloatArray
from topple.topology.checks import as_pose
from topple.topology.errors import InvalidInput, UnknownObject
from topple.topology.scene import Scene

_NOTHING = {"fingers": "nothing is between its pads", "suction": "nothing is under its cup"}


@dataclass(frozen=True, eq=False)
class RankedGrasp:
    """One grasp and what speaks against it.

    Attributes:
        index: Which of the given grasps.
        grasp: The grasp, with the object it holds; "" where it holds none.
        before: Objects that have to go first; nobody where it may be taken now.
        dropped: Why it cannot be used now, in words; None where it can.
    """

    index: int
    grasp: Grasp
    before: tuple[str, ...]
    dropped: str | None


def rank_grasps(
    scene: Scene,
    grasps: ForeignGrasps | Sequence[Grasp] | FloatArray,
    robot: Arm | str | None = None,
    *,
    pose_source_to_world: FloatArray | None = None,
    pose_base_to_world: FloatArray | None = None,
) -> list[RankedGrasp]:
    """Rank grasps by what may be taken first.

    Each grasp is given to the object between its pads; then come: how many others have to go before that
    object, whether the hand has room and the arm reaches it, and the score it came with.

    Args:
        scene: What is seen, with `up`.
        grasps: Grasps of this project, of `read_grasps`, or an (N, 4, 4) or (N, 17) array.
        robot: The arm, or its name; without one the hand of a Panda is taken, or its cup, and reach is not
            asked.
        pose_source_to_world: (4, 4) for grasps given in a camera's or object's frame.
        pose_base_to_world: (4, 4) where the arm stands; the scene's `robot_base`; without both, reach is not
            asked.

    Returns:
        All grasps, best first; those that cannot be used now say all that speaks against them.

    Raises:
        InvalidInput: The grasps, a pose or the scene are not what they should be, no grasp is near anything
            in the scene, or the arm has no tool for them.
        UnknownObject: A grasp names an object that is not in the scene.
    """
    given = _as_grasps(grasps, pose_source_to_world)
    if not given:
        return []
    arm = robot_named(robot) if isinstance(robot, str) else robot
    _check(given, scene, arm)
    hand = hand_shape(arm if arm is not None and "fingers" in arm.tools else robot_named("panda"))
    cup = cup_shape(arm if arm is not None and "suction" in arm.tools else robot_named("panda-suction"))
    graph = order(scene).graph
    base = scene.robot_base if pose_base_to_world is None else pose_base_to_world
    found: list[RankedGrasp] = []
    for index, grasp in enumerate(given):
        name = grasp.object or _held(grasp, scene, hand)
        if not name:
            found.append(RankedGrasp(index, grasp, (), _NOTHING[grasp.tool]))
            continue
        grasp = replace(grasp, object=name)
        before = tuple(sorted(graph.before(name)))
        against = _in_the_way(grasp, scene, hand, cup)
        if before:
            against.append(f"{', '.join(before)} would move: has to go before {name}")
        found.append(RankedGrasp(index, grasp, before, "; ".join(against) or None))
    if arm is not None and base is not None:
        found = _reachable(found, arm, as_pose(base, "pose_base_to_world"))
    return sorted(found, key=_key)


def _key(ranked: RankedGrasp) -> tuple[float, bool, float, int]:
    held = len(ranked.before) if ranked.grasp.object else np.inf
    return (held, ranked.dropped is not None, -ranked.grasp.score, ranked.index)


def _as_grasps(
    grasps: ForeignGrasps | Sequence[Grasp] | FloatArray, pose_source_to_world: FloatArray | None
) -> list[Grasp]:
    if isinstance(grasps, np.ndarray):
        grasps = grasps_from_array(grasps)
    to_world = (
        np.eye(4) if pose_source_to_world is None else as_pose(pose_source_to_world, "pose_source_to_world")
    )
    if not isinstance(grasps, ForeignGrasps):
        return [replace(grasp, pose_tool_to_world=to_world @ grasp.pose_tool_to_world) for grasp in grasps]
    poses = to_world @ grasps.poses_tool_to_source
    return [
        Grasp("", "pinch", pose, 0.0, float(np.nan_to_num(width)), float(score), grasps.source)
        for pose, width, score in zip(poses, grasps.widths, grasps.scores, strict=True)
    ]


def _check(grasps: Sequence[Grasp], scene: Scene, arm: Arm | None) -> None:
    """Refuse grasps of nothing that can move, by tools that are not there, or in another frame or unit."""
    for grasp in grasps:
        if grasp.object and grasp.object not in scene.movable:
            raise UnknownObject(grasp.object, scene.movable, role="object to grasp")
        if arm is not None and grasp.tool not in arm.tools:
            raise InvalidInput(f"{arm.name} has no {grasp.tool}: it has {', '.join(arm.tools)}")
    places = np.array([grasp.pose_tool_to_world[:3, 3] for grasp in grasps])
    away = {name: float(KDTree(scene.clouds[name]).query(places)[0].min()) for name in scene.movable}
    nearest = min(away, key=lambda name: away[name], default="")
    if nearest and away[nearest] > HAND_REACH:
        raise InvalidInput(
            f"no grasp is near anything: the nearest is {away[nearest]:.2f} m from {nearest}: give the frame "
            "they are in (pose_source_to_world), in metres"
        )


def _held(grasp: Grasp, scene: Scene, hand: HandShape) -> str:
    """The movable object with most points between the pads."""
    counts: dict[str, int] = {}
    for name in scene.movable:
        local = _local(scene.clouds[name], grasp)
        between = (
            (np.abs(local[:, 0]) < hand.pad_width / 2.0)
            & (np.abs(local[:, 1]) < hand.max_opening / 2.0)
            & (np.abs(local[:, 2]) < hand.pad_length / 2.0 + 0.005)
        )
        counts[name] = int(np.count_nonzero(between))
    best = max(counts, key=lambda name: counts[name], default="")
    return best if best and counts[best] > GRASP_TOLERANCES.stray_points else ""


def _in_the_way(grasp: Grasp, scene: Scene, hand: HandShape, cup: CupShape) -> list[str]:
    """What the open hand meets on its straight way in, in words."""
    met: list[str] = []
    for name, cloud in scene.clouds.items():
        local = _local(cloud, grasp)
        local = local[(local[:, 2] > -GRASP_TOLERANCES.reach) & (np.abs(local[:, :2]).max(axis=1) < 0.12)]
        within = [
            (local[:, 0] > x0) & (local[:, 0] < x1) & (local[:, 1] > y0) & (local[:, 1] < y1)
            & (local[:, 2] < front - GRASP_TOLERANCES.under_clearance)
            for x0, x1, y0, y1, front in _footprints(grasp, hand, cup)
        ]  # fmt: skip
        if grasp.tool == "suction" and name != grasp.object:
            within.append(cup.beside(local, GRASP_TOLERANCES.under_clearance))
        if any(np.count_nonzero(inside) > GRASP_TOLERANCES.stray_points for inside in within):
            met.append(name)
    against = [f"the hand meets {', '.join(met)}"] if met else []
    if grasp.tool == "suction":
        return against
    floor = surroundings(grasp.object, scene, up_of(scene)).floor
    tip = grasp.pose_tool_to_world[:3, 3] + hand.tip * grasp.approach
    return (
        [*against, "the fingers would go below the ground"] if float(tip @ up_of(scene)) < floor else against
    )


def _footprints(
    grasp: Grasp, hand: HandShape, cup: CupShape
) -> list[tuple[float, float, float, float, float]]:
    """Rectangles (x low, x high, y low, y high, z of its front) that the hand sweeps [m]."""
    if grasp.tool == "suction":
        return [(*prism.x, *prism.y, prism.front) for prism in cup.body]
    opening = min(hand.max_opening, grasp.opening) if grasp.opening > 0.0 else hand.max_opening
    return [(x0, x1, float(y0), float(y1), front) for x0, x1, y0, y1, front in hand.footprints(opening)]


def _local(cloud: FloatArray, grasp: Grasp) -> FloatArray:
    pose = grasp.pose_tool_to_world
    return (cloud - pose[:3, 3]) @ pose[:3, :3]


def _reachable(found: list[RankedGrasp], arm: Arm, base: FloatArray) -> list[RankedGrasp]:
    """Ask inverse kinematics about what is left."""
    left = [ranked for ranked in found if ranked.dropped is None]
    solved = reachable([ranked.grasp for ranked in left], arm, base)
    unreachable = {ranked.index for ranked, yes in zip(left, solved, strict=True) if not yes}
    return [
        replace(ranked, dropped="out of reach") if ranked.index in unreachable else ranked for ranked in found
    ]
