import os
import subprocess
import sys
from pathlib import Path

import pytest

from topple.topology import load_scene

EXAMPLES = Path(__file__).resolve().parents[1] / "examples"
SCRIPTS = ("look.py", "order_clouds.py", "own_world.py")


def _output(folder: Path, script: str, *arguments: str) -> list[str]:
    """Lines an example prints; its warnings are errors."""
    done = subprocess.run(
        [sys.executable, "-W", "error", str(EXAMPLES / script), *arguments],
        cwd=folder,
        env={**os.environ, "OMP_NUM_THREADS": "1"},
        capture_output=True,
        text=True,
        timeout=120,
    )
    assert done.returncode == 0, done.stderr
    return done.stdout.splitlines()


def test_every_example_is_tested_and_short() -> None:
    assert sorted(path.name for path in EXAMPLES.glob("*.py")) == sorted(SCRIPTS)
    for script in SCRIPTS:
        assert len((EXAMPLES / script).read_text(encoding="utf-8").splitlines()) < 60, script


def test_look_writes_a_small_scene_that_says_everything(tmp_path: Path) -> None:
    assert _output(tmp_path, "look.py", "scene.npz")
    scene = load_scene(tmp_path / "scene.npz")
    assert set(scene.names) == {"table", "plate", "spoon_1", "spoon_2", "fork", "can"}
    assert scene.fixed == {"table"}
    assert scene.up is not None and scene.up == pytest.approx([0, 0, 1])
    assert scene.viewpoints.shape == (3, 3)
    assert scene.robot_base is not None
    assert scene.assumptions == ()
    assert (tmp_path / "scene.npz").stat().st_size < 1_000_000


def test_plain_arrays_give_relations_and_an_order_with_reasons(tmp_path: Path) -> None:
    lines = _output(tmp_path, "order_clouds.py")
    pairs = {line.split(":")[0] for line in lines if ": touch (" in line}
    assert pairs == {"table - left", "table - right", "left - book", "right - book", "book - ball"}
    assert "to free the left box: ball, book, left" in lines
    assert "1. ball: ball rests on book" in lines
    assert "2. book: book rests on left" in lines


def test_in_a_foreign_world_the_counterweight_is_found(tmp_path: Path) -> None:
    lines = _output(tmp_path, "own_world.py")
    assert "never moves: table" in lines
    taken = [line.split(":")[0] for line in lines if line[0].isdigit()]
    assert taken[-1] == "3. block"
    assert "plank before weight (counterweight)" in lines[-1]
    assert any("weight and plank hold each other" in line for line in lines)
