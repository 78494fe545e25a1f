"""Every command and every Python block of the README and the pages runs, in their order, in one folder.

The README's run in a bare shell as well, from the checkout on, where they set up and activate .venv; with
TOPPLE_BIN, in an environment that is set up already.
"""

import os
import re
import shutil
import subprocess
import sys
import textwrap
from pathlib import Path

import pytest

from topple.planner.cli.main import COMMANDS

ROOT = Path(__file__).resolve().parents[1]
FRAME = ROOT / "docs" / "sam.md"  # the page that writes frame.npz, which others take up
PAGES = (ROOT / "README.md", FRAME, *sorted({*(ROOT / "docs").glob("*.md")} - {FRAME}))
README = PAGES[0].read_text(encoding="utf-8")
COMMANDS_PAGE = (ROOT / "docs" / "commands.md").read_text(encoding="utf-8")
MOST_WORDS = 600  # one screen


def _blocks(page: Path) -> list[tuple[str, str]]:
    """(language, text) of the blocks of a page, in order."""
    found = re.findall(
        r"^ *```(\w+)\n(.*?)^ *```$", page.read_text(encoding="utf-8"), re.MULTILINE | re.DOTALL
    )
    return [(language, textwrap.dedent(text)) for language, text in found]


def _lines(printed: list[str]) -> set[str]:
    """Lines but for gaps in millimetres, whose tenths differ from machine to machine."""
    return {re.sub(r"\d+\.\d mm", "# mm", line.rstrip()) for line in printed}


BLOCKS = [block for page in PAGES for block in _blocks(page)]


def _steps() -> list[tuple[str, str]]:
    """(language, text) of each shell line and each Python block that is run, in order, each once."""
    steps: dict[tuple[str, str], None] = {}
    for language, text in BLOCKS:
        if language == "sh":
            lines = [line.partition("  #")[0].rstrip() for line in text.splitlines()]
            typed = [line for line in lines if line and not line.startswith(("make ", "source "))]
            steps |= {("sh", line): None for line in typed}
        elif language == "python":
            steps[language, text] = None
    return list(steps)


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


@pytest.mark.slow
def test_the_readme_works_line_by_line_in_a_bare_shell(tmp_path):
    here = shutil.copytree(ROOT, tmp_path / "topple", symlinks=True, ignore=shutil.ignore_patterns(".*"))
    blocks = _blocks(PAGES[0])
    typed = [
        text if language == "sh" else f"python - <<'END'\n{text}END\n"
        for language, text in blocks
        if language != "text"
    ]
    assert typed[0].startswith("make install ") and len(typed) > 1
    path = os.pathsep.join(each for each in os.environ["PATH"].split(os.pathsep) if ".venv" not in each)
    if "TOPPLE_BIN" in os.environ:
        typed[0] = typed[0].replace("make install", "true").replace("source .venv/bin/activate", "true")
        path = f"{os.environ['TOPPLE_BIN']}{os.pathsep}{path}"
    environment = {key: os.environ[key] for key in os.environ if key == "HOME" or key.startswith("PIP_")}
    done = subprocess.run(
        ["bash", "-euo", "pipefail", "-c", "".join(typed)],
        cwd=here,
        env={**environment, "PATH": path, "OMP_NUM_THREADS": "1"},
        capture_output=True,
        text=True,
    )
    assert done.returncode == 0, f"{done.stdout[-2000:]}\n{done.stderr[-2000:]}"
    shown = [line for language, text in blocks if language == "text" for line in text.splitlines()]
    assert shown and _lines(shown) <= _lines(done.stdout.splitlines())


@pytest.mark.slow
def test_every_command_and_python_block_runs(outputs):
    assert len(outputs) == len(_steps()) >= 10


@pytest.mark.slow
def test_output_the_readme_shows_is_what_the_commands_print(outputs):
    lines = _lines([line for output in outputs.values() for line in output.splitlines()])
    assert any(language == "text" for language, _ in BLOCKS)
    for language, text in BLOCKS:
        if language == "text":
            assert _lines(text.splitlines()) <= lines


@pytest.mark.slow
def test_the_plate_comes_after_all_that_is_on_it(outputs):
    tables = [
        output
        for step, output in outputs.items()
        if step.startswith("topple order") and "plate" in step and "--json" not in step
    ]
    assert len(tables) >= 2  # of the whole scene and of one frame of it
    for table in tables:
        taken = re.findall(r"^\d +(\w+) ", table, re.MULTILINE)
        assert sorted(taken) == ["can", "fork", "plate", "spoon_1", "spoon_2"]
        assert taken[-1] == "plate"


@pytest.mark.slow
def test_the_python_block_relates_orders_and_plans(outputs):
    printed = next(
        output.splitlines() for step, output in outputs.items() if step.startswith("import topple")
    )
    assert printed[0].startswith("fork partial within plate ")
    assert [line.split()[1] for line in printed[2:7]] == ["can", "fork", "spoon_1", "spoon_2", "plate"]
    assert printed[-1] == "plan: free can, verified: True"


def test_the_readme_is_one_screen():
    assert len(README.split()) < MOST_WORDS


def test_the_table_of_commands_names_all_there_are():
    assert set(re.findall(r"^\| `topple (\w+) ", COMMANDS_PAGE, re.MULTILINE)) == set(COMMANDS)


def test_links_lead_to_files_and_headings():
    followed = 0
    for page in PAGES:
        for target, heading in re.findall(r"\]\(([^)#:]*)(?:#([^)]+))?\)", page.read_text(encoding="utf-8")):
            file = (page.parent / target) if target else page
            assert file.exists(), f"{page.name}: {target}"
            titles = (
                re.findall(r"^#+ (.+)$", file.read_text(encoding="utf-8"), re.MULTILINE) if heading else []
            )
            assert not heading or heading in [title.lower().replace(" ", "-") for title in titles], heading
            followed += 1
    assert followed >= len(PAGES)
