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
NEEDS = {"ros": ("rosbags", "ros"), "ur5e": ("airo_models", "arms")}
"""Page -> module that it needs besides, and the extra of topple that brings it."""
ARMS = ROOT / "docs" / "transcripts" / "arms.md"


def blocks(page: Path) -> list[tuple[str, str]]:
    """(language, text) of the blocks of a page, in order."""
    return re.findall(r"^```(\w+)\n(.*?)^```$", page.read_text(encoding="utf-8"), re.MULTILINE | re.DOTALL)


def commands(page: Path) -> list[str]:
    return [line for language, text in blocks(page) if language == "sh" for line in text.splitlines() if line]


def test_there_is_one_for_each_way_to_begin():
    assert [page.stem for page in PAGES] == ["arms", "bop", "frame", "grasps", "ros", "ur5e"]
    for page, (_, extra) in NEEDS.items():
        assert f"pip install '.[{extra}]'" in (ARMS.parent / f"{page}.md").read_text()


def test_an_order_takes_fewer_than_five_commands():
    for page in PAGES:
        assert 0 < len(commands(page)) < FEW or page == ARMS
        assert any(command.startswith("topple ") for command in commands(page))


def printed_by(text: str, folder: Path, language: str = "sh") -> set[str]:
    """The lines that a block prints in a folder."""
    environment = {**os.environ, "PATH": f"{BIN}{os.pathsep}{os.environ['PATH']}", "OMP_NUM_THREADS": "1"}
    python = [str(Path(BIN, "python")), "-c", text]
    argv = python if language == "python" else ["bash", "-euo", "pipefail", "-c", text]
    done = subprocess.run(argv, cwd=folder, env=environment, capture_output=True, text=True, timeout=300)
    assert done.returncode == 0, f"{text}\n{done.stdout}{done.stderr}"
    return {line.rstrip() for line in done.stdout.splitlines()}


def test_ten_arms_have_their_command_each_from_the_file_that_the_table_names():
    from topple.benchmarks.arms import SHIPPED

    typed = commands(ARMS)[2:]
    files = {f"packages/{shipped.file}" for shipped in SHIPPED}
    assert len(typed) == len({command.split()[7] for command in typed}) == 10
    assert {command.split()[7] for command in typed} <= files
    assert all("--verify" in command for command in typed)


@pytest.mark.slow
@pytest.mark.parametrize("page", [page for page in PAGES if page != ARMS], ids=lambda page: page.stem)
def test_what_is_typed_prints_what_is_shown(page, tmp_path):
    module, extra = NEEDS.get(page.stem, ("topple", ""))
    if subprocess.run([str(Path(BIN, "python")), "-c", f"import {module}"], capture_output=True).returncode:
        pytest.skip(f"{module} is not installed: pip install '.[{extra}]'")
    (tmp_path / "examples").symlink_to(ROOT / "examples")
    printed, shown = set[str](), list[str]()
    for language, text in blocks(page):
        if language == "text":
            shown += text.splitlines()
        else:
            printed |= printed_by(text, tmp_path, language)
    assert shown and {line.rstrip() for line in shown} <= printed


@pytest.fixture(scope="module")
def bench(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder after the first block of the page of arms and its files."""
    folder = tmp_path_factory.mktemp("arms")
    (folder / "examples").symlink_to(ROOT / "examples")
    language, first = blocks(ARMS)[0]
    printed_by(first, folder, language)
    for name, text in re.findall(r"^`(\w+\.toml)`:?\n\n```toml\n(.*?)^```$", ARMS.read_text(), re.M | re.S):
        (folder / name).write_text(text)
    return folder


@pytest.mark.slow
@pytest.mark.parametrize("command", commands(ARMS)[2:], ids=lambda command: command.split()[7].split("/")[-1])
def test_an_arm_of_a_package_plans_by_its_command(command, bench):
    """Exit code 0: every check of `--verify` holds."""
    for word in command.split():
        if word.startswith("packages/") and not (bench / word).exists():
            pytest.skip(f"{word} is not installed")
    printed = printed_by(command, bench)
    assert any(line.startswith("Verified: ") and "every residual at most 0" in line for line in printed)
