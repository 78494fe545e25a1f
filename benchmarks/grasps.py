"""Grasps of another pipeline ranked: thousands of a depth camera's frame, against one after the other.

Hands come from above, tilted and turned at random, at random points of fifteen things on a table seen by a
640x480 camera. Beside ours: every grasp for itself against every point in plain numpy, see `plain_hands`, on
the first of the same grasps, times their share. That side is spared the order, what the object is and the
arm. All of its answers are compared.
"""

from dataclasses import replace
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from topple.benchmarks import plain_hands
from topple.benchmarks.clock import cpu_seconds
from topple.benchmarks.clouds import frame
from topple.benchmarks.row import Progress, Row, faster
from topple.planner.grasp.foreign import grasps_from_array
from topple.planner.grasp.jaw import hand_shape
from topple.planner.grasp.rank import RankedGrasp, rank_grasps
from topple.planner.grasp.suction import cup_shape
from topple.robots.catalog import robot
from topple.topology.base.arrays import FloatArray
from topple.topology.scene.scene import Scene

COUNT = 5000
SAMPLE, QUICK_SAMPLE = 250, 50  # of them that are held against every point
NUMPY = "plain numpy, one grasp after the other"
NOTHING = "nothing is between its pads"
PLAIN = (NOTHING, "the hand meets", "the fingers would")  # what plain numpy is asked
TILT = 0.4  # [rad] standard deviation about each level axis


def rows(quick: bool, seed: int, progress: Progress) -> list[dict[str, Any]]:
    """Measure.

    Args:
        quick: Fewer grasps by plain numpy.
        seed: Of frame and grasps.
        progress: Called before each part.

    Returns:
        The bench's rows.
    """
    progress(f"{COUNT:,} grasps of a frame")
    scene = Scene.from_images([frame(seed)], fixed=["table"], up=(0, 0, 1))
    poses = random_grasps(scene, COUNT, np.random.default_rng(seed))
    rank_grasps(scene, poses[:10])  # the robots' files are read once
    ranked: list[RankedGrasp] = []
    ours = cpu_seconds(lambda: ranked.extend(rank_grasps(scene, grasps_from_array(poses))))
    answers = {entry.index: entry for entry in ranked}
    count = QUICK_SAMPLE if quick else SAMPLE
    hand, cup = hand_shape(robot("panda")), cup_shape(robot("panda-suction"))
    plain: list[tuple[str, str]] = []

    def one_by_one() -> None:
        for index in range(count):
            grasp = replace(answers[index].grasp, object="")
            name = plain_hands.held(grasp, scene, hand)
            told = plain_hands.against(replace(grasp, object=name), scene, hand, cup) if name else NOTHING
            plain.append((name, told))

    theirs = cpu_seconds(one_by_one) * COUNT / count
    other = sum(_answer(answers[index]) != told for index, told in enumerate(plain))
    what = f"{COUNT:,} grasps of a 640x480 frame, {len(scene.movable)} objects, ranked"
    found = [
        faster(what, ours, NUMPY, theirs, ">= 40x"),
        Row(f"{what}: other answers, of {count}", float(other), "grasps", NUMPY, 0.0, bar="0"),
    ]
    return [row.to_json() for row in found]


def _answer(entry: RankedGrasp) -> tuple[str, str]:
    """What a grasp holds, and what is in the way of the hand."""
    told = (entry.why or "").split("; ")
    return entry.grasp.object, "; ".join(words for words in told if words.startswith(PLAIN))


def random_grasps(scene: Scene, count: int, rng: np.random.Generator) -> FloatArray:
    """Hands from above at random points of the movable objects.

    Args:
        scene: With `up`.
        count: How many.
        rng: Draws points, turns, tilts and depths.

    Returns:
        (count, 4, 4) pose_tool_to_world.
    """
    up = np.array([0.0, 0.0, 1.0]) if scene.up is None else np.asarray(scene.up)
    points = np.concatenate([scene.clouds[name] for name in scene.movable])
    level = np.cross(up, np.eye(3)[int(np.argmin(np.abs(up)))])
    level /= np.linalg.norm(level)
    down = np.column_stack([level, np.cross(-up, level), -up])
    turns = np.column_stack([rng.uniform(0.0, 2.0 * np.pi, count), rng.normal(0.0, TILT, (count, 2))])
    poses = np.tile(np.eye(4), (count, 1, 1))
    poses[:, :3, :3] = down @ Rotation.from_euler("zxy", turns).as_matrix()
    depths = rng.uniform(-0.04, 0.02, (count, 1))
    poses[:, :3, 3] = rng.choice(points, count) + depths * poses[:, :3, 2]
    return poses
