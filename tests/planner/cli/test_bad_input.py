"""Everything wrong a user can give: exit code 2, one line that names it, nothing on stdout."""

import ast
import json
import re
import zipfile
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

import topple
from topple.planner.cli import progress
from topple.planner.cli.console import in_options
from topple.planner.cli.main import main

RNG = np.random.default_rng(0)
BOX = RNG.uniform(0, 0.1, (300, 3))
TABLE = np.column_stack([RNG.uniform(-0.5, 0.5, (2000, 2)), np.zeros(2000)])
DEPTH, LABEL = np.ones((60, 80)), np.ones((60, 80), dtype=int)
K = np.array([[60.0, 0, 40], [0, 60.0, 30], [0, 0, 1]])
FINE = {"mug": BOX, "table": TABLE}

Refused = Callable[..., str]


@pytest.fixture(autouse=True)
def _patient(monkeypatch: pytest.MonkeyPatch) -> None:
    """However busy the machine is, no line of progress comes beside the refusal."""
    monkeypatch.setattr(progress, "_WAITING", 600.0)


@pytest.fixture
def refused(capsys: pytest.CaptureFixture[str]) -> Refused:
    """Runs the command line, checks that it refuses in one line, and returns the line."""

    def run(*argv: object) -> str:
        code = main([str(argument) for argument in argv])
        out, err = capsys.readouterr()
        assert code == 2, err
        assert out == ""
        (line,) = err.splitlines()
        assert line.startswith("topple")
        return line

    return run


def _npz(folder: Path, **arrays: object) -> Path:
    np.savez(folder / "scene.npz", **arrays)  # type: ignore[arg-type]
    return folder / "scene.npz"


@pytest.mark.parametrize("command", ["relate", "order", "show"])
def test_bad_arrays(refused, tmp_path, command):
    for arrays, words in (
        ({**FINE, "cup": np.empty((0, 3))}, "'cup' is empty"),
        ({"depth": DEPTH, "K": K, "label": LABEL[:9]}, "(9, 80)"),
    ):
        path = _npz(tmp_path, **arrays)
        line = refused(command, path)
        assert str(path) in line and words in line


def test_files_that_are_not_scenes(refused, tmp_path):
    assert "no such file" in refused("relate", tmp_path / "nothing.npz")
    assert "no clouds or meshes" in refused("relate", tmp_path)
    (tmp_path / "scene.npz").write_text("hello")
    assert "of no known format" in refused("relate", tmp_path / "scene.npz")
    folder = tmp_path / "folder"
    folder.mkdir()
    (folder / "cup.ply").write_text("hello")
    assert "'cup'" in refused("relate", folder)


def test_two_things_of_one_name_are_refused(refused, tmp_path):
    for suffix in ("xyz", "ply"):
        np.savetxt(tmp_path / f"cup.{suffix}", BOX)
    line = refused("relate", tmp_path)
    assert "cup.ply and cup.xyz are both object 'cup': rename one" in line
    _npz(tmp_path, **FINE)
    with zipfile.ZipFile(tmp_path / "scene.npz", "a") as archive, pytest.warns(UserWarning, match="Dupl"):
        archive.writestr("mug.npy", b"")
    assert "'mug' occurs twice" in refused("relate", tmp_path / "scene.npz")


def test_unknown_names_are_answered_with_the_known_ones(refused, tmp_path):
    path = _npz(tmp_path, **FINE)
    line = refused("relate", f"{tmp_path}/./scene.npz", "--fixed", "desk")
    assert line.count("scene.npz") == 1
    assert "'desk'" in line
    assert "mug, table" in line
    assert "'cup'" in refused("order", path, "--target", "cup")
    assert "'table'" in refused("order", path, "--target", "table")


def test_order_without_up_says_how_to_give_it(refused, tmp_path):
    path = _npz(tmp_path, mug=BOX, cup=BOX + 0.2)
    assert "--up 0 0 1" in refused("order", path)
    assert main(["order", str(path), "--up", "0", "0", "1"]) == 0


def _grid_box(size: tuple[float, float, float], low: tuple[float, float, float]) -> np.ndarray:
    """(N, 3) points on all six sides of a box, 4 mm apart."""
    axes = [np.linspace(0, length, round(length / 0.004) + 1) for length in size]
    points = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)
    on_side = (np.isclose(points, 0) | np.isclose(points, size)).any(axis=1)
    return points[on_side] + low


LOW = _grid_box((0.1, 0.1, 0.06), (0, 0, 0))
ON = _grid_box((0.06, 0.06, 0.04), (0.02, 0.02, 0.06))


@pytest.mark.parametrize(
    ("arrays", "said"),
    [
        ({"low": LOW, "hung": ON + np.array([0, 0, 0.3]), "table": TABLE}, "nothing seen carries hung"),
        ({"low": LOW, "fallen": ON - [0.2, 0, 0.3], "table": TABLE}, "fallen lies below the table's surface"),
        ({"low": LOW, "sunk": ON - [0, 0, 0.04], "table": TABLE}, "the clouds of sunk and low overlap"),
        ({"low": LOW, "top": ON}, "no object is fixed"),
    ],
)
def test_what_cannot_be_is_ordered_under_a_stated_assumption(tmp_path, typed, arrays, said):
    path = _npz(tmp_path, up=[0, 0, 1], **arrays)
    document = typed("order", path, "--json").document
    assert set(document["order"]) == set(arrays) - {"table"}
    assert any(said in sentence for sentence in document["assumptions"])
    assert f"Assumed: {said}" in typed("order", path).out


def test_a_stack_that_can_be_needs_no_assumption_about_its_bodies(tmp_path, typed):
    path = _npz(tmp_path, up=[0, 0, 1], low=LOW, top=ON, table=TABLE)
    said = typed("order", path, "--json").document["assumptions"]
    assert not any("overlap" in sentence or "carries" in sentence for sentence in said)


def test_the_length_of_up_does_not_matter(tmp_path, typed):
    path = _npz(tmp_path, low=LOW, top=ON, table=TABLE)
    for length in ("1", "250", "0.004"):
        document = typed("order", path, "--json", "--up", "0", "0", length).document
        assert document["order"] == ["top", "low"]
        scaled = any("scaled to 1" in sentence for sentence in document["assumptions"])
        assert scaled == (length != "1")


@pytest.mark.parametrize("up", [("0", "0", "0"), ("nan", "0", "1"), ("inf", "0", "0")])
def test_up_has_to_point_somewhere(refused, tmp_path, up):
    assert "up is" in refused("relate", _npz(tmp_path, **FINE), "--up", *up)


@pytest.mark.parametrize("deviation", ["0", "-0.002", "nan", "0.3", "5", "inf"])
def test_a_deviation_is_a_length_below_the_objects(refused, tmp_path, deviation):
    path = _npz(tmp_path, **FINE)
    assert "deviation" in refused("relate", path, "--deviation", deviation)
    assert "deviation" in refused("relate", "--plain", path, "--deviation", deviation)


@pytest.mark.parametrize(
    ("argv", "words"),
    [
        ([], "no scene given"),
        (["--up", "0", "1", "scene.npz"], "--up"),
        (["--up", "0", "0", "z"], "invalid float value: 'z'"),
        (["--seed", "-1", "x"], "-1 is not a whole number from 0 on"),
        (["--seed", "1.5", "x"], "1.5 is not a whole number from 0 on"),
        (["--fixed"], "expected at least one argument"),
        (["--frobnicate", "x"], "--frobnicate"),
    ],
)
def test_wrong_options(refused, argv, words):
    line = refused("relate", *argv)
    assert words in line
    assert "--help" in line


def test_wrong_commands(refused):
    assert "'frobnicate'" in refused("frobnicate")
    assert "unrecognized arguments: --" in refused("--")
    assert "--json" in refused("--json")


@pytest.mark.parametrize(
    ("argv", "meant"),
    [
        (["ordr"], "order"),
        (["plan", "scene.npz", "--tarqet", "mug"], "--target"),
        (["demo", "dishs", "--json"], "dishes"),
        (["robot", "pnda"], "panda"),
        (["order", "scene.npz", "mugg"], "mug"),
    ],
)
def test_what_was_meant_is_asked(refused, argv, meant, tmp_path, monkeypatch):
    _npz(tmp_path, **FINE)
    monkeypatch.chdir(tmp_path)
    line = refused(*argv)
    assert f"did you mean {meant!r}?" in line
    if argv[0] == "plan":
        assert "topple plan --help" in line, "where that command's options are"


def test_an_output_that_cannot_be_written_is_refused_before_the_work(refused, tmp_path):
    # The scene does not exist either: that the output comes first shows that no work was begun.
    nothing = tmp_path / "nothing.npz"
    assert "does not exist" in refused("show", nothing, "-o", tmp_path / "no" / "page.html")
    assert "is a folder" in refused("show", nothing, "-o", _made(tmp_path / "dir.html"))
    assert ".html, .png, .gif, .svg" in refused("show", nothing, "-o", tmp_path / "page.jpg")


def _made(folder: Path) -> Path:
    folder.mkdir()
    return folder


def test_one_bad_scene_does_not_keep_the_others_from_their_answer(tmp_path, typed):
    fine = str(_npz(tmp_path, **FINE))
    out, err = typed("relate", "--json", fine, tmp_path / "no.npz", fine, code=2)
    assert [json.loads(line)["scene"] for line in out.splitlines()] == [fine, fine]
    assert len(err.splitlines()) == 1


def test_a_demo_that_does_not_exist_or_cannot_be_written(refused, tmp_path):
    assert "'opera'" in refused("demo", "opera", "-o", tmp_path / "out")
    assert not (tmp_path / "out").exists()
    (tmp_path / "file").write_text("")
    assert "file" in refused("demo", "-o", tmp_path / "file")


@pytest.mark.parametrize(
    ("python", "shell"),
    [
        ("give up=[0, 0, 1] or name a table", "give --up 0 0 1 or name a table"),
        ("models=True takes them; image=N another", "--models takes them; --image N another"),
        ("allow more with max_bytes=N", "allow more with --max-mb N"),
        ("in the camera's frame, or pose_source_to_world=POSE", "in the camera's frame"),
        ("a == b, and x=3 stays", "a == b, and x=3 stays"),
    ],
)
def test_messages_name_keywords_in_python_and_options_on_the_command_line(python, shell):
    assert in_options(python) == shell


def test_no_message_of_the_library_names_an_option():
    root, strings = Path(topple.__file__).parent, list[str]()
    for path in [*(root / "topology").rglob("*.py"), *(root / "robots").rglob("*.py")]:
        nodes = list(ast.walk(ast.parse(path.read_text(encoding="utf-8"))))
        docs = {id(node.value) for node in nodes if isinstance(node, ast.Expr)}
        texts = [node for node in nodes if isinstance(node, ast.Constant) and id(node) not in docs]
        strings += [node.value for node in texts if isinstance(node.value, str)]
    assert len(strings) > 1000
    assert [text for text in strings if re.search(r"(?<![\w-])--(?!no-deps)[a-z]{2}", text)] == []
