import numpy as np
import pytest
from on_table import BASE

from topple.planner.motion.collision import Checker
from topple.planner.motion.planner import Motion
from topple.planner.motion.shortcut import densely
from topple.planner.motion.upright import Upright, plan_upright
from topple.planner.planning.plan import plan
from topple.planner.transfer.limits import TRANSFER_LIMITS
from topple.planner.transfer.transfer import Transfer, TransferRequest, plan_transfer
from topple.robots.arm.arm import Station
from topple.robots.catalog import robot
from topple.robots.shapes.boxes import box, can
from topple.robots.shapes.fruit import plum
from topple.robots.shapes.tableware import mug
from topple.topology.base.arrays import FloatArray
from topple.topology.base.errors import UnknownObject
from topple.topology.scene.scene import Scene

ARM = robot("panda")
UP = np.array([0.0, 0.0, 1.0])


def kitchen(**more: FloatArray) -> Scene:
    """A can on a table, and what else is given."""
    axis = np.arange(-0.45, 0.45, 0.008)
    x, y = np.meshgrid(axis, axis)
    table = np.column_stack([x.ravel(), y.ravel(), np.zeros(x.size)])
    full = can().surface(3000, np.random.default_rng(0)) + np.array([0.0, -0.25, 0.0])
    return Scene({"table": table, "can": full, **more}, fixed=["table"], up=UP)


def tilts(transfer: Transfer) -> FloatArray:
    """How far the carried object is tilted at every sample of its way [rad]."""
    found: list[FloatArray] = []
    hold = np.linalg.inv(transfer.grasp.pose_tool_to_world)[:3, :3]
    for segment in transfer.segments:
        if segment.holding is not None and segment.motion is not None:
            turned = ARM.tool_pose(segment.motion.positions, transfer.grasp.tool)[:, :3, :3] @ hold @ UP
            found.append(np.arccos(np.clip(turned @ UP, -1.0, 1.0)))
    return np.concatenate(found)


def test_what_is_marked_stays_within_the_tilt_all_along():
    wall = box("wall", (0.3, 0.04, 0.3)).surface(4000, np.random.default_rng(1))
    found = plan_transfer(
        "can", kitchen(wall=wall), Station(ARM, BASE, np.array(ARM.home)), TransferRequest(upright=True)
    )
    assert isinstance(found, Transfer), str(found)
    assert found.upright
    assert tilts(found).max() <= TRANSFER_LIMITS.tilt
    assert all(s.certified for s in found.segments if s.motion)


def test_around_a_wall_the_tilt_holds_and_nothing_touches():
    wall = [np.array([[x, y, z] for x in (0.25, 0.9) for y in (-0.02, 0.02) for z in (0.0, 0.45)])]
    checker = Checker(ARM, np.eye(4), {"wall": wall})
    down = np.array([[1.0, 0, 0, 0.5], [0, -1, 0, -0.25], [0, 0, -1, 0.25], [0, 0, 0, 1]])
    start = ARM.inverse(down)[0][0]
    down[1, 3] = 0.25
    goals = ARM.inverse(down)[0][:8]
    found = plan_upright(checker, start, goals, Upright("fingers", UP, 0.15), seed=0)
    assert isinstance(found, Motion), found.reason
    assert found.certificate is not None
    assert found.certificate.proven
    between = densely(found.path, 0.002)
    tool = ARM.tool_pose(between)[:, :3, 2]
    assert np.arccos(np.clip(-tool @ UP, -1.0, 1.0)).max() <= 0.15
    assert checker.free(between).all()


@pytest.mark.slow
def test_what_lies_in_a_marked_container_goes_with_it():
    rng = np.random.default_rng(0)
    cup = mug().surface(3000, rng) + np.array([0.05, 0.1, 0.0])
    fruit = plum(diameter=0.04).surface(1000, rng) + np.array([0.05, 0.1, 0.01])
    scene = kitchen(mug=cup, plum=fruit)
    found = plan(scene, "free mug", ARM, pose_base_to_world=BASE, upright=["mug"])
    assert [step.object for step in found.steps] == ["mug"]
    step = found.steps[0]
    assert step.upright
    assert [held.object for held in step.attachments] == ["mug", "plum"]
    checked = found.verify(scene)
    assert checked["tilt of what is kept upright"] <= 0.0
    assert checked["collisions (python-fcl)"] <= 0.0
    assert checked["attachment against grasp"] <= 0.0
    assert checked.ok


def test_marks_of_what_is_not_there_are_refused():
    with pytest.raises(UnknownObject, match="teapot"):
        plan(kitchen(), "free can", ARM, pose_base_to_world=BASE, upright=["teapot"])
