"""KinDER's starts: goals with room for every part, and motions as its actions take them."""

import numpy as np

from topple.benchmarks.kinder import ROOM, centred, packed, pieces, seen
from topple.benchmarks.textbook import box
from topple.planner.planning.plan import plan
from topple.robots.collision.fcl_bodies import apart
from topple.topology.base.arrays import FloatArray
from topple.topology.bodies.solids import move_parts
from topple.topology.scene.scene import Scene
from topple.topology.situation.situation import Situation

TABLE = [box((40, 80, 2), 30, 0, -2) / 100]


def scene(parts: dict[str, list[FloatArray]], *fixed: str) -> Scene:
    clouds = {name: seen(some, name in fixed) for name, some in parts.items()}
    return Scene(clouds, fixed=fixed, up=(0, 0, 1), robot_base=np.eye(4))


def test_the_block_comes_to_stand_in_the_middle_of_the_region() -> None:
    block, region = box((6, 6, 5), 30, -10, 0) / 100, box((8, 8, 1), 30, 20, 0) / 100
    (there,) = move_parts([block], centred({"target_block": [block], "target_region": [region]}))
    np.testing.assert_allclose(
        (there.min(axis=0), there.max(axis=0)), ((0.27, 0.17, 0.01), (0.33, 0.23, 0.06))
    )


def test_parts_are_packed_apart_and_inside_the_walls() -> None:
    walls = [box((1, 30, 3), x, 0, 0) / 100 for x in (20.5, 39.5)]
    walls += [box((20, 1, 3), 30, y, 0) / 100 for y in (-14.5, 14.5)]
    parts = {"table": TABLE, "rack": walls}
    for k, y in enumerate((-30, 25, 36)):
        parts[f"part{k}"] = [box((6, 6, 2), 20, y, 0) / 100, box((2, 2, 5), 20, y, 2) / 100]
    goal = packed(parts, Situation(scene(parts, "table", "rack")))
    for k in range(3):
        here = goal.scene.clouds[f"part{k}"]
        assert (abs(here[:, :2] - (0.3, 0.0)) < (0.09, 0.14)).all()
        for other in range(k):
            assert apart(goal.solids[f"part{k}"][:1], goal.solids[f"part{other}"][:1], 0.9 * ROOM)


def test_a_plan_is_told_by_few_states_the_last_of_each_motion_among_them() -> None:
    parts = {"table": TABLE, "block": [box((4, 4, 5), 40, 0, 0) / 100]}
    made = plan(scene(parts, "table"), ["block"], "panda")
    told = pieces([made])
    motions = [segment for step in made.steps for segment in step.segments]
    assert [hand for _, hand, _ in told if hand] == [-1.0, 1.0]
    for (kind, _, states), segment in zip(told, motions, strict=True):
        assert kind == str(segment.kind)
        if segment.motion is not None:
            np.testing.assert_array_equal(states[-1], segment.motion.positions[-1])
            assert len(states) <= len(segment.motion.positions)
