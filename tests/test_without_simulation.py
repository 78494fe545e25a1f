"""What works where PyBullet has no wheel: everything but simulation, by the command line."""

import json
import subprocess
import sys
from importlib.util import find_spec
from pathlib import Path

import numpy as np
import pytest

from topple.robots import shapes

CUP = '[cup]\nlink = "tool0"\noffset = [0.0, 0.0, 0.1]\nradius = 0.015\n'


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A ball in a bowl beside a box, a gripper file and a file of grasps."""
    folder, rng = tmp_path_factory.mktemp("without"), np.random.default_rng(0)
    grid = np.stack(np.meshgrid(*[np.linspace(-0.4, 0.4, 81)] * 2, [0.0]), axis=-1).reshape(-1, 3)
    clouds = {
        "table": grid,
        "bowl": shapes.bowl().surface(4000, rng),
        "box": shapes.box("box", (0.06, 0.06, 0.06)).surface(2000, rng) + np.array([0.0, 0.2, 0.03]),
    }
    np.savez(folder / "scene.npz", **clouds, fixed=["table"], up=[0.0, 0.0, 1.0])
    poses = np.tile(np.diag([1.0, -1.0, -1.0, 1.0]), (3, 1, 1))
    poses[:, :3, 3] = [0.0, 0.2, 0.06]
    np.save(folder / "grasps.npy", poses)
    (folder / "cup.toml").write_text(CUP, encoding="utf-8")
    return folder


def _topple(folder: Path, *arguments: str, code: int = 0) -> tuple[str, str]:
    command = [sys.executable, "-W", "error", "-m", "topple.planner.cli.main", *arguments]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, timeout=240)
    assert done.returncode == code, done.stdout + done.stderr
    return done.stdout, done.stderr


@pytest.mark.slow
def test_relations_orders_and_pages_need_no_engine(folder):
    related, _ = _topple(folder, "relate", "scene.npz", "--json")
    touching = {
        p["b"] for p in json.loads(related)["relations"] if p["a"] == "table" and p["relation"] == "touch"
    }
    assert touching == {"bowl", "box"}
    ordered, _ = _topple(folder, "order", "scene.npz", "--json")
    assert sorted(json.loads(ordered)["order"]) == ["bowl", "box"]
    _topple(folder, "show", "scene.npz", "-o", "scene.html")
    assert (folder / "scene.html").stat().st_size > 10_000


@pytest.mark.slow
def test_an_arm_of_ones_own_plans_ranks_and_is_exported(folder):
    models = pytest.importorskip("airo_models", reason="no URDF of an arm: airo-models is not installed")
    urdf = str(models.get_urdf_path("ur5e"))
    arm = ("--robot", urdf, *"--gripper cup.toml --base -0.5 0 0 0".split())
    _topple(folder, "plan", "scene.npz", "--target", "box", *arm, "-o", "plan.json")
    plan = json.loads((folder / "plan.json").read_text(encoding="utf-8"))
    assert [step["object"] for step in plan["steps"]] == ["box"]
    said = [text for text in plan["assumptions"] if "PyBullet is not installed" in text]
    assert len(said) == (find_spec("pybullet") is None)
    exported, _ = _topple(folder, "export", "plan.json", "--to", "bt")
    assert "box" in exported
    ranked, _ = _topple(folder, "rank", "scene.npz", "grasps.npy", *arm, "--json")
    assert len(json.loads(ranked)["grasps"]) == 3


@pytest.mark.skipif(find_spec("pybullet") is not None, reason="PyBullet is installed")
@pytest.mark.parametrize(
    "command",
    [
        ("demo", "tower"),
        ("run", "scene.npz", "--target", "box"),
        ("order", "scene.npz", "--verify"),
        ("plan", "scene.npz", "--target", "box"),
    ],
)
def test_what_needs_the_engine_says_so_in_one_line(folder, command):
    printed, said = _topple(folder, *command, code=2)
    assert printed == ""
    assert said.splitlines()[-1].startswith("topple: ")
    assert "pip install 'pybullet" in said.splitlines()[-1]
    assert "Traceback" not in said


@pytest.mark.skipif(find_spec("topple.benchmarks.clouds") is not None, reason="a checkout has the benches")
def test_a_wheel_says_where_the_benches_are(folder):
    printed, said = _topple(folder, "bench", "run", "--quick", code=2)
    assert printed == "" and "works in a checkout of topple alone" in said.splitlines()[-1]
