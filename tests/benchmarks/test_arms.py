"""Arms of others, from the files their packages ship: read, tried, planned for and run."""

from importlib.util import find_spec
from pathlib import Path

import pytest

from topple.benchmarks.arms import BEGIN, END, SHIPPED, Shipped, planned
from topple.planner.execution.examine import examine
from topple.topology.errors import NotInstalled

PAGE = (Path(__file__).parents[2] / "docs" / "robots.md").read_text(encoding="utf-8")
ROWS = PAGE[PAGE.index(BEGIN) : PAGE.index(END)].splitlines()[3:]
WORKING = [shipped for shipped in SHIPPED if not any(shipped.name in row and "**no**" in row for row in ROWS)]


def test_the_page_has_every_arm_and_most_work() -> None:
    assert [row.split(" | ")[0].removeprefix("| ") for row in ROWS] == [shipped.name for shipped in SHIPPED]
    assert len(WORKING) >= 6


@pytest.mark.slow
@pytest.mark.parametrize("shipped", WORKING, ids=lambda shipped: shipped.name)
def test_an_arm_is_understood_planned_for_and_takes_the_block(shipped: Shipped) -> None:
    if find_spec("collada") is None:
        pytest.skip("pycollada is not installed: pip install '.[arms]'")
    try:
        arm = shipped.arm()
    except NotInstalled as error:
        pytest.skip(str(error))
    found = examine(arm)
    assert found.solved >= 0.995 * found.poses > 0
    assert found.grasped is not None and found.grasped.success, found.grasped
    assert not planned(found)


def test_the_arm_that_drops_the_block_cannot_carry_itself() -> None:
    """A PR2 rests on springs that its URDF leaves out: gravity asks more of its shoulder than its effort."""
    pybullet = pytest.importorskip("pybullet")
    (shipped,) = [shipped for shipped in SHIPPED if shipped not in WORKING]
    try:
        arm = shipped.arm()
    except NotInstalled as error:
        pytest.skip(str(error))
    client = pybullet.connect(pybullet.DIRECT)
    try:
        pybullet.setGravity(0.0, 0.0, -9.81, physicsClientId=client)
        body = pybullet.loadURDF(str(arm.urdf), useFixedBase=True, physicsClientId=client)
        count = pybullet.getNumJoints(body, physicsClientId=client)
        infos = [pybullet.getJointInfo(body, j, physicsClientId=client) for j in range(count)]
        moving = [info for info in infos if info[2] != pybullet.JOINT_FIXED]
        state = dict(zip(arm.joints, arm.home.tolist(), strict=True))
        values = [state.get(info[1].decode(), 0.0) for info in moving]
        still = [0.0] * len(values)
        torques = pybullet.calculateInverseDynamics(body, values, still, still, physicsClientId=client)
    finally:
        pybullet.disconnect(client)
    short = [
        info[1].decode()
        for info, torque in zip(moving, torques, strict=True)
        if info[1].decode() in state and abs(torque) > info[10]
    ]
    assert short == ["l_shoulder_lift_joint"]
