"""What gravity asks of joints is what PyBullet's inverse dynamics say, and what lifting the load takes."""

from dataclasses import replace

import numpy as np
import pybullet
import pytest

from topple.robots.arm.torques import gravity_torques, springs, strain
from topple.robots.catalog import names, robot

UP = np.array([0.0, 0.0, 1.0])


def states(name: str, count: int = 20) -> np.ndarray:
    arm = robot(name)
    return np.random.default_rng(0).uniform(arm.lower, arm.upper, (count, len(arm.joints)))


@pytest.mark.parametrize("name", names())
def test_of_the_arm_alone_they_are_those_of_inverse_dynamics(name):
    arm, q = robot(name), states(name)
    client = pybullet.connect(pybullet.DIRECT)
    pybullet.setGravity(0, 0, -9.81, physicsClientId=client)
    body = pybullet.loadURDF(str(arm.urdf), useFixedBase=True, physicsClientId=client)
    count = pybullet.getNumJoints(body, physicsClientId=client)
    infos = [pybullet.getJointInfo(body, index, physicsClientId=client) for index in range(count)]
    moving = [info[1].decode() for info in infos if info[2] != pybullet.JOINT_FIXED]
    found = []
    for state in q:
        values = arm.joint_values(state, arm.open_hand)
        still = [0.0] * len(moving)
        torques = pybullet.calculateInverseDynamics(
            body, [values[joint] for joint in moving], still, still, physicsClientId=client
        )
        told = dict(zip(moving, torques, strict=True))
        found.append([told[joint] for joint in arm.joints])
    pybullet.disconnect(client)
    assert np.allclose(gravity_torques(arm, q, UP, 0.0, np.zeros(3)), found, atol=1e-9)


def test_of_a_load_they_are_the_work_that_raises_it():
    arm, q, mass, centre, tiny = robot("panda"), states("panda"), 2.0, np.array([0.02, -0.03, 0.2]), 1e-6
    tilted = np.array([0.1, -0.2, 0.97]) / np.linalg.norm([0.1, -0.2, 0.97])
    with_it = gravity_torques(arm, q, tilted, mass, centre)
    asked = with_it - gravity_torques(arm, q, tilted, 0.0, centre)
    for joint in range(len(arm.joints)):
        ends = []
        for sign in (-1.0, 1.0):
            moved = q.copy()
            moved[:, joint] += sign * tiny
            frames = arm.chain.frames(moved)[:, -1]
            ends.append((frames[:, :3, :3] @ centre + frames[:, :3, 3]) @ tilted)
        assert np.allclose(asked[:, joint], 9.81 * mass * (ends[1] - ends[0]) / (2 * tiny), atol=1e-5)


def test_the_joint_that_is_asked_most_of_its_limit_is_named():
    arm = robot("xarm6")
    q = states("xarm6", 200)
    light, heavy = strain(arm, q, UP), strain(arm, q, UP, 3.0, (0.0, 0.0, 0.15))
    assert light.share < 1.0 < heavy.share
    assert str(heavy) == f"joint2 takes {heavy.torque:.0f} of 50 N m"
    assert heavy.torque == pytest.approx(heavy.share * 50.0)


def test_a_joint_that_could_not_hold_the_arm_itself_has_springs_and_bears_the_load_alone():
    arm = robot("panda")
    assert springs(arm) == ()
    joints = {
        child: replace(joint, effort=10.0) if joint.name == "panda_joint4" else joint
        for child, joint in arm.model.joints.items()
    }
    sprung = replace(arm, model=replace(arm.model, joints=joints))
    assert springs(sprung) == ("panda_joint4",)
    q = states("panda", 200)
    assert strain(sprung, q, UP).joint != "panda_joint4"
    assert strain(sprung, q, UP, 2.0).joint == "panda_joint4"
    assert strain(sprung, q, UP, 2.0).torque < strain(arm, q, UP, 2.0).torque
