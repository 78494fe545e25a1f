import json
import math

import numpy as np
import pybullet
import pytest

from topple.benchmarks.motion import checking, planning
from topple.benchmarks.motion_problems import checker_of, clutter, pick, transfer
from topple.benchmarks.one_by_one import OneByOne
from topple.benchmarks.peers import PEERS, answers, python_of
from topple.benchmarks.peers.handover import handed_over
from topple.planner.motion.shortcut import densely
from topple.robots.catalog import robot
from topple.topology.base.errors import ToppleError


def test_the_baseline_checker_gives_the_same_answers():
    arm = robot("panda")
    rng = np.random.default_rng(3)
    checker = checker_of(arm, clutter(rng, 6))
    q = rng.uniform(arm.lower, arm.upper, (500, 7))
    assert np.array_equal(OneByOne(arm, checker.model).all(q), checker.free(q))


def test_no_state_is_disagreed_on():
    _, wrong = checking(robot("panda"), 1000, 0)
    assert wrong.value == 0
    assert wrong.ok


def test_rows_are_complete_and_no_certified_path_touches(monkeypatch):
    monkeypatch.setenv("TOPPLE_PEERS", "nowhere")
    said: list[str] = []
    problems = [transfer(robot("panda"), seed) for seed in (40, 41)]
    rows = planning("transfer", problems, 0, said.append)
    json.dumps([row.to_json() for row in rows])
    by_name = {row.what: row for row in rows}
    assert by_name["transfer: solved and certified"].value == 100
    assert by_name["transfer: paths that touch, every 0.002 rad"].value == 0
    assert by_name["transfer: plan and shortcut, median"].bar == ">= 10x"
    assert said


def test_what_is_handed_over_is_the_same_arm_among_the_same_boxes(tmp_path):
    """PyBullet loads the files and stands where our own kinematics say."""
    arm = robot("panda")
    problem = pick(arm, 50)
    handed_over(tmp_path, [problem], 3, 20.0)
    document = json.loads((tmp_path / "problems.json").read_text())
    client = pybullet.connect(pybullet.DIRECT)
    try:
        body = pybullet.loadURDF(str(tmp_path / "arm.urdf"), useFixedBase=True, physicsClientId=client)
        infos = [
            pybullet.getJointInfo(body, j, physicsClientId=client)
            for j in range(pybullet.getNumJoints(body, physicsClientId=client))
        ]
        joints = {info[1].decode(): info[0] for info in infos}
        for name, value in zip(document["joints"], document["problems"][0]["start"], strict=True):
            pybullet.resetJointState(body, joints[name], value, physicsClientId=client)
        poses = arm.forward(problem.start)[0]
        for info in infos:
            state = pybullet.getLinkState(
                body, info[0], computeForwardKinematics=True, physicsClientId=client
            )
            assert np.abs(poses[arm.links.index(info[12].decode()), :3, 3] - state[4]).max() < 1e-6
    finally:
        pybullet.disconnect(client)
    assert [box["name"] for box in document["problems"][0]["boxes"]] == list(problem.boxes)
    assert len(document["ignored_pairs"]) == math.comb(len(arm.links), 2) - len(arm.self_pairs)


def test_a_peer_that_fails_says_why(tmp_path):
    python = tmp_path / "python"
    python.write_text("#!/bin/sh\necho no such module >&2\nexit 1\n")
    python.chmod(0o755)
    with pytest.raises(ToppleError, match=r"mplib in .* failed; it said: no such module"):
        answers("mplib", python, [pick(robot("panda"), 51)], 0, 1.0)


@pytest.mark.parametrize("peer", PEERS)
def test_a_peer_solves_a_pick_from_its_start_to_one_of_its_goals(peer):
    python = python_of(peer)
    if python is None:
        pytest.skip(f"{peer} has no environment in .peers (make peers)")
    problem = pick(robot("panda"), 52)
    (answer,) = answers(peer, python, [problem], 0, 20.0)
    assert answer.path is not None
    assert np.allclose(answer.path[0], problem.start)
    assert np.abs(problem.goals - answer.path[-1]).max(axis=1).min() < 1e-6
    assert problem.checker.free(densely(answer.path, 0.05)).all()
