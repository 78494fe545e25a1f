import numpy as np
import pytest
from on_table import BASE, table

from topple.planner.errors import NoSafePlan
from topple.planner.failure import STEPS, FailureLog, TransferFailure
from topple.planner.planning.plan import plan
from topple.planner.transfer.transfer import TransferRequest, plan_transfer
from topple.robots.arm.arm import Station
from topple.robots.catalog import robot
from topple.robots.shapes.boxes import box, can
from topple.topology.base.errors import InvalidInput
from topple.topology.scene.scene import Scene

ARM = robot("panda")
HOME = Station(ARM, BASE, np.array(ARM.home))


def hemmed_in() -> Scene:
    """A low block in a narrow lane between two tall boxes: no hand comes in between."""
    rng = np.random.default_rng(0)
    block = box("block", (0.05, 0.05, 0.03)).surface(2000, rng)
    tall = box("tall", (0.16, 0.06, 0.2)).surface(3000, rng)
    beside = {"left": tall + np.array([0.0, 0.062, 0.0]), "right": tall - np.array([0.0, 0.062, 0.0])}
    return Scene({"table": table(), "block": block, **beside}, fixed=["table"], up=[0, 0, 1])


@pytest.mark.slow
def test_what_bars_the_hand_is_taken_away_first_and_the_reason_says_so():
    found = plan(hemmed_in(), "free block", ARM, pose_base_to_world=BASE)
    assert found.order[-1] == "block"
    assert set(found.order[:-1]) & {"left", "right"}
    assert found.steps[0].action == "remove"
    assert "in the way to block" in found.steps[0].reason
    assert not found.verify(hemmed_in()).failed


def test_a_failure_says_step_check_configuration_and_who_bars():
    scene = hemmed_in()
    lone = scene.without("left").without("right")
    from topple.planner.grasp.candidates import grasp_candidates

    grasps = grasp_candidates("block", lone, ARM)  # found as if nothing stood beside
    found = plan_transfer("block", scene, HOME, TransferRequest(grasps=grasps))
    assert isinstance(found, TransferFailure)
    assert found.blocking in ("left", "right")
    assert set(found.barring) <= {"left", "right", "table"}
    assert found.furthest is not None
    assert found.furthest.step in STEPS
    assert found.furthest.check == "collision"
    assert found.furthest.q is not None
    assert found.furthest.q.shape == (7,)
    assert found.furthest.pair is not None
    assert "in the way" in str(found)


def test_where_no_grasp_has_room_the_failure_says_beside_what():
    found = plan_transfer("block", hemmed_in(), HOME)
    assert isinstance(found, TransferFailure)
    assert found.furthest is not None
    assert (found.furthest.step, found.furthest.check) == ("grasp", "room")
    assert {found.blocking} < {"left", "right"} == set(found.barring)
    assert "no room for the fingers beside left" in found.reasons
    assert str(found).endswith(f"; in the way: {found.blocking}")


def test_the_setback_that_got_furthest_is_kept():
    tally = FailureLog(frozenset({"cup"}))
    tally.note("lift", "collision", "lift: hand meets cup", np.zeros(7), ("hand", "cup"))
    tally.note("grasp", "reach", "grasp out of reach")
    failure = tally.failure("can")
    assert failure.furthest is not None
    assert failure.furthest.step == "lift"
    assert failure.barring == {"cup": 1}
    assert failure.reasons == {"lift: hand meets cup": 1, "grasp out of reach": 1}


def test_no_plan_carries_the_failures_as_objects():
    far = BASE.copy()
    far[0, 3] = -3.0
    with pytest.raises(NoSafePlan) as caught:
        plan(hemmed_in(), "free left", ARM, pose_base_to_world=far)
    assert {failure.object for failure in caught.value.failures} == {"left"}


def test_a_start_in_collision_says_with_what():
    scene = hemmed_in()
    wall = box("wall", (0.3, 0.3, 0.6)).surface(3000, np.random.default_rng(0)) + np.array([-0.2, 0.0, 0.0])
    with pytest.raises(InvalidInput, match=r"start is in collision: .* deep in wall"):
        plan(scene.with_cloud("wall", wall), "free block", ARM, pose_base_to_world=BASE)


@pytest.mark.parametrize(
    ("q", "words"),
    [(np.zeros(3), "7 joints"), (np.full(7, np.nan), "finite"), (np.full(7, 9.0), "panda_joint1 is 9")],
)
def test_a_start_that_is_no_state_is_refused(q, words):
    with pytest.raises(InvalidInput, match=words):
        plan(hemmed_in(), "free left", ARM, pose_base_to_world=BASE, q_start=q)


def test_a_can_alone_needs_nothing_first():
    scene = hemmed_in().without("left").without("right").without("block")
    scene = scene.with_cloud("can", can().surface(2000, np.random.default_rng(0)))
    found = plan(scene, "free can", ARM, pose_base_to_world=BASE)
    assert [step.reason for step in found.steps] == ["nothing has to go before it"]
    assert found.certified
