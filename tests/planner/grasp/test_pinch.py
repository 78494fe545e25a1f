import numpy as np
import pytest
from on_table import table

from topple.planner.grasp.frames import frames
from topple.planner.grasp.grasp import Grasp
from topple.planner.grasp.jaw import hand_shape
from topple.planner.grasp.pads import extents, pack
from topple.planner.grasp.pinch import pinches
from topple.planner.grasp.shape import Sought
from topple.planner.grasp.surface import Surface
from topple.planner.grasp.tolerances import GRASP_TOLERANCES, OWN_MARGIN
from topple.robots.catalog import robot
from topple.robots.shapes.boxes import box, can
from topple.robots.shapes.tableware import bowl, mug, plate
from topple.robots.world.bodies import Body
from topple.topology.scene.scene import Scene
from topple.topology.situation.situation import Situation

HAND = hand_shape(robot("panda"))
UP = np.array([0.0, 0.0, 1.0])


def clouds(**bodies: tuple[Body, tuple[float, float, float]]) -> Scene:
    rng = np.random.default_rng(3)
    found = {"table": table(0.3, 0.006)}
    for name, (body, place) in bodies.items():
        points = body.surface(5000, rng) + np.array(place)
        found[name] = points + rng.normal(0.0, 0.0005, points.shape)
    return Scene(found, fixed=["table"], up=UP)


PLATE, BOWL = plate("thing"), bowl("thing")


def searched(scene: Scene, name: str) -> tuple[Surface, np.ndarray, list[list[Grasp]]]:
    sought = Sought.of(name, Situation(scene))
    directions = frames(sought.surface, UP, GRASP_TOLERANCES.tilts, count=8)
    return sought.surface, sought.around.points, [pinches(one, sought, HAND) for one in directions]


@pytest.mark.parametrize("name", ["can", "bowl"])
def test_every_prism_of_the_hand_is_clear_of_every_point_looked_at_one_by_one(name):
    scene = clouds(
        can=(can(), (0.0, 0.0, 0.0)),
        wall=(box("wall", (0.2, 0.03, 0.1)), (0.0, 0.08, 0.0)),
        bowl=(bowl(), (0.0, -0.16, 0.0)),
    )
    surface, others, found = searched(scene, name)
    assert sum(map(len, found)) > 10
    for pinch in [pinch for at_point in found for pinch in at_point]:
        to_tool = np.linalg.inv(pinch.pose_tool_to_world)
        for cloud, margin in ((surface.points, OWN_MARGIN), (others, GRASP_TOLERANCES.under_clearance)):
            local = cloud @ to_tool[:3, :3].T + to_tool[:3, 3]
            for x0, x1, y0, y1, front in HAND.footprints(pinch.opening):
                x, y, z = local.T
                inside = (x > x0 - margin) & (x < x1 + margin) & (y > y0 - margin) & (y < y1 + margin)
                met = np.count_nonzero(inside & (z < front + margin - 1e-9))
                assert met <= GRASP_TOLERANCES.stray_points


@pytest.mark.parametrize("body", [bowl("thing"), mug("thing")], ids=["bowl", "mug"])
def test_hollow_ware_is_taken_by_its_rim_with_one_finger_on_either_side_of_the_wall(body):
    scene = clouds(thing=(body, (0.0, 0.0, 0.0)))
    _, _, found = searched(scene, "thing")
    rims = [pinch for at_point in found for pinch in at_point if pinch.kind == "rim"]
    assert rims
    best = max(rims, key=lambda pinch: sum(pinch.terms.values()))
    outer = np.linalg.norm(scene.clouds["thing"][:, :2], axis=1).max()
    assert 0.4 * outer < np.linalg.norm(best.pose_tool_to_world[:2, 3]) < 1.1 * outer
    assert best.width < 0.04  # of the wall, not of the whole


def test_a_plate_flat_on_a_table_leaves_no_room_for_a_finger_below_its_rim():
    lying, bowls = (searched(clouds(thing=(body, (0.0, 0.0, 0.0))), "thing")[2] for body in (PLATE, BOWL))
    assert any(bowls), "the rim of a bowl has room below it"
    assert len(lying) == len(bowls) > 0
    assert not any(lying)


def test_directions_looked_at_together_give_what_each_gives_alone():
    scene = clouds(can=(can(), (0.0, 0.0, 0.0)), wall=(box("wall", (0.2, 0.03, 0.1)), (0.0, 0.08, 0.0)))
    sought, counts = Sought.of("can", Situation(scene)), list[int]()
    for many in frames(sought.surface, UP, GRASP_TOLERANCES.tilts, count=3):
        together = pinches(many, sought, HAND)
        alone = [
            pinch
            for k in range(len(many.tilts))
            for pinch in pinches(
                type(many)(many.origin, many.rotations[k : k + 1], many.tilts[k : k + 1]),
                sought, HAND,
            )
        ]  # fmt: skip
        assert len(together) == len(alone)
        counts.append(len(together))
        for a, b in zip(together, alone, strict=True):
            assert np.allclose(a.pose_tool_to_world, b.pose_tool_to_world)
            assert a.terms == pytest.approx(b.terms)
    assert sum(counts) > 0


def test_the_extent_between_pads_ends_at_a_gap_a_finger_could_enter():
    y = np.array([[-0.02, 0.0, 0.004, 0.008, 0.03, 0.034]])
    low, high = extents(y, np.ones((1, 6), dtype=bool), GRASP_TOLERANCES)
    assert (low[0], high[0]) == (0.0, 0.008)
    low, high = extents(y, np.array([[True, True, False, False, True, True]]), GRASP_TOLERANCES)
    assert (low[0], high[0]) == (0.0, 0.0)


def test_packed_rows_name_the_columns_that_are_set():
    index, there = pack(np.array([[False, True, True], [False, False, False], [True, False, False]]))
    assert [row[have].tolist() for row, have in zip(index, there, strict=True)] == [[1, 2], [], [0]]


def test_pads_close_on_the_ends_of_a_thing_and_not_where_the_hand_stops_to_look():
    # a mug on its side: longer than the hand opens, its top sinks towards the mouth by a few millimetres
    lying = mug().surface(8000, np.random.default_rng(5)) @ np.array([[0, 0, -1.0], [0, 1, 0], [1, 0, 0]]).T
    lying[:, 2] -= lying[:, 2].min()
    seen = lying[lying[:, 2] > 0.02] + np.random.default_rng(6).normal(0.0, 0.0005, (1, 3))
    surface, _, found = searched(
        Scene({"table": table(0.3, 0.006), "mug": seen}, fixed=["table"], up=UP), "mug"
    )
    pinched = [pinch for at_point in found for pinch in at_point]
    assert pinched, "by its handle or its rim"
    for pinch in pinched:
        to_tool = np.linalg.inv(pinch.pose_tool_to_world)
        local = surface.points @ to_tool[:3, :3].T + to_tool[:3, 3]
        x, y, z = local.T
        beside = (
            (np.abs(x) < HAND.pad_width / 2) & (np.abs(y) > pinch.width / 2 + 0.004) & (z < HAND.tip - 0.001)
        )
        near = beside & (np.abs(y) < pinch.width / 2 + 0.02)
        assert np.count_nonzero(near) <= GRASP_TOLERANCES.stray_points, "it goes on where a pad would be"
