"""Inverse kinematics: by kernel and twin, and of arms that reach next to no pose exactly."""

import numpy as np
import pytest
from few_joints import written
from scipy.spatial.transform import Rotation

from topple.robots.arm.inverse import TOLERANCES, solve
from topple.robots.catalog import robot
from topple.robots.poses import angle_between
from topple.topology.kernels import compiled


@pytest.mark.parametrize("name", ["scara", "gantry"])
def test_an_arm_of_four_joints_comes_as_near_as_it_can(name, tmp_path):
    arm = robot(written(name, tmp_path))
    pose = arm.tool_pose(np.array([0.1, 0.2, 0.1, 0.3]))[0]
    for tilt, reached in ((0.0, True), (0.03, True), (0.1, False)):
        wanted = pose.copy()
        wanted[:3, :3] = Rotation.from_euler("x", tilt).as_matrix() @ pose[:3, :3]
        (states,) = arm.inverse(wanted)
        assert (len(states) > 0) == reached
        assert arm.reaches(wanted[None, None])[0] == reached
        for at in arm.tool_pose(states) if reached else ():
            assert np.linalg.norm(at[:3, 3] - wanted[:3, 3]) < 1e-4
            assert angle_between(at, wanted) == pytest.approx(tilt, abs=1e-3)


@pytest.mark.skipif(compiled.kernels() is None, reason="no kernels were compiled here")
@pytest.mark.parametrize("name", ["panda", "gantry", "scara"])
def test_kernel_and_twin_solve_from_the_same_starts(name, tmp_path, monkeypatch):
    arm, rng = robot(name if name == "panda" else written(name, tmp_path)), np.random.default_rng(0)
    q, starts = (rng.uniform(arm.lower, arm.upper, (count, len(arm.joints))) for count in (20, 16))
    half = np.eye(4)
    half[:2, :2] *= -1.0  # turned half, where the axis of the error is hard to tell
    targets = np.concatenate([arm.chain.frames(q)[:, -1], arm.chain.frames(starts[:1])[:, -1] @ half])
    found = list[np.ndarray]()
    for path in ("", "numpy"):
        monkeypatch.setenv(compiled.VARIABLE, path)
        states, owners = solve(arm.chain, targets, starts, tool_point=np.array([0.0, 0.0, 0.1]))
        at = arm.chain.frames(states)[:, -1, :3, 3] - targets[owners, :3, 3]
        assert len(states) > 0
        if name == "panda":
            assert np.linalg.norm(at, axis=1).max() < TOLERANCES.position
        found.append(np.bincount(owners, minlength=len(targets)))
    assert np.abs(found[0] - found[1]).sum() <= 0.01 * found[1].sum()  # one may turn where rounding decides
