"""Every command and every Python block of the README runs, in the README's order, in one folder.

Not run here: `make`, pip and the virtual environment, since the tests already run inside what those set up
and .ci/run starts with them; pytest, which is this; and the whole `topple demo`, which .ci/run plays from the
wheel.
"""

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

from topple.planner.cli.main import COMMANDS

ROOT = Path(__file__).resolve().parents[1]
README = (ROOT / "README.md").read_text(encoding="utf-8")
BLOCKS = re.findall(r"^```(\w+)\n(.*?)^```$", README, re.MULTILINE | re.DOTALL)
ELSEWHERE = ("make ", "python3.11 -m venv ", ".venv/bin/")


def _steps() -> list[tuple[str, str]]:
    """(language, text) of each shell line and each Python block that is run, in order."""
    steps: list[tuple[str, str]] = []
    for language, text in BLOCKS:
        if language == "sh":
            steps += [("sh", line) for line in text.splitlines() if line and not line.startswith(ELSEWHERE)]
        elif language == "python":
            steps.append((language, text))
    return steps


@pytest.fixture(scope="module")
def outputs(tmp_path_factory: pytest.TempPathFactory) -> dict[str, str]:
    """What each step printed on stdout."""
    folder = tmp_path_factory.mktemp("readme")
    (folder / "examples").symlink_to(ROOT / "examples")
    path = f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"
    environment = {**os.environ, "PATH": path, "OMP_NUM_THREADS": "1", "PYTHONWARNINGS": "error"}
    printed: dict[str, str] = {}
    for language, text in _steps():
        argv = ["bash", "-euo", "pipefail", "-c", text] if language == "sh" else [sys.executable, "-c", text]
        done = subprocess.run(argv, cwd=folder, env=environment, capture_output=True, text=True, timeout=300)
        assert done.returncode == 0, f"{text}\nleft with {done.returncode}:\n{done.stdout}{done.stderr}"
        assert done.stdout.strip(), f"{text}\nprinted nothing"
        printed[text] = done.stdout
    return printed


def test_every_command_and_python_block_runs(outputs: dict[str, str]) -> None:
    assert len(outputs) == len(_steps()) >= 10


def test_output_the_readme_shows_is_what_the_commands_print(outputs: dict[str, str]) -> None:
    lines = {line.rstrip() for output in outputs.values() for line in output.splitlines()}
    for language, text in BLOCKS:
        if language == "text":
            assert set(text.splitlines()) <= lines


def test_the_plate_comes_after_all_that_is_on_it(outputs: dict[str, str]) -> None:
    (table,) = (
        output for step, output in outputs.items() if step.startswith("topple order") and "--json" not in step
    )
    taken = re.findall(r"^\d +(\w+) ", table, re.MULTILINE)
    assert sorted(taken) == ["can", "fork", "plate", "spoon_1", "spoon_2"]
    assert taken[-1] == "plate"


def test_the_python_block_relates_orders_and_plans(outputs: dict[str, str]) -> None:
    (printed,) = (output.splitlines() for step, output in outputs.items() if step.startswith("from topple"))
    assert printed[0] == "partial within"
    assert "plate" in printed[5]
    assert "('free', 'can', " in printed[-1]


def test_the_table_of_commands_names_all_there_are() -> None:
    assert set(re.findall(r"^\| `topple (\w+) ", README, re.MULTILINE)) == set(COMMANDS)


def test_links_to_files_lead_somewhere() -> None:
    for target in re.findall(r"\]\(([^)#:]+)\)", README):
        assert (ROOT / target).exists(), target
