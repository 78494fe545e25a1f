"""The ceilings of size: what passes one is told, and no commit raises one in silence."""

import subprocess
import sys
from pathlib import Path

import pytest

SIZE = Path(__file__).parents[1] / ".ci" / "size.py"
pytestmark = pytest.mark.skipif(not SIZE.is_file(), reason="checks of a checkout come with none else")


def _git(folder: Path, *words: str) -> None:
    told = ["-c", "user.name=a", "-c", "user.email=a@b.c", "-c", "commit.gpgsign=false"]
    subprocess.run(["git", "-C", str(folder), *told, *words], check=True, capture_output=True)


def _said(folder: Path) -> tuple[int, str]:
    done = subprocess.run(
        [sys.executable, str(SIZE), "--root", str(folder)], capture_output=True, text=True, check=False
    )
    assert not done.stderr
    return done.returncode, done.stdout


@pytest.fixture
def checkout(tmp_path: Path) -> Path:
    """A checkout of a project of one file, with ceilings that it reaches."""
    room = tmp_path / "topology" / "room"
    room.mkdir(parents=True)
    (room / "one.py").write_text(
        '"""Words."""\n\nimport math\n\nFAR = 3.5  # [m]\n\n\n'
        "def area(a, b, c, d, e, f, g):\n    return math.pi * 0.25 * a + 1.0\n"
    )
    (tmp_path / "CHANGELOG.md").write_text("# Changes\n")
    _ceilings(tmp_path, code=3, numbers=1, literals=1, wide=1, longest=2, knots=0)
    _git(tmp_path, "init", "-q")
    _commit(tmp_path)
    return tmp_path


def _ceilings(folder: Path, **most: int) -> None:
    lines = [f"{name} = {value}\n" for name, value in most.items()]
    (folder / "pyproject.toml").write_text("[tool.size]\n" + "".join(lines))


def _commit(folder: Path) -> None:
    _git(folder, "add", "-A")
    _git(folder, "commit", "-qm", "a step")


def test_what_reaches_its_ceiling_passes(checkout):
    code, said = _said(checkout)
    assert code == 0, said
    assert "OVER" not in said


@pytest.mark.parametrize(
    ("line", "name"),
    [
        ("NEAR = 2\n", "numbers"),
        ("class A:\n    pass\n", "code"),
        ("def f():\n    return 0.3\n", "literals"),
        ("def f(a, b, c, d, e, f, g):\n    pass\n", "wide"),
        ("def f():\n    a = 1\n    return a\n", "longest"),
    ],
)
def test_what_passes_its_ceiling_is_told(checkout, line, name):
    with (checkout / "topology" / "room" / "one.py").open("a") as file:
        file.write(line)
    code, said = _said(checkout)
    assert code == 1
    assert any(row.startswith(name) and "OVER" in row for row in said.splitlines()), said


def test_words_cost_nothing(checkout):
    with (checkout / "topology" / "room" / "one.py").open("a") as file:
        file.write("# why\nfrom math import tau\n")
    assert _said(checkout)[0] == 0


def test_rooms_that_import_each_other_are_a_knot(checkout):
    for here, there in (("room", "other"), ("other", "room")):
        (checkout / "topology" / here).mkdir(exist_ok=True)
        text = f"def f():\n    from topple.topology.{there} import two\n"
        (checkout / "topology" / here / "two.py").write_text(text)
    code, said = _said(checkout)
    assert code == 1
    assert any(row.split()[:2] == ["knots", "2"] for row in said.splitlines()), said


@pytest.mark.parametrize("committed", [False, True])
def test_a_ceiling_is_raised_with_a_word_in_the_changelog_alone(checkout, committed):
    _ceilings(checkout, code=9, numbers=1, literals=1, wide=1, longest=2, knots=0)
    if committed:
        _commit(checkout)
    code, said = _said(checkout)
    assert code == 1
    assert "code 3 -> 9" in said
    if not committed:
        (checkout / "CHANGELOG.md").write_text("# Changes\n- Ceiling code 9: reads maps.\n")
        assert _said(checkout)[0] == 0
        _commit(checkout)
        _ceilings(checkout, code=5, numbers=1, literals=1, wide=1, longest=2, knots=0)
        _commit(checkout)
        assert _said(checkout)[0] == 0, "falling needs no word"
