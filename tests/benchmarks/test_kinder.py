"""KinDER's starts: goals with room for everything, and motions as its actions take them."""

import numpy as np

from topple.benchmarks.kinder import BESIDE, ROOM, cleared, packed, pieces
from topple.benchmarks.textbook import box
from topple.planner.planning.plan import plan
from topple.robots.collision.fcl_bodies import apart
from topple.topology.base.arrays import FloatArray
from topple.topology.geometry.samples import sampled
from topple.topology.scene.scene import Scene
from topple.topology.situation.situation import Situation

BASE = np.eye(4)
TABLE = box((40, 80, 2), 30, 0, -2)


def situation(parts: dict[str, list[FloatArray]], fixed: tuple[str, ...]) -> Situation:
    clouds = {name: sampled(some, 0.004) for name, some in parts.items()}
    return Situation(Scene(clouds, fixed=fixed, up=(0, 0, 1), robot_base=BASE))


def test_the_block_comes_to_the_middle_of_the_region_and_others_to_the_table() -> None:
    cm = {
        "table": TABLE,
        "target_region": box((8, 8, 1), 30, 20, 0),
        "target_block": box((6, 6, 5), 30, -10, 0),
        "obstruction0": box((3, 3, 3), 28, 21, 1),
        "obstruction1": box((3, 3, 3), 30, -25, 0),
    }
    parts = {name: [corners / 100] for name, corners in cm.items()}
    now = situation(parts, ("table", "target_region"))
    goal = cleared(parts, now, BASE)
    block = goal.scene.clouds["target_block"]
    np.testing.assert_allclose((block.min(axis=0) + block.max(axis=0)) / 2, (0.3, 0.2, 0.035), atol=1e-3)
    assert apart(goal.solids["obstruction0"], goal.solids["target_block"], BESIDE)
    np.testing.assert_array_equal(goal.scene.clouds["obstruction1"], now.scene.clouds["obstruction1"])


def test_parts_are_packed_apart_and_inside_the_walls() -> None:
    walls = [box((1, 30, 3), x, 0, 0) for x in (20.5, 39.5)] + [
        box((20, 1, 3), 30, y, 0) for y in (-14.5, 14.5)
    ]
    cm = {"table": [TABLE], "rack": walls}
    for k, y in enumerate((-30, 25, 36)):
        cm[f"part{k}"] = [box((10, 10, 2), 20, y, 0), box((2, 2, 5), 20, y, 2)]
    parts = {name: [corners / 100 for corners in some] for name, some in cm.items()}
    goal = packed(parts, situation(parts, ("table", "rack")), BASE)
    for k in range(3):
        here = goal.scene.clouds[f"part{k}"]
        assert (abs(here[:, :2] - (0.3, 0.0)) < (0.09, 0.14)).all()
        for other in range(k):
            assert apart(goal.solids[f"part{k}"], goal.solids[f"part{other}"], 0.8 * ROOM)


def test_a_plan_is_told_by_few_states_the_last_of_each_motion_among_them() -> None:
    parts = {"table": [TABLE / 100], "block": [box((4, 4, 5), 40, 0, 0) / 100]}
    made = plan(situation(parts, ("table",)).scene, ["block"], "panda")
    told = pieces(made)
    motions = [segment for step in made.steps for segment in step.segments]
    assert [hand for _, hand, _ in told if hand] == [-1.0, 1.0]
    for (kind, _, states), segment in zip(told, motions, strict=True):
        assert kind == str(segment.kind)
        if segment.motion is not None:
            np.testing.assert_array_equal(states[-1], segment.motion.positions[-1])
            assert len(states) <= len(segment.motion.positions)
