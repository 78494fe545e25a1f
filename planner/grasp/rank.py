"""Grasps of any pipeline ranked for clutter: safe order first, then what can be done, then their score."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from topple.planner.grasp.candidates import surroundings
from topple.planner.grasp.foreign import ForeignGrasps, grasps_from_array
from topple.planner.grasp.grasp import Grasp
from topple.planner.grasp.hand import HandShape, hand_shape
from topple.planner.grasp.reach import reachable
from topple.planner.grasp.tolerances import GRASP_TOLERANCES
from topple.planner.order import order
from topple.planner.solids import up_of
from topple.robots.arm import Arm
from topple.robots.catalog import robot as robot_named
from topple.topology.arrays import FloatArray
from topple.topology.scene import Scene


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
        robot: The arm, or its name; without one the hand of a Panda is taken and reach is not asked.
        pose_source_to_world: (4, 4) for grasps given in a camera's or object's frame.
        pose_base_to_world: (4, 4) where the arm stands; the scene's `robot_base`; without both, reach is not
            asked.

    Returns:
        All grasps, best first; those that cannot be used now say why.

    Raises:
        InvalidInput: The grasps or the scene are not what they should be.
    """
    given = _as_grasps(grasps, pose_source_to_world)
    if not given:
        return []
    arm = robot_named(robot) if isinstance(robot, str) else robot
    hand = hand_shape(robot_named("panda") if arm is None else arm)
    graph = order(scene).graph
    base = scene.robot_base if pose_base_to_world is None else pose_base_to_world
    found: list[RankedGrasp] = []
    for index, grasp in enumerate(given):
        name = grasp.object or _held(grasp, scene, hand)
        if not name:
            found.append(RankedGrasp(index, grasp, (), "nothing is between its pads"))
            continue
        grasp = replace(grasp, object=name)
        before = tuple(sorted(graph.before(name)))
        dropped = _in_the_way(grasp, scene, hand)
        if dropped is None and before:
            dropped = f"{', '.join(before)} would move: has to go before {name}"
        found.append(RankedGrasp(index, grasp, before, dropped))
    if arm is not None and base is not None:
        found = _reachable(found, arm, np.asarray(base, dtype=np.float64))
    return sorted(found, key=_key)


def _key(ranked: RankedGrasp) -> tuple[float, bool, float, int]:
    held = len(ranked.before) if ranked.grasp.object else np.inf
    return (held, ranked.dropped is not None, -ranked.grasp.score, ranked.index)


def _as_grasps(
    grasps: ForeignGrasps | Sequence[Grasp] | FloatArray, pose_source_to_world: FloatArray | None
) -> list[Grasp]:
    if isinstance(grasps, np.ndarray):
        grasps = grasps_from_array(grasps)
    if not isinstance(grasps, ForeignGrasps):
        return list(grasps)
    poses = grasps.poses_tool_to_source
    if pose_source_to_world is not None:
        poses = np.asarray(pose_source_to_world, dtype=np.float64) @ poses
    return [
        Grasp("", "pinch", pose, 0.0, float(np.nan_to_num(width)), float(score), grasps.source)
        for pose, width, score in zip(poses, grasps.widths, grasps.scores, strict=True)
    ]


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


def _in_the_way(grasp: Grasp, scene: Scene, hand: HandShape) -> str | None:
    """What the open hand meets on its straight way in."""
    if grasp.kind == "suction":
        return None
    opening = min(hand.max_opening, grasp.opening) if grasp.opening > 0.0 else hand.max_opening
    for name, cloud in scene.clouds.items():
        local = _local(cloud, grasp)
        local = local[(local[:, 2] > -GRASP_TOLERANCES.reach) & (np.abs(local[:, :2]).max(axis=1) < 0.12)]
        for x0, x1, y0, y1, front in hand.footprints(opening):
            inside = (
                (local[:, 0] > x0) & (local[:, 0] < x1) & (local[:, 1] > y0) & (local[:, 1] < y1)
                & (local[:, 2] < front - GRASP_TOLERANCES.under_clearance)
            )  # fmt: skip
            if np.count_nonzero(inside) > GRASP_TOLERANCES.stray_points:
                return f"the hand meets {name}"
    _, floor = surroundings(grasp.object, scene, up_of(scene))
    tip = grasp.pose_tool_to_world[:3, 3] + hand.tip * grasp.approach
    return "the fingers would go below the ground" if float(tip @ up_of(scene)) < floor else None


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
