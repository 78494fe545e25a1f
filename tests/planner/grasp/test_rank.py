import numpy as np

from topple.planner.grasp.rank import rank_grasps
from topple.robots.catalog import robot
from topple.robots.shapes.boxes import box
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
