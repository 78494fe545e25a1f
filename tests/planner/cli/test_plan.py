"""`topple plan`: the plan file, the refusals, and exit code 1 with the reason where there is no plan."""

import json
import os
import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from topple.planner.cli.main import main
from topple.planner.cli.robot_options import base_of
from topple.planner.planning.plan_format import plan_from_json
from topple.robots.world.bodies import Body
from topple.topology.scene.scene import Scene

BASE = "--base -0.5 0 0 0".split()


@pytest.fixture
def scene(tmp_path: Path) -> Path:
    """A box of 5 cm in the middle of a table."""
    rng = np.random.default_rng(1)
    box = rng.uniform(-0.025, 0.025, (1500, 3))
    box[np.arange(1500), rng.integers(3, size=1500)] = rng.choice([-0.025, 0.025], 1500)
    table = rng.uniform(-0.6, 0.6, (5000, 3)) * [1, 1, 0]
    np.savez(tmp_path / "scene.npz", table=table, box=box + np.array([0, 0, 0.025]))
    return tmp_path / "scene.npz"


def test_a_plan_is_written_and_read_back(scene, capsys):
    place = scene.parent / "plan.json"
    assert main(["plan", str(scene), "--target", "box", *BASE, "-o", str(place), "--json"]) == 0
    plan = plan_from_json(place.read_bytes())
    assert plan == plan_from_json(capsys.readouterr().out)
    assert plan.order == ["box"]
    assert not plan.base_searched
    assert np.allclose(np.array(plan.pose_base_to_world)[:3, 3], [-0.5, 0, 0])


@pytest.mark.slow
def test_a_plan_that_is_verified_says_so(scene, typed):
    argv = ["plan", str(scene), "--target", "box", *BASE, "--verify"]
    out = typed(*argv).out
    assert "every motion certified" in out
    assert "every residual at most 0" in out
    assert re.search(r"nor between these states +swept certificate derived again +1 *\n", out)
    assert "not shown" not in out and "NOT SO" not in out
    assert "Asked of no plan: torques of speeding up" in out
    document = typed(*argv, "--json").document
    assert document["verification"]["ok"] is True
    assert document["verification"]["steps"][0]["object"] == "box"
    assert plan_from_json(json.dumps(document)).order == ["box"]


def test_a_start_in_collision_is_refused_with_what_it_meets(scene, typed):
    out, err = typed("plan", scene, "--target", "box", "--base", "-0.5", "0", "-0.4", "0", code=2)
    assert out == ""
    assert "the start is in collision" in err
    assert "table" in err


def test_out_of_reach_is_code_1_with_the_reason(scene, typed):
    place = scene.parent / "plan.json"
    out, err = typed("plan", scene, "--target", "box", "--base", "3", "0", "0", "0", "-o", place, code=1)
    assert out == ""
    assert "box" in err
    assert not place.exists()


def test_a_plan_that_takes_longer_than_its_budget_is_none(scene, typed):
    place = scene.parent / "plan.json"
    asked = ["plan", str(scene), "--target", "box", "--budget", "0.05", "--json", "-o", str(place)]
    out, err = typed(*asked, code=1)
    assert (json.loads(out)["kind"], json.loads(out)["safe"]) == ("OutOfBudget", False)
    assert "the budget of 0.05 s ran out" in err
    assert not place.exists()


@pytest.mark.slow
@pytest.mark.parametrize("command", ["plan", "run"])
def test_without_a_safe_plan_the_certificate_is_json(scene, typed, command):
    base = ["3", "0", "0", "0"] if command == "plan" else ["-1.5", "0", "0", "0"]  # both out of reach
    out, err = typed(command, scene, "--target", "box", "--json", "--base", *base, code=1)
    document = json.loads(out)
    assert document["format"] == f"topple.{command}" and document["format_version"] == 1
    assert document["steps"] == []
    assert document["safe" if command == "plan" else "success"] is False
    reasons = document["certificate" if command == "plan" else "violations"]
    assert reasons and "box" in reasons[0] and "box" in err
    if command == "plan":
        assert document["kind"] == "NoSafePlan" and document["goal"] == "free box"
        assert document["failures"][0]["object"] == "box" and document["failures"][0]["reasons"]


def two_boxes(folder: Path, name: str) -> Path:
    """Two boxes that stand side by side on a table."""
    box = Body.of("box", [np.array([[x, y, z] for x in (0, 0.05) for y in (0, 0.05) for z in (0, 0.05)])])
    points = box.surface(800, np.random.default_rng(0))
    table = np.random.default_rng(1).uniform(-0.5, 0.5, (4000, 3)) * [1, 1, 0]
    np.savez(folder / name, table=table, a=points, **{"ä": points + np.array([0, 0.1, 0])})
    return folder / name


@pytest.mark.parametrize("command", ["plan", "run"])
def test_words_that_nothing_can_fulfil_are_a_certificate_in_json_too(tmp_path, typed, command):
    words = "a on ä and ä on a"
    out, err = typed(command, str(two_boxes(tmp_path, "scene.npz")), "--to", words, "--json", code=1)
    document = json.loads(out)
    assert document["goal"] == words and document["steps"] == []
    assert "below" in err and len(err.splitlines()) <= 2


def test_a_scene_without_a_safe_order_of_moves_keeps_no_other_from_its_answer(tmp_path, typed):
    scenes = [str(two_boxes(tmp_path, name)) for name in ("first.npz", "second.npz")]
    out, err = typed("order", *scenes, "--to", "a on ä and ä on a", "--json", code=1)
    assert out == ""
    assert all(any(line.startswith(f"topple: {scene}: ") for line in err.splitlines()) for scene in scenes)


def test_the_plan_is_json_where_the_terminal_has_no_umlauts(tmp_path):
    argv = ["plan", str(two_boxes(tmp_path, "scene.npz")), "--target", "ä", *BASE]
    done = subprocess.run(
        [sys.executable, "-m", "topple.planner.cli.main", *argv, "--json"],
        env={**os.environ, "PYTHONIOENCODING": "ascii", "PYTHONUTF8": "0"}, capture_output=True, check=True,
    )  # fmt: skip
    assert plan_from_json(done.stdout).order == ["ä"]


@pytest.mark.parametrize(
    ("argv", "words"),
    [
        ([], "--target NAME, --goal TEXT and --to GOAL"),
        (["--target", "box", "--goal", "free box"], "--target NAME, --goal TEXT and --to GOAL"),
        (["--target", "cup"], "unknown object 'cup'"),
        (["--target", "table"], "'table' is fixed"),
        (["--goal", "dance"], "'dance' is not understood"),
        (["--target", "box", "--robot", "r2d2"], "unknown robot 'r2d2'"),
        (["--target", "box", "--base", "0", "0", "0"], "--base"),
        (["--target", "box", "--base", "0", "0", "nan", "0"], "--base is"),
        (["--target", "box", "-o", "no/such/folder/plan.json"], "does not exist"),
    ],
)
def test_wrong_use_is_refused_in_one_line(scene, typed, argv, words):
    out, err = typed("plan", scene, *argv, code=2)
    assert out == ""
    assert words in err
    assert len([line for line in err.splitlines() if not line.endswith(" s)")]) == 1


@pytest.mark.parametrize("up", [(0, 0, 1), (0, 0, -1), (0, -1, 0), (0.3, -0.8, -0.5)])
def test_the_base_stands_upright_whatever_up_is(up):
    from argparse import Namespace

    scene = Scene({"box": np.zeros((2, 3))}, up=up)
    pose = base_of(Namespace(base=[1.0, 2.0, 3.0, 0.7]), scene)
    assert pose is not None
    assert scene.up is not None
    assert np.allclose(pose[:3, 2], scene.up, atol=1e-9)
    assert np.allclose(pose[:3, :3] @ pose[:3, :3].T, np.eye(3))
    assert np.linalg.det(pose[:3, :3]) > 0
    assert np.allclose(pose[:3, 3], [1, 2, 3])


def test_yaw_turns_about_up():
    from argparse import Namespace

    pose = base_of(Namespace(base=[0.0, 0.0, 0.0, np.pi / 2]), Scene({"box": np.zeros((2, 3))}, up=(0, 0, 1)))
    assert pose is not None
    assert np.allclose(pose[:3, 0], [0, 1, 0], atol=1e-12)


@pytest.mark.slow
def test_a_drop_has_to_be_allowed_and_is_then_told(tmp_path, typed):
    x, y = np.meshgrid(np.arange(-0.45, 0.45, 0.008), np.arange(-0.45, 0.45, 0.008))
    table = np.column_stack([x.ravel(), y.ravel(), np.zeros(x.size)])
    angles = np.arange(6) * np.pi / 3
    ring = 0.02 * np.column_stack([np.cos(angles), np.sin(angles)])
    rings = [np.column_stack([ring, np.full(6, height)]) for height in (0.03, 0.12)]
    peg = Body.of("peg", [np.vstack([[[0.016, 0.004, 0.0]], *rings])]).surface(4000, np.random.default_rng(0))
    path = tmp_path / "scene.npz"
    np.savez(path, table=table, peg=peg - [0, 0, peg[:, 2].min()])
    argv = ["plan", str(path), "--target", "peg", "--robot", "panda", *BASE, "--verify"]
    assert "no drop is allowed" in typed(*argv, code=1).err
    out = typed(*argv, "--allow-drop").out
    assert "it is let go to fall as it will" in out
    assert "Allowed: step 1 (peg) is let go to fall" in out
    assert "not shown: it stays there" in out
    assert "every residual at most 0" in out
