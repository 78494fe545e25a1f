import numpy as np

from topple.planner.grasp.candidates import grasp_candidates
from topple.planner.grasp.jaw import hand_shape
from topple.robots.catalog import robot
from topple.robots.shapes.boxes import box, can
from topple.topology.scene.scene import Scene

HAND = hand_shape(robot("panda"))
UP = np.array([0.0, 0.0, 1.0])


def beside(distance: float) -> Scene:
    """Half of a can, as one camera sees it, and a wall beside it."""
    rng = np.random.default_rng(0)
    axis = np.arange(-0.3, 0.3, 0.006)
    ground = np.stack(np.meshgrid(axis, axis, [0.0]), axis=-1).reshape(-1, 3)
    whole = can(diameter=0.05).surface(5000, rng)
    half = whole[whole[:, 1] > 0.0]
    wall = box("wall", (0.3, 0.02, 0.1)).surface(5000, rng) + np.array([0.0, distance, 0.0])
    return Scene({"can": half, "wall": wall, "table": ground}, fixed=["table"], up=UP)


def test_the_hand_opens_as_far_as_there_is_room_beside_its_fingers():
    scene = beside(0.25)
    plain = grasp_candidates("can", scene, tools=[HAND])
    wide = grasp_candidates("can", scene, tools=[HAND], wide=True)
    assert [grasp.pose_tool_to_world.tolist() for grasp in wide] == [
        grasp.pose_tool_to_world.tolist() for grasp in plain
    ]
    across = [k for k, grasp in enumerate(plain) if abs(grasp.pose_tool_to_world[1, 1]) > 0.9]
    assert across and all(plain[k].opening < 0.06 for k in across)
    assert all(wide[k].opening == HAND.max_opening for k in across if wide[k].kind == "pinch")


def test_it_opens_no_further_where_a_neighbour_would_be_met():
    scene = beside(0.07)  # the wall's near side is 35 mm off the can's
    wide = grasp_candidates("can", scene, tools=[HAND], wide=True)
    across = [grasp for grasp in wide if abs(grasp.pose_tool_to_world[1, 1]) > 0.9]
    assert across
    for grasp in across:
        to_tool = np.linalg.inv(grasp.pose_tool_to_world)
        local = scene.clouds["wall"] @ to_tool[:3, :3].T + to_tool[:3, 3]
        for x0, x1, y0, y1, front in HAND.footprints(grasp.opening)[: 2 * len(HAND.finger)]:
            x, y, z = local.T
            assert np.count_nonzero((x > x0) & (x < x1) & (y > y0) & (y < y1) & (z < front)) <= 2
