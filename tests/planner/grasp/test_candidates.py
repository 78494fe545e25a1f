import numpy as np
import pytest
from on_table import table

from topple.planner.grasp import Grasp, grasp_candidates
from topple.planner.grasp.jaw import hand_shape
from topple.planner.grasp.surroundings import Dropped
from topple.robots.arm.cup import SuctionCup
from topple.robots.catalog import robot
from topple.robots.shapes.boxes import box, can
from topple.robots.shapes.cutlery import spoon
from topple.robots.shapes.tableware import plate
from topple.robots.world.bodies import Body
from topple.topology.base.errors import InvalidInput, UnknownObject
from topple.topology.scene.scene import Scene

ARM, PANDA = robot("panda-suction"), robot("panda")
VIEWS = [[0.5, 0.5, 0.7], [-0.5, 0.5, 0.7], [0.0, -0.6, 0.7]]


def seen(body: Body, place: tuple[float, float, float] = (0.0, 0.0, 0.0), noise: float = 0.001) -> np.ndarray:
    rng = np.random.default_rng(0)
    points = body.surface(6000, rng) + np.array(place)
    return points + rng.normal(0.0, noise, points.shape)


def on_table(**clouds: np.ndarray) -> Scene:
    return Scene({"table": table(0.4, 0.006), **clouds}, fixed=["table"], up=[0, 0, 1], viewpoints=VIEWS)


def tips(grasp: Grasp) -> np.ndarray:
    return grasp.pose_tool_to_world[:3, 3] + hand_shape(ARM).tip * grasp.approach


def test_a_can_is_pinched_across_its_diameter():
    best = grasp_candidates("can", on_table(can=seen(can())), robot("panda"))[0]
    assert best.kind == "pinch"
    assert 0.062 < best.width < 0.072
    assert np.linalg.norm(best.pose_tool_to_world[:2, 3]) < 0.01
    assert best.opening <= hand_shape(ARM).max_opening


def test_where_a_cup_is_sure_to_hold_no_pinch_is_looked_for():
    grasps = grasp_candidates("can", on_table(can=seen(can())), ARM)
    assert {grasp.kind for grasp in grasps} == {"suction"}
    assert np.allclose(grasps[0].pose_tool_to_world[:3, 3], grasps[1].pose_tool_to_world[:3, 3])


def test_a_spoon_in_the_air_is_pinched_across_its_handle_near_its_middle():
    cloud = seen(spoon(), (0.0, 0.0, 0.03))
    grasps = grasp_candidates("spoon", on_table(spoon=cloud), ARM)
    best = grasps[0]
    assert best.kind == "pinch"
    assert best.width < 0.03
    assert abs(best.pose_tool_to_world[0, 1]) > 0.9 or abs(best.pose_tool_to_world[1, 1]) > 0.9
    assert np.linalg.norm(best.pose_tool_to_world[:2, 3] - cloud.mean(axis=0)[:2]) < 0.05


def test_fingers_never_go_below_the_table():
    found = grasp_candidates("spoon", on_table(spoon=seen(spoon(), (0.0, 0.0, 0.03))), ARM)
    pinching = [grasp for grasp in found if grasp.tool == "fingers"]
    assert len(pinching) > 5
    assert min(tips(grasp)[2] for grasp in pinching) > 0.0


def test_a_plate_is_taken_by_suction_at_its_middle():
    best = grasp_candidates("plate", on_table(plate=seen(plate())), ARM)[0]
    assert best.kind == "suction"
    assert np.linalg.norm(best.pose_tool_to_world[:2, 3]) < 0.03
    assert best.approach[2] < -0.98


def sealed_at(cloud: np.ndarray) -> list[float]:
    """How far from the middle of a cloud a cup would take it [m]."""
    found = grasp_candidates("plate", on_table(plate=cloud), ARM)
    return [float(np.linalg.norm(g.pose_tool_to_world[:2, 3])) for g in found if g.kind == "suction"]


def test_no_cup_is_put_over_a_bump_that_its_lip_does_not_bridge():
    cloud = seen(plate())
    radius = np.linalg.norm(cloud[:, :2], axis=1)
    assert min(sealed_at(cloud)) < 0.01
    high, low = (cloud + np.outer(radius < 0.006, [0.0, 0.0, bump]) for bump in (0.005, 0.001))
    lip = ARM.tools["suction"].gripper
    assert isinstance(lip, SuctionCup)
    assert min(sealed_at(high), default=np.inf) > lip.radius
    assert min(sealed_at(low)) < 0.01


def test_no_cup_is_put_on_waves_that_its_lip_does_not_bridge():
    cloud = seen(plate())
    waves = np.zeros_like(cloud)
    waves[:, 2] = 0.005 * np.sin(2 * np.pi * cloud[:, 0] / 0.03) * (cloud[:, 2] > 0.004)
    assert sealed_at(cloud)
    assert not sealed_at(cloud + waves)


@pytest.mark.slow
def test_no_suction_where_something_lies_on_the_patch():
    free = grasp_candidates("plate", on_table(plate=seen(plate())), ARM)
    covered = on_table(plate=seen(plate()), can=seen(can(), (0.0, 0.0, 0.008)))
    taken = grasp_candidates("plate", covered, ARM)
    middle, beside = (
        [float(np.linalg.norm(g.pose_tool_to_world[:2, 3])) for g in found if g.kind == "suction"]
        for found in (free, taken)
    )
    assert min(middle) < 0.03, "where nothing lies on it, it is taken by its middle"
    assert all(away > 0.04 for away in beside)


def narrow(grasp: Grasp) -> bool:
    return grasp.tool == "fingers" and grasp.opening < 0.06


@pytest.mark.slow
def test_walls_on_both_sides_leave_only_grasps_that_pass_between_them():
    wide = box("a", (0.20, 0.04, 0.12))
    scene = on_table(
        bar=seen(box("bar", (0.20, 0.02, 0.05))),
        left=seen(wide, (0.0, 0.036, 0.0)),
        right=seen(wide, (0.0, -0.036, 0.0)),
    )
    free = on_table(bar=scene.clouds["bar"])
    assert any(narrow(grasp) for grasp in grasp_candidates("bar", free, PANDA))
    dropped = Dropped()
    assert not any(narrow(grasp) for grasp in grasp_candidates("bar", scene, PANDA, dropped=dropped))
    assert {"left", "right"} <= set(dropped.barring)


def test_a_thing_wider_than_the_hand_is_not_pinched():
    scene = on_table(block=seen(box("block", (0.12, 0.12, 0.12))))
    assert {grasp.kind for grasp in grasp_candidates("block", scene, ARM)} == {"suction"}
    assert grasp_candidates("block", scene, PANDA) == []
    assert grasp_candidates("block", on_table(block=seen(box("block", (0.05, 0.05, 0.12)))), PANDA)


def test_candidates_are_best_first_and_the_same_every_time():
    scene = on_table(can=seen(can()))
    first, again = (grasp_candidates("can", scene, ARM) for _ in range(2))
    scores = [grasp.score for grasp in first]
    assert len(scores) == len(again) > 1
    assert scores == sorted(scores, reverse=True)
    assert all(
        np.array_equal(a.pose_tool_to_world, b.pose_tool_to_world) for a, b in zip(first, again, strict=True)
    )


def test_grasps_move_with_the_scene():
    a = grasp_candidates("can", on_table(can=seen(can())), ARM)[0]
    b = grasp_candidates("can", on_table(can=seen(can(), (0.1, -0.05, 0.0))), ARM)[0]
    assert a.kind == b.kind
    moved = b.pose_tool_to_world[:3, 3] - a.pose_tool_to_world[:3, 3]
    assert np.linalg.norm(moved - [0.1, -0.05, 0.0]) < 0.01


def test_unknown_names_and_unknown_up_are_refused():
    with pytest.raises(UnknownObject, match="cup"):
        grasp_candidates("cup", on_table(can=seen(can())), ARM)
    with pytest.raises(InvalidInput, match="up"):
        grasp_candidates("can", Scene({"can": seen(can())}), ARM)


def test_a_pose_that_is_no_rotation_is_refused():
    with pytest.raises(InvalidInput, match="rotation"):
        Grasp("can", "pinch", np.diag([2.0, 1.0, 1.0, 1.0]), 0.05, 0.06, 0.5)


def test_half_a_turn_twice_is_the_same_grasp():
    grasp = grasp_candidates("can", on_table(can=seen(can())), ARM)[0]
    assert np.allclose(grasp.turn().turn().pose_tool_to_world, grasp.pose_tool_to_world)


@pytest.mark.slow
def test_what_is_left_out_says_why_and_who_leaves_no_room():
    high = box("wall", (0.20, 0.04, 0.12))
    scene = on_table(
        block=seen(box("block", (0.05, 0.05, 0.03))),
        left=seen(high, (0.0, 0.05, 0.0)),
        right=seen(high, (0.0, -0.05, 0.0)),
    )
    dropped = Dropped()
    assert grasp_candidates("block", scene, robot("panda"), dropped=dropped) == []
    assert {"left", "right"} <= set(dropped.barring)
    for name in ("left", "right"):
        assert dropped.reasons[f"no room for the fingers beside {name}"] > 0
    wide = Dropped()
    assert (
        grasp_candidates("box", on_table(box=seen(box("box", (0.2, 0.2, 0.1)))), robot("panda"), dropped=wide)
        == []
    )
    (words,) = [reason for reason in wide.reasons if reason.startswith("wider than the hand opens: ")]
    assert words.endswith("mm at the least and 8 mm to spare, of 80 mm")
    assert not wide.barring
