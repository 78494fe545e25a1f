import shutil
from pathlib import Path

import numpy as np
import pybullet
import pytest

from topple.robots.arm.arm import Arm
from topple.robots.arm.gripper import ToolState
from topple.robots.catalog import names, robot
from topple.topology.base.errors import InvalidInput, NotInstalled


def top_down(x: float, y: float, z: float, yaw: float) -> np.ndarray:
    pose = np.diag([1.0, -1.0, -1.0, 1.0])
    c, s = np.cos(yaw), np.sin(yaw)
    pose[:3, :3] = np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]]) @ pose[:3, :3]
    pose[:3, 3] = x, y, z
    return pose


def random_states(arm: Arm, count: int, seed: int = 0) -> np.ndarray:
    return np.random.default_rng(seed).uniform(arm.lower, arm.upper, (count, len(arm.joints)))


@pytest.mark.parametrize("name", names())
def test_forward_kinematics_agree_with_pybullet(name):
    arm = robot(name)
    state = ToolState(0.6 * arm.open_hand.opening, 0.03)
    client = pybullet.connect(pybullet.DIRECT)
    try:
        body = pybullet.loadURDF(str(arm.urdf), useFixedBase=True, physicsClientId=client)
        infos = [
            pybullet.getJointInfo(body, j, physicsClientId=client)
            for j in range(pybullet.getNumJoints(body, physicsClientId=client))
        ]
        assert len(infos) >= len(arm.joints)
        for q in (arm.home, *random_states(arm, 20)):
            poses = arm.forward(q, state)[0]
            for tool in arm.tools.values():  # of a cup that slides the frame is where it is out
                if tool.link in arm.links and tool.name == "fingers":
                    frame = poses[arm.links.index(tool.link)] @ tool.pose_tool_to_link
                    assert np.abs(frame - arm.tool_pose(q, tool.name)[0]).max() < 1e-6
            values = arm.joint_values(q, state)
            for info in infos:
                value = values.get(info[1].decode(), 0.0)
                pybullet.resetJointState(body, info[0], value, physicsClientId=client)
            for info in infos:
                found = pybullet.getLinkState(
                    body, info[0], computeForwardKinematics=True, physicsClientId=client
                )
                pose = poses[arm.links.index(info[12].decode())]
                rotation = np.reshape(pybullet.getMatrixFromQuaternion(found[5]), (3, 3))
                assert np.abs(pose[:3, 3] - found[4]).max() < 1e-6
                assert np.abs(pose[:3, :3] - rotation).max() < 1e-6
    finally:
        pybullet.disconnect(client)


def test_poses_are_the_frames_with_the_states_last():
    arm = robot("panda")
    q = random_states(arm, 50)
    poses = arm.chain.poses(q)
    assert np.array_equal(arm.chain.frames(q)[:, :, :3], poses.transpose(3, 0, 1, 2))
    assert np.abs(poses[-1, :, 3].T - arm.chain.frames(q)[:, -1, :3, 3]).max() == 0


def test_jacobian_is_the_derivative_of_the_tool_pose():
    arm = robot("panda")
    q = random_states(arm, 1)
    frames = arm.chain.frames(q)
    jacobian = arm.chain.jacobian(frames, frames[:, -1, :3, 3])[0]
    step = 1e-6
    moved = arm.chain.frames(q + step * np.eye(7))[:, -1]
    assert np.abs((moved[:, :3, 3] - frames[0, -1, :3, 3]).T / step - jacobian[:3]).max() < 1e-5


@pytest.mark.parametrize("name", names())
def test_inverse_solutions_reach_the_pose_within_limits(name):
    arm = robot(name)
    assert arm.tools
    for tool in arm.tools:
        targets = arm.tool_pose(random_states(arm, 10), tool)
        for target, solutions in zip(targets, arm.inverse(targets, tool), strict=True):
            assert len(solutions)
            assert ((solutions >= arm.lower) & (solutions <= arm.upper)).all()
            assert np.abs(arm.tool_pose(solutions, tool) - target).max() < 5e-6


@pytest.mark.parametrize("name", names())
def test_nearly_all_reachable_top_down_targets_are_solved(name):
    arm = robot(name)
    rng = np.random.default_rng(1)
    radius, turn = rng.uniform(0.35, 0.6, 60), rng.uniform(-1.5, 1.5, 60)
    targets = np.array(
        [
            top_down(r * np.cos(t), r * np.sin(t), z, yaw)
            for r, t, z, yaw in zip(
                radius, turn, rng.uniform(0.02, 0.35, 60), rng.uniform(-3, 3, 60), strict=True
            )
        ]
    )
    tool = next(iter(arm.tools))
    many = [len(found) > 0 for found in arm.inverse(targets, tool, seeds=128, rng=np.random.default_rng(7))]
    some = [len(found) > 0 for found in arm.inverse(targets, tool)]
    assert sum(many) > 30, "hardly anything is reachable: the tool frame is wrong"
    assert sum(np.logical_and(some, many)) >= 0.995 * sum(many)


def test_inverse_solutions_differ_and_the_nearest_comes_first():
    arm = robot("panda")
    near = np.array([0.3, -0.4, 0.1, -2.2, 0.2, 1.9, 0.5])
    (found,) = arm.inverse(arm.tool_pose(near), near=near)
    assert len(found) > 5
    assert np.abs(found[0] - near).max() < 1e-4
    distances = np.abs(found[:, None] - found[None]).max(axis=2) + np.eye(len(found))
    assert distances.min() > 0.1


def test_inverse_is_the_same_for_the_same_seed():
    arm = robot("panda")
    target = top_down(0.5, 0.1, 0.2, 0.3)
    first, second = (arm.inverse(target, rng=np.random.default_rng(3))[0] for _ in range(2))
    assert np.array_equal(first, second)


def test_out_of_reach_has_no_solution():
    arm = robot("panda")
    assert arm.inverse(top_down(2.0, 0.0, 0.2, 0.0))[0].shape == (0, 7)


def test_self_pairs_leave_out_neighbours_and_what_never_meets():
    arm = robot("panda")
    pairs = {(arm.links[i], arm.links[j]) for i, j in arm.self_pairs}
    assert len(pairs) == 22
    assert ("panda_link0", "panda_hand") in pairs
    assert ("panda_link1", "panda_link2") not in pairs
    assert ("panda_hand", "panda_leftfinger") not in pairs


def test_asking_for_a_tool_it_lacks_names_those_it_has():
    with pytest.raises(InvalidInput, match="panda has no tool 'suction'; it has fingers"):
        robot("panda").tool_pose(np.zeros(7), "suction")


URDF = """<robot name="two"><link name="base"/>
<link name="arm"><collision><geometry><box size="0.1 0.1 0.5"/></geometry></collision></link>
<link name="tip">{collision}</link>
<joint name="turn" type="revolute"><parent link="base"/><child link="arm"/><axis xyz="0 0 1"/>{limit}</joint>
<joint name="slide" type="{kind}"><parent link="arm"/><child link="tip"/><origin xyz="0 0 0.5"/>
<axis xyz="1 0 0"/><limit lower="0" upper="0.2" velocity="1" effort="1"/></joint></robot>"""
LIMIT = '<limit lower="-1" upper="1" velocity="2" effort="1"/>'


def written(folder: Path, **changes: str) -> Path:
    path = folder / "two.urdf"
    path.write_text(URDF.format(**({"collision": "", "limit": LIMIT, "kind": "prismatic"} | changes)))
    return path


def test_any_urdf_makes_an_arm(tmp_path):
    arm = Arm.from_urdf(written(tmp_path), "tip")
    assert arm.joints == ("turn", "slide")
    pose = arm.forward(np.array([np.pi / 2, 0.2]))[0, arm.links.index("tip")]
    assert np.allclose(pose[:3, 3], [0.0, 0.2, 0.5])


@pytest.mark.parametrize(
    ("changes", "tool_frame", "message"),
    [
        ({"limit": ""}, "tip", "joints without limits: turn"),
        ({"limit": '<limit lower="-1" upper="1"/>'}, "tip", "without a velocity limit: turn"),
        ({}, "arm", "nothing drives the joints slide"),
        ({}, "hand", "no link 'hand'; it has base, arm, tip"),
        ({"kind": "floating"}, "tip", "joint 'slide' is 'floating', which cannot be driven"),
        (
            {"collision": '<collision><geometry><mesh filename="no.stl"/></geometry></collision>'},
            "tip",
            "missing or unreadable collision meshes: no.stl",
        ),
    ],
)
def test_a_urdf_that_lacks_something_is_refused_by_name(tmp_path, changes, tool_frame, message):
    with pytest.raises(InvalidInput, match=message):
        Arm.from_urdf(written(tmp_path, **changes), tool_frame)


def test_what_is_no_urdf_is_refused(tmp_path):
    path = tmp_path / "broken.urdf"
    path.write_text("<robot")
    with pytest.raises(InvalidInput, match="not XML"):
        Arm.from_urdf(path, "tip")
    with pytest.raises(InvalidInput, match="cannot be read"):
        Arm.from_urdf(tmp_path / "absent.urdf", "tip")


def test_the_panda_is_read_from_robosuite_where_pybullet_is_missing(monkeypatch, tmp_path):
    import topple.robots.catalog as catalog
    from topple.robots.catalog import data

    there = data.panda_file()

    def missing() -> Path:
        raise NotInstalled("this arm's model comes with PyBullet", "sim")

    class Robosuite:
        def locate_file(self, path: str) -> Path:
            return tmp_path / path

    monkeypatch.setattr(data, "data_path", missing)
    monkeypatch.setattr(data, "distribution", lambda name: {"robosuite": Robosuite()}[name])
    with pytest.raises(NotInstalled):  # an older robosuite, without the file
        catalog.panda_suction()
    copied = Path(shutil.copytree(there.parent, (tmp_path / data.ROBOSUITE[1]).parent)) / there.name
    copied.rename(tmp_path / data.ROBOSUITE[1])
    arm = catalog.panda_suction()
    assert {"fingers", "suction"} == set(arm.tools)
    assert str(tmp_path) in arm.urdf.read_text()
