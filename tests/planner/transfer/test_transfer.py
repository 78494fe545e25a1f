from dataclasses import replace

import numpy as np
import pytest
from moving import at
from on_table import BASE, on_table

from topple.planner.placement.base import NoBase, choose_base
from topple.planner.transfer.handling import Handling
from topple.planner.transfer.prediction import after
from topple.planner.transfer.segments import SegmentKind, no_faster_than
from topple.planner.transfer.transfer import Transfer, TransferFailure, TransferRequest, plan_transfer
from topple.robots.arm.arm import Station
from topple.robots.catalog import robot
from topple.robots.shapes.boxes import box, can
from topple.topology.base.errors import UnknownObject
from topple.topology.relations.relate import relate
from topple.topology.scene.scene import Scene
from topple.topology.situation.situation import Situation
from topple.topology.sixim.table import Relation

ARM = robot("panda-suction")
HOME = Station(ARM, BASE, np.array(ARM.home))


def scene() -> Scene:
    return on_table((can(), (0.0, 0.0, 0.0)), (box("box", (0.06, 0.1, 0.12)), (0.0, 0.2, 0.0)))


@pytest.fixture(scope="module")
def transfer() -> Transfer:
    found = plan_transfer("can", scene(), HOME)
    assert isinstance(found, Transfer), str(found)
    return found


def test_segments_come_in_order_and_join(transfer):
    assert [segment.kind for segment in transfer.segments] == list(SegmentKind)
    q = np.array(ARM.home)
    for segment in transfer.segments:
        if segment.motion is not None:
            assert np.abs(segment.motion.positions[0] - q).max() < 1e-6
            q = segment.motion.positions[-1]
    assert np.allclose(q, transfer.q_end)


@pytest.mark.slow
def test_a_tool_that_failed_twice_gives_way_to_the_other():
    first = plan_transfer("can", scene(), HOME)
    assert isinstance(first, Transfer)
    assert first.grasp.tool == "suction"
    again = [plan_transfer("can", scene(), HOME, TransferRequest(avoid=[first.grasp] * n)) for n in (1, 2)]
    assert [found.grasp.tool for found in again if isinstance(found, Transfer)] == ["suction", "fingers"]


def test_the_hand_is_at_the_grasp_when_it_closes(transfer):
    approach = transfer.segments[1].motion
    assert approach is not None
    reached = BASE @ ARM.tool_pose(approach.positions[-1], transfer.grasp.tool)[0]
    assert np.allclose(reached[:3, 3], transfer.grasp.pose_tool_to_world[:3, 3], atol=1e-3)


def test_the_lift_goes_straight_up_and_slowly(transfer):
    lift = transfer.segments[3].motion
    assert lift is not None
    way = ARM.tool_pose(lift.positions, transfer.grasp.tool)[:, :3, 3]
    assert way[-1, 2] - way[0, 2] == pytest.approx(0.10, abs=2e-3)
    assert np.abs(way[:, :2] - way[0, :2]).max() < 2e-3
    assert (way[-1, 2] - way[0, 2]) / lift.times[-1] <= 0.081


def test_the_object_is_held_from_the_grasp_to_the_place(transfer):
    held = [segment.kind for segment in transfer.segments if segment.holding == "can"]
    assert held == ["grasp", "lift", "transfer", "place"]


def test_the_tool_ends_where_the_placement_takes_it(transfer):
    place = transfer.segments[5].motion
    assert place is not None
    reached = BASE @ ARM.tool_pose(place.positions[-1], transfer.grasp.tool)[0]
    wanted = transfer.placement.pose_before_to_after @ transfer.grasp.pose_tool_to_world
    assert np.allclose(reached, wanted, atol=2e-3)


def test_carried_motions_stay_off_everything(transfer):
    handling = Handling("can", Situation(scene()), HOME)
    carry = transfer.segments[4].motion
    assert carry is not None
    assert handling.checker(SegmentKind.TRANSFER, transfer.grasp).free(carry.positions[::5]).all()


def test_the_predicted_scene_has_the_object_on_the_table(transfer):
    cloud = after(Situation(scene()), transfer).scene.clouds["can"]
    assert cloud[:, 2].min() == pytest.approx(0.0, abs=3e-3)


def test_the_same_seed_gives_the_same_transfer(transfer):
    again = plan_transfer("can", scene(), HOME)
    assert isinstance(again, Transfer)
    assert np.array_equal(again.q_end, transfer.q_end)


def test_out_of_reach_is_a_failure_that_says_so():
    far = at(-3.0, 0.0, 0.0)
    found = plan_transfer("can", scene(), Station(ARM, far, np.array(ARM.home)))
    assert isinstance(found, TransferFailure)
    assert "reach" in str(found)


def test_no_grasps_is_a_failure_that_says_so():
    found = plan_transfer("can", scene(), HOME, TransferRequest(grasps=[]))
    assert isinstance(found, TransferFailure)
    assert "no grasp" in str(found)


def test_an_unknown_object_is_named():
    with pytest.raises(UnknownObject, match="cup"):
        plan_transfer("cup", scene(), HOME)


def test_stretching_keeps_the_path(transfer):
    motion = transfer.segments[4].motion
    assert motion is not None
    slow = no_faster_than(motion, 10.0, 1.0)
    assert slow.times[-1] == pytest.approx(max(10.0, float(motion.times[-1])))
    assert np.array_equal(slow.positions, motion.positions)


def test_the_base_is_chosen_off_the_objects_and_within_reach():
    now = scene()
    pose = choose_base(now, ARM)
    gaps = [np.linalg.norm(now.clouds[name][:, :2] - pose[:2, 3], axis=1).min() for name in now.movable]
    assert min(gaps) > 0.14
    assert max(gaps) < 0.9
    assert np.linalg.det(pose[:3, :3]) == pytest.approx(1.0)


def test_no_base_reaches_what_is_too_high():
    now = scene()
    high = {name: cloud + np.array([0.0, 0.0, 5.0 * (name != "table")]) for name, cloud in now.clouds.items()}
    with pytest.raises(NoBase, match="--base"):
        choose_base(Scene(high, fixed=["table"], up=[0, 0, 1]), ARM)


def test_what_was_put_down_is_predicted_to_rest_on_its_unseen_underside(transfer):
    whole = scene()
    shell = whole.clouds["can"][whole.clouds["can"][:, 2] > 0.012]
    seen = whole.with_cloud("can", shell)
    placement = replace(transfer.placement, pose_before_to_after=np.eye(4), drop=0.0)
    then = after(Situation(seen), replace(transfer, placement=placement)).scene
    assert then.clouds["can"][:, 2].min() == pytest.approx(0.0, abs=0.003)
    assert relate(then).between("table", "can").relation is Relation.TOUCH
