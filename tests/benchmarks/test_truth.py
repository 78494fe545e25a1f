"""The gate of truth: counts that mean what they say, versions that are asked, and what is refused."""

import json
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from at_rest import labelled

from topple.benchmarks.commands.bench import markdown
from topple.benchmarks.document import bench
from topple.benchmarks.truth import answers as answers_module
from topple.benchmarks.truth import gate, pool
from topple.benchmarks.truth.answers import Question, answers
from topple.benchmarks.truth.cases import pool_cases
from topple.benchmarks.truth.counts import COLUMN, FIGURES, Counts, chances, count, difference
from topple.benchmarks.truth.floors import Floors
from topple.benchmarks.truth.gate import FLOORS
from topple.benchmarks.truth.mask_faults import INACCURATE, WRONG, MaskFaults, corrupt
from topple.benchmarks.truth.planted import CHANGES, planted
from topple.benchmarks.truth.resting import RestingScene
from topple.benchmarks.truth.views import VIEWS, seen
from topple.benchmarks.versions import ROOT, Version, commit_now, of_commit, today
from topple.topology.base.errors import InvalidInput, ToppleError

in_checkout = pytest.mark.skipif(commit_now() is None, reason="this is no checkout: there are no commits")


def silent(text: str) -> None:
    """Says nothing."""


LABELS = {
    "a": {"b": 1, "c": 0, "d": 0},
    "b": {"a": 0, "c": 0, "d": 0},
    "c": {"a": 0, "b": None, "d": 1},
    "d": {"a": 0, "b": 0, "c": 1},
}
RELATIONS = {("a", "b"): "partial contain", ("c", "d"): "touch", ("a", "c"): "disjoint"}
PERFECT = {
    "names": [*"abcd", "table"],
    "objects": [*"abcd"],
    "relations": [["b", "a", "partial within"], ["c", "d", "touch"]],
    "dependencies": [["b", "a", "contained", 0.9], ["c", "d", "leaning", 0.8], ["d", "c", "leaning", 0.6]],
    "order": ["b", "a", "c", "d"],
    "groups": [["c", "d"]],
    "risk": {"a": 0.1, "b": 0.0, "c": 0.1, "d": 0.2},
    "first": {"a": ["b", [], 2], "b": ["b", [], 1], "c": ["c", ["c", "d"], 2], "d": ["d", ["c", "d"], 2]},
}


def figures(counts: Counts) -> dict[str, float]:
    return {figure.what: float(figure.value(counts.array())) for figure in FIGURES}


def test_a_perfect_answer_is_counted_as_one():
    found = figures(count(PERFECT, LABELS, RELATIONS))
    for figure in FIGURES:
        if figure.what != "Brier score of risk":
            assert found[figure.what] == (1.0 if figure.better > 0 else 0.0), figure.what
    assert found["Brier score of risk"] == pytest.approx((0.01 + 0.01 + 0.04) / 4)
    assert chances(PERFECT, LABELS) == [(0.9, 1), (0.8, 1), (0.6, 1)]


@pytest.mark.parametrize(
    ("change", "figure", "value"),
    [
        ({"relations": [["b", "a", "touch"], ["c", "d", "touch"]]}, "relations right", 2 / 3),
        ({"relations": [*PERFECT["relations"], ["a", "c", "touch"]]}, "false contacts", 1.0),
        ({"dependencies": PERFECT["dependencies"][1:]}, "dependencies found", 2 / 3),
        ({"dependencies": [*PERFECT["dependencies"], ["a", "d", "x", 0.5]]}, "false dependencies", 1 / 4),
        ({"dependencies": PERFECT["dependencies"][1:]}, "F1 of the closure", 0.8),
        ({"groups": [["c", "d"], ["a", "b"]]}, "objects in false cycles", 2.0),
        ({"groups": []}, "safe orders", 0.0),  # c is taken and d moves
        ({"order": ["a", "b", "c", "d"]}, "safe orders", 0.0),
        ({"order": ["b", "a", "c"]}, "safe orders", 0.0),  # d is not taken at all
        ({"first": {**PERFECT["first"], "a": ["a", [], 1]}}, "first removals that disturb", 1 / 4),
        # a group excuses only what truly cycles
        ({"first": {**PERFECT["first"], "a": ["a", ["a", "b"], 2]}}, "first removals that disturb", 1 / 4),
        ({"first": {**PERFECT["first"], "b": ["a", [], 2]}}, "needless removals", 1.0),
    ],
)
def test_each_fault_of_an_answer_is_counted(change, figure, value):
    found = figures(count({**PERFECT, **change}, LABELS, RELATIONS))
    assert found[figure] == pytest.approx(value)


def test_what_is_refused_has_no_answer_and_found_nothing():
    relations = {key: PERFECT[key] for key in ("names", "objects", "relations")}
    found = count({**relations, "refused": "InvalidInput: up is not known"}, LABELS, RELATIONS)
    assert (found.unanswered, found.missed, found.safe, found.related) == (1, 3, 0, 3)
    assert count({"refused": "gone"}, LABELS, RELATIONS).pairs == 0


def test_what_no_camera_saw_is_asked_of_nobody():
    unseen = {
        **PERFECT,
        "names": [*"abc", "table"],
        "objects": [*"abc"],
        "relations": PERFECT["relations"][:1],
        "dependencies": PERFECT["dependencies"][:1],
        "order": [*"bac"],
        "groups": [],
    }
    found = count(unseen, LABELS, RELATIONS)
    assert (found.missed, found.safe, found.pairs) == (0, 1, 2)


def test_paired_differences_tell_chance_from_change():
    rng = np.random.default_rng(0)
    f1 = next(figure for figure in FIGURES if figure.what == "F1 of the closure")
    theirs = np.zeros((200, len(COLUMN)))
    theirs[:, COLUMN["right"]], theirs[:, COLUMN["missed"]] = rng.integers(1, 9, (2, 200))
    value, (low, high) = difference(f1, theirs, theirs)
    assert value == low == high == 0.0
    ours = theirs.copy()
    ours[::4, COLUMN["false"]] += 1
    value, (low, high) = difference(f1, ours, theirs)
    assert low < value < high < 0.0, "a little worse everywhere is surely worse"
    ours = theirs.copy()
    ours[0, COLUMN["false"]] += 1
    value, (low, high) = difference(f1, ours, theirs)
    assert low < value < 0.0 == high, "one scene may be chance"


@pytest.mark.parametrize("how", [*INACCURATE, *WRONG])
def test_masks_are_corrupted_as_their_name_says(how):
    label = np.full((80, 80), 3)
    label[20:40, 10:40], label[20:40, 40:60] = 1, 2
    found, names, wrong = corrupt(label, ["a", "b", "table"], how, "table", np.random.default_rng(0))
    again = corrupt(label, ["a", "b", "table"], how, "table", np.random.default_rng(0))[0]
    assert (found != label).any() and (found == again).all()
    gone = {"a", "b"} - {names[number - 1] for number in np.unique(found)}
    assert set(wrong.without) == (gone if how == "missing" else set())
    assert bool(gone) == (how in ("missing", "merged")) and bool(wrong.wrong) == (how in WRONG[1:])
    assert len(names) == 3 + (how in ("split", "ghost"))
    if how in INACCURATE:  # a band along borders and no more
        assert (found != label).sum() <= 4 * int(how[-1]) * 150 and set(np.unique(found)) <= {1, 2, 3}


def test_what_is_taken_from_under_a_missing_mask_and_what_is_said_of_masks_is_counted():
    bare = {**PERFECT, "first": {"a": ["a", [], 1]}, "assumptions": ["the mask of 'c' is level with 'table'"]}
    found = count(bare, LABELS, RELATIONS, MaskFaults(without=("b",), wrong=("c", "d")))
    assert (found.covered, found.bared, found.faulty, found.said, found.true) == (1, 1, 2, 1, 0)
    found = count(bare, LABELS, RELATIONS)
    assert (found.covered, found.bared, found.faulty, found.true, found.alarms) == (0, 0, 0, 4, 1)


def test_floors_only_rise(tmp_path):
    f1, false = ("pool", "whole", "F1 of the closure"), ("pool", "whole", "false contacts")
    first = Floors({}).raised({f1: 0.9, false: -0.02}, {f1: 0.02, false: 0.01}, "a2ac90c")
    assert (first.floors[f1].floor, first.floors[false].floor) == pytest.approx((0.87, 0.035))
    worse = first.raised({f1: 0.88, false: -0.03}, {}, "b")
    assert (worse.floors[f1].floor, worse.floors[false].floor) == pytest.approx((0.88, 0.03))
    assert worse.raised({f1: 0.5, false: -0.5}, {}, "c").floors == worse.floors
    file = tmp_path / "truth.json"
    file.write_text(worse.text())
    assert Floors.read(file).floors == worse.floors
    told = {row.what.partition(":")[0]: row for row in worse.rows({f1: 0.86, false: -0.01})}
    assert (told["F1 of the closure"].ok, told["false contacts"].ok) == (False, True)
    file.write_text('{"floors": 3}')
    with pytest.raises(InvalidInput, match="holds no floors"):
        Floors.read(file)


def test_the_floors_of_this_tree_are_of_all_views():
    floors = Floors.read(FLOORS).floors
    of_masks = {"taken at once from under what has no mask, in silence", "masks wrong in kind that are said"}
    decide = {figure.what for figure in FIGURES if figure.worst is not None} - of_masks
    assert {(view, figure) for which, view, figure in floors if which == gate.POOL} == {
        (view, figure) for view in VIEWS for figure in decide
    }


@pytest.mark.parametrize("change", CHANGES, ids=lambda change: change.name)
def test_what_is_planted_stands_in_the_code_once(change):
    assert (ROOT / change.file).read_text().count(change.before) == 1
    assert change.after != change.before


@pytest.fixture
def version(tmp_path: Path) -> Version:
    return today(tmp_path / "versions")


@pytest.fixture
def given(tmp_path: Path, stack: RestingScene) -> Path:
    path = tmp_path / "stack.npz"
    np.savez_compressed(path, **seen(stack, 0, 0))
    return path


def test_a_version_answers_in_a_process_of_its_own_and_is_not_asked_twice(
    version, given, tmp_path, monkeypatch
):
    question = Question("stack", given, ("low", "high"))
    said: list[str] = []
    found = answers(version, [question], tmp_path / "kept", said.append)[question]
    assert found["dependencies"][0][:2] == ["high", "low"]
    assert found["first"] == {"low": ["high", [], 2], "high": ["high", [], 1]}
    assert found["order"].index("high") < found["order"].index("low")
    assert len(said) == 1
    with (tmp_path / "kept" / f"{version.key}.jsonl").open("a") as file:
        file.write('{"key": "0123", "ans')  # the run was killed as it wrote
    monkeypatch.delattr(answers_module._Asked, "_start")  # no process can be started
    assert answers(version, [question], tmp_path / "kept", said.append)[question] == found
    assert len(said) == 1


def test_another_version_than_the_one_meant_is_not_asked(version, given, tmp_path):
    folder = tmp_path / "a:b"  # which a list of paths takes apart
    version.folder.rename(folder)
    with pytest.raises(ToppleError, match="cannot be asked"):
        answers(replace(version, folder=folder), [Question("stack", given)], tmp_path / "kept", silent)


def test_a_fault_of_one_question_costs_that_one(version, given, tmp_path):
    asked = version.folder / "topple" / "planner" / "__init__.py"
    asked.write_text(
        asked.read_text() + "\n\nimport os\nfrom topple.planner.planning import order as _order\n"
        "_real = _order.order\n\n\ndef order(scene, targets=None, **options):\n"
        "    if targets == ['low']:\n        os._exit(3)\n"
        "    if targets == ['high']:\n        raise ZeroDivisionError('planted')\n"
        "    return _real(scene, targets, **options)\n"
    )
    questions = [
        Question("dies", given, ("low",)),
        Question("fails", given, ("high",)),
        Question("well", given),
    ]
    dies, fails, well = answers(version, questions, tmp_path / "kept", silent).values()
    assert dies == {"refused": "the process that was asked is gone", "fault": True}
    assert fails == {"refused": "ZeroDivisionError: planted", "fault": True}
    assert "refused" not in well


@in_checkout
def test_a_commit_is_kept_as_it_was(tmp_path):
    found = of_commit("HEAD", tmp_path)
    assert found.name == (commit_now() or "").rstrip("+")
    assert (found.folder / "topple" / "topology" / "scene" / "scene.py").is_file()
    assert of_commit("HEAD", tmp_path) == found
    code = "import topple, topple.planner; print(topple.__file__)"
    said = subprocess.run(
        [sys.executable, "-c", code], env={"PYTHONPATH": str(found.folder)}, capture_output=True, text=True,
        check=True,
    )  # fmt: skip
    assert Path(said.stdout.strip()) == found.folder / "topple" / "__init__.py"
    with pytest.raises(InvalidInput, match="is no commit"):
        of_commit("--help", tmp_path)


def test_a_worse_version_is_refused_against_a_better_one_and_below_its_floors(
    version, stack, tmp_path, monkeypatch
):
    labels, relations = labelled(stack)
    scenes = [
        pool.PoolScene("designed", "over", 7 + k, pool.shapes_of(stack), labels, relations) for k in range(2)
    ]
    blind = planted([replace(CHANGES[5], name="blind")], version, tmp_path / "versions")
    path = blind.folder / "topple" / CHANGES[4].file
    path.write_text(path.read_text().replace("return tuple(with", "return () and tuple(with"))
    path = blind.folder / "topple" / "planner" / "decide" / "disturbance.py"
    path.write_text(path.read_text().replace("over.evasion > least", "over.evasion > 9.0"))
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(gate, "FLOORS", tmp_path / "truth.json")
    monkeypatch.setattr(gate, "few", lambda: scenes)
    monkeypatch.setattr(gate, "VARIANTS", ("half",))
    monkeypatch.setattr(gate, "of_commit", lambda commit, cache: version)
    good = bench("truth", quick=True, write=True)
    assert json.loads((tmp_path / "truth.json").read_text())["format"] == "topple.truth"
    assert all(row["ok"] is not False for row in good["rows"])
    monkeypatch.setattr(gate, "today", lambda cache: blind)
    bad = bench("truth", quick=True, against="a commit")
    missed = [row["what"] for row in bad["rows"] if row["ok"] is False]
    assert any(what.startswith("F1 of the closure: pool, whole") for what in missed), missed
    lost = [what for what in missed if what.startswith("F1 of the closure, lost: pool, whole")]
    assert lost, missed
    assert bad["rows"][-1]["value"] == len(bad["rows"][-1]["differences"]) > 0
    assert any("F1 of the closure" in line for line in markdown(bad))


def test_given_scenes_are_rendered_once(stack, tmp_path):
    scene = pool.PoolScene("designed", "over", 7, pool.shapes_of(stack), {}, {})
    said: list[str] = []
    cases = pool_cases([scene], tmp_path, said.append, looks=2)
    assert [(case.view, len(case.looks)) for case in cases] == [
        ("whole", 0),
        ("1 camera", 1),
        ("3 cameras", 1),
    ]
    assert len(said) == 5
    assert pool_cases([scene], tmp_path, said.append)[0].question.path.is_file()
    assert len(said) == 5
