"""What the commands print: the keys of the contract, JSON Lines, tables, exit codes."""

import json
import os
import shlex
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from topple.planner.cli.main import COMMANDS, _parser, main
from topple.robots.scenarios import SCENARIOS

DATA = Path(__file__).resolve().parents[3].parent / "shared" / "data" / "rgbd"
FRAMES = sorted(DATA.glob("osd_test4[2-9].npz")) + sorted(DATA.glob("ycbvideo*.npz"))
real = pytest.mark.skipif(not FRAMES, reason=f"the real frames are not at {DATA.parent.name}/{DATA.name}")


def _surface(lower: tuple[float, ...], upper: tuple[float, ...], count: int = 1500) -> np.ndarray:
    """Points all over the surface of a box."""
    rng = np.random.default_rng(1)
    points = rng.uniform(lower, upper, (count, 3))
    axis, side = rng.integers(3, size=count), rng.integers(2, size=count)
    points[np.arange(count), axis] = np.where(side, np.array(upper)[axis], np.array(lower)[axis])
    return points


@pytest.fixture
def stack(tmp_path: Path) -> Path:
    """A box on a box on a table, and a box beside them."""
    np.savez(
        tmp_path / "stack.npz",
        table=np.random.default_rng(0).uniform(-0.5, 0.5, (4000, 3)) * [1, 1, 0],
        below=_surface((0, 0, 0), (0.2, 0.2, 0.1)),
        above=_surface((0.05, 0.05, 0.1), (0.15, 0.15, 0.2)),
        beside=_surface((0.3, 0.3, 0), (0.4, 0.4, 0.1)),
    )
    return tmp_path / "stack.npz"


def _json(capsys: pytest.CaptureFixture[str], *argv: object, code: int = 0) -> list[dict[str, object]]:
    assert main([str(argument) for argument in argv]) == code
    return [json.loads(line) for line in capsys.readouterr().out.splitlines()]


def test_relate_prints_the_contracts_keys(stack, capsys):
    (document,) = _json(capsys, "relate", stack, "--json")
    assert (document["format"], document["format_version"]) == ("topple.relations", 1)
    assert document["scene"] == str(stack)
    assert document["objects"] == ["table", "below", "above", "beside"]
    relations = document["relations"]
    assert isinstance(relations, list)
    assert len(relations) == 6
    for pair in relations:
        assert {"a", "b", "relation", "matrix", "gap", "gap_exact", "confidence", "observed"} <= pair.keys()
        assert np.shape(pair["matrix"]) == (2, 3)
        assert 0 <= pair["confidence"] <= 1
    found = {(pair["a"], pair["b"]): pair["relation"] for pair in relations}
    assert found["below", "above"] == "touch"
    assert found["above", "beside"] == "disjoint"


@pytest.mark.slow
def test_an_order_checked_by_simulation_is_the_same_on_a_plain_stack(stack):
    options = "--fixed table --up 0 0 1 --json --verify --budget 60".split()
    done = _topple("order", stack, *options)
    found = json.loads(done.stdout)
    assert done.returncode == 0
    assert found["verified"] is True and found["trials"] > 0
    assert [(e["first"], e["then"]) for e in found["dependencies"]] == [("above", "below")]


def test_a_budget_without_a_check_is_refused(stack, typed):
    assert "--verify" in typed("order", stack, "--budget", "5", code=2).err


def test_order_prints_the_contracts_keys(stack, capsys):
    (document,) = _json(capsys, "order", stack, "--json", "--target", "below")
    assert (document["format"], document["format_version"]) == ("topple.order", 1)
    assert document["targets"] == ["below"]
    assert document["order"] == ["above", "below"]
    assert {"dependencies", "supports", "groups", "unresolved", "risk"} <= document.keys()
    edges = document["dependencies"]
    assert isinstance(edges, list)
    assert {"first": "above", "then": "below"}.items() <= edges[0].items()
    assert set(edges[0]) >= {"first", "then", "reason", "confidence"}


def test_several_scenes_are_json_lines(stack, capsys):
    for command in ("relate", "order"):
        documents = _json(capsys, command, stack, stack.parent / "stack.npz", "--json")
        assert [document["scene"] for document in documents] == [str(stack)] * 2


@pytest.mark.slow
def test_many_scenes_go_to_several_processes(stack, typed):
    broken = stack.with_name("broken.npz")
    broken.write_bytes(b"no archive")
    scenes = [stack, broken, *[stack] * 5]
    printed = typed("relate", *scenes, "--json", code=2)
    documents = [json.loads(line) for line in printed.out.splitlines()]
    assert [document["scene"] for document in documents] == [str(stack)] * 6
    assert all(document["relations"] == documents[0]["relations"] for document in documents)
    assert str(broken) in printed.err


def test_the_same_seed_prints_the_same(stack, capsys):
    first = _json(capsys, "order", stack, "--json", "--seed", "3")
    assert _json(capsys, "order", stack, "--json", "--seed", "3") == first


def test_a_scene_after_a_list_of_names_is_still_the_scene(stack, capsys, monkeypatch):
    (plain,) = _json(capsys, "order", stack, "--fixed", "table", "beside", "--target", "below", "--json")
    for argv in (
        ["order", "--fixed", "table", "beside", "--target", "below", stack, "--json"],
        ["order", "--json", "--target", "below", "--fixed", "table", "beside", stack],
    ):
        assert _json(capsys, *argv) == [plain]
    two = _json(capsys, "relate", "--json", "--fixed", "beside", stack, stack)
    assert len(two) == 2
    assert len(_json(capsys, "relate", "--json", stack, "--fixed", "beside", stack)) == 2
    # A file that happens to be called like an object does not turn its name into a scene.
    monkeypatch.chdir(stack.parent)
    (stack.parent / "below").write_text("")
    (order,) = _json(capsys, "order", stack, "--fixed", "table", "beside", "below", "--json")
    assert order["order"] == ["above"]


def test_negative_numbers_with_exponents_are_numbers(stack, capsys):
    assert len(_json(capsys, "relate", stack, "--json", "--up", "-1e-3", "-0.5", "1")) == 1


def test_order_says_every_step_with_its_reason(stack, typed):
    brief = typed("order", stack).out
    assert "Weakest contacts: " in brief and "What carries what" not in brief
    out = typed("order", stack, "--explain").out
    lines = [line.split() for line in out.splitlines()]
    steps = [line[1] for line in lines if line[:1] and line[0] in ("1", "2", "3")]
    assert sorted(steps) == ["above", "below", "beside"]
    assert steps.index("above") < steps.index("below")
    assert "on below" in out
    assert "What carries what" in out
    assert "Assumed: 'table' is taken as fixed because of its name." in out


def test_names_are_printed_as_they_are(tmp_path, typed):
    box = _surface((0, 0, 0), (0.1, 0.1, 0.1))
    np.savez(tmp_path / "scene.npz", **{"[red]mug": box, "Löffel": box + np.array([0.1, 0, 0])})
    out = typed("relate", tmp_path / "scene.npz").out
    assert "[red]mug" in out
    assert "Löffel" in out


@pytest.mark.slow
def test_names_the_terminal_cannot_show_are_no_reason_to_stop(tmp_path):
    box = _surface((0, 0, 0), (0.1, 0.1, 0.1))
    np.savez(tmp_path / "scene.npz", **{"Löffel": box, "mug": box + np.array([0.1, 0, 0])})
    plain = {**os.environ, "PYTHONIOENCODING": "ascii"}
    document = json.loads(_topple("relate", tmp_path / "scene.npz", "--json", env=plain).stdout)
    assert document["objects"] == ["Löffel", "mug"]
    assert "L\\xf6ffel" in _topple("relate", tmp_path / "scene.npz", env=plain).stdout


def test_show_writes_a_page_or_a_picture(stack, capsys):
    page, picture = stack.parent / "page.html", stack.parent / "picture.png"
    assert main(["show", str(stack), "-o", str(page)]) == 0
    assert page.read_text(encoding="utf-8").lstrip().lower().startswith("<!doctype html>")
    assert capsys.readouterr().out.startswith(str(page))
    (document,) = _json(capsys, "show", stack, "-o", picture, "--json")
    assert document["file"] == str(picture)
    assert picture.read_bytes().startswith(b"\x89PNG")
    assert not list(stack.parent.glob(".*"))


def test_show_without_up_draws_the_relations(tmp_path, typed):
    box = _surface((0, 0, 0), (0.1, 0.1, 0.1))
    np.savez(tmp_path / "scene.npz", a=box, b=box + np.array([0.2, 0, 0]))
    assert "--up 0 0 1" in typed("show", tmp_path / "scene.npz", "-o", tmp_path / "page.html").out


@pytest.mark.slow
@real
@pytest.mark.parametrize("path", FRAMES, ids=lambda path: path.stem)
def test_on_real_frames_nothing_goes_before_what_stands_on_it(path, capsys):
    known = path.stem.startswith("osd")  # of the other frame the table is found: it has no label
    options = ["--fixed", "1", "--json"] if known else ["--json"]
    (relations,) = _json(capsys, "relate", *options, path)
    (order,) = _json(capsys, "order", *options, path)
    names, steps = relations["objects"], order["order"]
    assert isinstance(names, list)
    assert isinstance(steps, list)
    assert sorted(steps) == sorted(name for name in names if name != ("1" if known else "table"))
    truth = json.loads(path.with_name(f"{path.stem}.gt.json").read_text())
    doubtful = set(truth.get("doubtful", {}).get("removal_constraints", []))
    for i, (first, then) in enumerate(truth["removal_constraints"]):
        if i not in doubtful:
            assert steps.index(str(first)) < steps.index(str(then)), f"{then} is taken from under {first}"


def _topple(*argv: object, **options: object) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-m", "topple.planner.cli.main", *map(str, argv)]
    return subprocess.run(command, capture_output=True, text=True, timeout=240, check=False, **options)  # type: ignore[call-overload]


def test_help_and_version_answer_without_the_heavy_imports():
    code = (
        "import sys; from topple.planner.cli.main import main; assert main(['--help']) == 0; "
        "heavy = {'numpy', 'scipy', 'networkx', 'pybullet', 'rich', 'trimesh', 'ompl', 'fcl'}; "
        "heavy &= set(sys.modules); assert not heavy, heavy"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=60)
    assert done.returncode == 0, done.stderr
    assert all(f"  {name} " in done.stdout for name in COMMANDS)
    assert _topple("--version").stdout.startswith("topple ")
    assert _topple("relate", "--version").stdout.startswith("topple ")


@pytest.mark.parametrize("command", COMMANDS)
def test_help_of_a_command_ends_with_two_calls_that_it_takes(command, typed):
    out = typed("help", command).out
    calls = [line.split("topple ", 1)[1] for line in out.splitlines() if line.startswith("  topple ")]
    assert len(calls) == 2
    for call in calls:
        parser = _parser(command)[0]
        _, unknown = parser.parse_known_args(shlex.split(call))
        assert not unknown
    assert "(0)" not in out, "defaults are said to be some"


def test_a_bare_name_after_a_scene_is_a_target(stack, typed):
    asked = typed("order", stack, "--target", "below", "--json").out
    assert typed("order", stack, "below", "--json").out == asked


def test_the_scenes_of_the_demo_are_listed(typed):
    out = typed("demo", "--list").out
    assert all(name in out for name in SCENARIOS)
    assert "free the plate" in out


def test_without_a_command_it_says_where_to_begin():
    done = _topple()
    assert done.returncode == 0
    assert "topple demo" in done.stdout
    assert done.stderr == ""


@pytest.mark.slow
def test_the_process_leaves_with_the_exit_code(stack):
    assert _topple("relate", stack).returncode == 0
    assert _topple("relate", stack.parent / "no.npz").returncode == 2


def test_a_reader_that_has_seen_enough_is_no_error(stack):
    reading, writing = os.pipe()
    os.close(reading)
    command = [sys.executable, "-m", "topple.planner.cli.main", "relate", str(stack), "--json"]
    done = subprocess.run(command, stdout=writing, stderr=subprocess.PIPE, text=True, timeout=60)
    os.close(writing)
    assert "topple: " not in done.stderr
    assert "Broken pipe" not in done.stderr
    assert done.returncode == 0


def test_interrupting_is_code_130(stack, capsys, monkeypatch):
    def interrupted(*_: object, **__: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr("topple.topology.io.load_scene", interrupted)
    assert main(["relate", str(stack)]) == 130
    assert capsys.readouterr().err.endswith("topple: interrupted\n")


def test_of_many_objects_only_pairs_that_are_not_far_are_listed(tmp_path, typed):
    places = [(k % 15, k // 15) for k in range(201)]
    clouds = {
        f"box {k}": _surface((0.2 * x, 0.2 * y, 0), (0.2 * x + 0.05, 0.2 * y + 0.05, 0.05), 60)
        for k, (x, y) in enumerate(places)
    }
    clouds["on box 0"] = _surface((0, 0, 0.05), (0.05, 0.05, 0.1), 60)
    np.savez(tmp_path / "many.npz", **clouds)  # type: ignore
    command = ["relate", str(tmp_path / "many.npz"), "--plain", "--json"]
    few = typed(*command).document
    every = typed(*command, "--all-pairs").document
    assert len(every["relations"]) == 202 * 201 // 2 and "far_pairs_left_out" not in every
    assert few["far_pairs_left_out"] == len(every["relations"]) - len(few["relations"]) > 19_000
    listed = {(pair["a"], pair["b"]) for pair in few["relations"]}
    assert ("box 0", "on box 0") in listed
    left = [pair for pair in every["relations"] if (pair["a"], pair["b"]) not in listed]
    assert {pair["relation"] for pair in left} == {"disjoint"}
