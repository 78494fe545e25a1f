"""What a new user types: each page of docs/transcripts runs from an empty folder, in few commands.

`TOPPLE_BIN` names the folder of another environment's programs: the wheel's, in a bare one.
"""

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
PAGES = sorted((ROOT / "docs" / "transcripts").glob("*.md"))
BIN = os.environ.get("TOPPLE_BIN", str(Path(sys.executable).parent))
FEW = 5  # commands from a frame to an order: fewer than that


def blocks(page: Path) -> list[tuple[str, str]]:
    """(language, text) of the blocks of a page, in order."""
    return re.findall(r"^```(\w+)\n(.*?)^```$", page.read_text(encoding="utf-8"), re.MULTILINE | re.DOTALL)


def commands(page: Path) -> list[str]:
    return [line for language, text in blocks(page) if language == "sh" for line in text.splitlines() if line]


def test_there_is_one_for_each_way_to_begin() -> None:
    assert [page.stem for page in PAGES] == ["frame", "grasps", "urdf"]


def test_an_order_takes_fewer_than_five_commands() -> None:
    for page in PAGES:
        assert 0 < len(commands(page)) < FEW
        assert any(command.startswith("topple ") for command in commands(page))


@pytest.mark.slow
@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.stem)
def test_what_is_typed_prints_what_is_shown(page: Path, tmp_path: Path) -> None:
    (tmp_path / "examples").symlink_to(ROOT / "examples")
    environment = {**os.environ, "PATH": f"{BIN}{os.pathsep}{os.environ['PATH']}", "OMP_NUM_THREADS": "1"}
    printed, shown = set[str](), list[str]()
    for language, text in blocks(page):
        if language == "text":
            shown += text.splitlines()
            continue
        python = [str(Path(BIN, "python")), "-c", text]
        argv = python if language == "python" else ["bash", "-euo", "pipefail", "-c", text]
        done = subprocess.run(
            argv, cwd=tmp_path, env=environment, capture_output=True, text=True, timeout=300
        )
        assert done.returncode == 0, f"{text}\n{done.stdout}{done.stderr}"
        printed |= {line.rstrip() for line in done.stdout.splitlines()}
    assert shown and {line.rstrip() for line in shown} <= printed
