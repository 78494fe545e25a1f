"""`topple robot`: what was understood, what was tried, exit codes, and a line that works."""

import json
import shlex
import sys
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from topple.planner.cli.main import main
from topple.planner.execution.examine import examine
from topple.planner.execution.trial import trial
from topple.robots.catalog import data_path, robot

sys.path.insert(0, str(Path(__file__).parents[2] / "robots" / "catalog"))
from own_urdf import written

PANDA = str(data_path() / "franka_panda" / "panda.urdf")


@pytest.mark.slow
def test_a_panda_is_understood_tried_and_its_line_plans(tmp_path, typed):
    said = typed("robot", PANDA, "--json", "--report", tmp_path / "arm.png").document
    assert said["format"] == "topple.robot" and said["ok"] is True
    assert [joint["name"] for joint in said["joints"]] == [f"panda_joint{k}" for k in range(1, 8)]
    assert [tool["kind"] for tool in said["tools"]] == ["jaw"]
    assert 0.8 < said["reach"] < 1.1
    assert 0.5 < said["self_collision"]["free"] < 1.0
    assert said["inverse"]["solved"] >= 0.995 * said["inverse"]["poses"] and said["inverse"]["poses"] > 900
    assert said["grasp"]["success"] is True and said["grasp"]["object"]["mass"] == 0.1
    pixels = np.asarray(Image.open(tmp_path / "arm.png").convert("RGB"))
    assert len(np.unique(pixels.reshape(-1, 3), axis=0)) > 50  # an arm, not an empty picture

    tried = trial(robot(PANDA), "fingers")
    assert tried is not None
    clouds = {name: np.asarray(cloud) for name, cloud in tried.scene().clouds.items()}
    np.savez(tmp_path / "scene.npz", **clouds, fixed=np.array(["table"]), up=np.array([0.0, 0.0, 1.0]))
    words = shlex.split(
        said["command"].replace("SCENE", str(tmp_path / "scene.npz")).replace("NAME", "block")
    )
    plan = tmp_path / "plan.json"
    words[words.index("plan.json")] = str(plan)
    assert main([*words[1:], "--base", "0", "0", "0", "0"]) == 0
    assert json.loads(plan.read_text())["steps"]


def test_an_arm_without_a_tool_is_described_and_told_what_to_write(tmp_path, typed):
    out = typed("robot", str(written(tmp_path)), code=1).out
    assert "6 joints from world" in out
    assert 'cup = {link = "tool0"' in out and "not tried, there is nothing to take hold with" in out
    assert "no velocity limits" in out


def test_the_grasp_can_be_left_out(tmp_path, typed):
    said = typed("robot", PANDA, "--no-grasp", "--json").document
    assert said["grasp"] is None and said["untried"] == "it was not asked for"


def test_an_arm_whose_inverse_kinematics_misses_poses_is_not_ok(monkeypatch):
    from topple.robots.arm import arm as module

    found = examine(robot(PANDA), grasp=False)
    assert found.ok
    # one start, and one round of it: most poses are missed
    monkeypatch.setattr(module, "solve", lambda *_, **__: (np.empty((0, 7)), np.empty(0, dtype=np.int64)))
    spoilt = examine(robot(PANDA), grasp=False)
    assert spoilt.solved == 0 and not spoilt.ok


@pytest.mark.parametrize(
    ("argv", "words"),
    [
        (["no.urdf"], "no.urdf: cannot be read"),
        (["hal"], "unknown robot 'hal'"),
        ([PANDA, "--srdf", "no.srdf"], "no.srdf: cannot be read"),
        ([PANDA, "--group", "arm"], "give --srdf FILE"),
        ([PANDA, "--report", "nowhere/arm.png"], "nowhere"),
        (["panda", "--gripper", "wsg50"], "has a hand of its own"),
    ],
)
def test_what_cannot_be_used_is_refused_in_one_line(argv, words, capsys):
    assert main(["robot", *argv]) == 2
    lines = [line for line in capsys.readouterr().err.splitlines() if "reading" not in line]
    assert len(lines) == 1 and words in lines[0]


def test_an_arm_that_reaches_no_table_gets_no_block(tmp_path):
    path = written(tmp_path)
    text = path.read_text().replace("lower='-2.6' upper='2.6'", "lower='-0.1' upper='0.1'")
    path.write_text(text)
    (tmp_path / "cup.toml").write_text('cup = {link = "tool0", offset = [0, 0, 0.08], radius = 0.015}')
    found = examine(robot(path, tmp_path / "cup.toml"))
    assert found.grasped is not None and found.grasped.trial is None and not found.ok
