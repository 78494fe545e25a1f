from dataclasses import replace

import numpy as np
import pytest

from topple.planner.grasp.grasp import Grasp
from topple.planner.grasp.rank import rank_grasps
from topple.planner.grasp.suction import cup_shape
from topple.robots.catalog import robot
from topple.robots.shapes.boxes import box
from topple.topology.errors import InvalidInput, UnknownObject
from topple.topology.scene import Scene


def down(x: float, y: float, z: float) -> np.ndarray:
    pose = np.diag([1.0, -1.0, -1.0, 1.0])
    pose[:3, 3] = [x, y, z]
    return pose


def scene() -> Scene:
    rng = np.random.default_rng(0)
    axis = np.arange(-0.3, 0.3, 0.008)
    x, y = np.meshgrid(axis, axis)
    clouds = {
        "table": np.column_stack([x.ravel(), y.ravel(), np.zeros(x.size)]),
        "lower": box("lower", (0.05, 0.05, 0.05)).surface(3000, rng),
        "upper": box("upper", (0.05, 0.05, 0.05)).surface(3000, rng) + np.array([0.0, 0.0, 0.0505]),
    }
    return Scene(clouds, fixed=["table"], up=[0, 0, 1])


GRASPS = np.array([down(0.0, 0.0, 0.035), down(0.0, 0.0, 0.088), down(0.2, 0.2, 0.1)])


def test_what_may_go_first_comes_first_whatever_the_scores() -> None:
    ranked = rank_grasps(scene(), GRASPS)
    assert [entry.grasp.object for entry in ranked] == ["upper", "lower", ""]
    assert ranked[0].dropped is None
    assert ranked[0].before == ()


def test_every_dropped_grasp_says_why() -> None:
    ranked = {entry.index: entry for entry in rank_grasps(scene(), GRASPS)}
    assert "upper" in (ranked[0].dropped or "")
    assert ranked[2].dropped == "nothing is between its pads"


def test_what_the_arm_cannot_reach_is_dropped() -> None:
    far = np.eye(4)
    far[0, 3] = -3.0
    ranked = rank_grasps(scene(), GRASPS, robot("panda"), pose_base_to_world=far)
    assert ranked[0].dropped == "out of reach"


def test_no_grasps_give_no_ranking() -> None:
    assert rank_grasps(scene(), np.empty((0, 4, 4))) == []


def test_all_that_speaks_against_a_grasp_is_said() -> None:
    ranked = {entry.index: entry for entry in rank_grasps(scene(), GRASPS)}
    assert "the hand meets upper" in (ranked[0].dropped or "")
    assert "upper would move: has to go before lower" in (ranked[0].dropped or "")


def test_of_what_may_go_now_what_can_be_done_comes_before_a_better_score() -> None:
    blocked, free = down(0.0, 0.0, 0.088), down(0.0, 0.0, 0.088)
    blocked[2, 3] = 0.03  # so deep that the palm meets the top
    poses = [
        Grasp("upper", "pinch", pose, 0.05, 0.06, score) for pose, score in ((blocked, 0.9), (free, 0.2))
    ]
    better = replace(poses[1], score=0.3)
    ranked = rank_grasps(scene(), [*poses, better])
    assert [entry.index for entry in ranked] == [2, 1, 0]
    assert ranked[2].dropped is not None


def test_grasps_in_another_frame_are_brought_to_the_world_or_refused() -> None:
    away, back = np.eye(4), np.eye(4)
    away[0, 3], back[0, 3] = 2.0, -2.0
    with pytest.raises(InvalidInput, match=r"no grasp is near anything.*pose_source_to_world"):
        rank_grasps(scene(), away @ GRASPS)
    ranked = rank_grasps(scene(), away @ GRASPS, pose_source_to_world=back)
    assert [entry.grasp.object for entry in ranked] == ["upper", "lower", ""]
    with pytest.raises(InvalidInput, match="pose_source_to_world"):
        rank_grasps(scene(), GRASPS, pose_source_to_world=np.eye(3))


def test_grasps_of_what_is_not_there_and_by_tools_that_are_missing_are_refused() -> None:
    with pytest.raises(UnknownObject, match="cup"):
        rank_grasps(scene(), [Grasp("cup", "pinch", down(0.0, 0.0, 0.088), 0.05, 0.06, 1.0)])
    with pytest.raises(InvalidInput, match="panda has no suction"):
        rank_grasps(scene(), [Grasp("upper", "suction", down(0.0, 0.0, 0.1), 0.0, 0.0, 1.0)], "panda")


def test_a_cup_that_meets_a_neighbour_says_which() -> None:
    beside = box("wall", (0.02, 0.05, 0.2)).surface(3000, np.random.default_rng(1)) + np.array(
        [0.02, 0.0, 0.0]
    )
    pushed = scene().with_cloud("wall", beside)
    grasp = Grasp("upper", "suction", down(0.0, 0.0, 0.1005), 0.0, 0.08, 0.9)
    met, free = (rank_grasps(given, [grasp], "panda-suction")[0] for given in (pushed, scene()))
    assert "the hand meets wall" in (met.dropped or "")
    assert free.dropped is None


def test_a_neighbour_beside_the_cup_alone_is_met_too() -> None:
    cup = cup_shape(robot("panda-suction"))
    rod = np.random.default_rng(1).uniform([-0.003, -0.003, 0.103], [0.003, 0.003, 0.12], (400, 3))
    rod += np.array([0.012, 0.0, 0.0])
    assert all(rod[:, 2].max() < 0.1005 - prism.front for prism in cup.body), "under the open fingers"
    grasp = Grasp("upper", "suction", down(0.0, 0.0, 0.1005), 0.0, 0.08, 0.9)
    (ranked,) = rank_grasps(scene().with_cloud("rod", rod), [grasp], "panda-suction")
    assert "the hand meets rod" in (ranked.dropped or "")
