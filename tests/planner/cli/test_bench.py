"""`topple bench`: the contract's document, exit codes, and that small configurations run. Never a time."""

import json
import re
import runpy
from itertools import combinations
from pathlib import Path

import numpy as np
import pytest

from topple.benchmarks import motion, order, relate
from topple.benchmarks.clock import cpu_medians
from topple.benchmarks.clouds import household
from topple.benchmarks.commands.bench import markdown
from topple.benchmarks.document import BENCHES, CHECKS, bench, machine
from topple.benchmarks.guesses import Guess, box_above, guesses, naive, top_height
from topple.benchmarks.markdown import replaced_table
from topple.benchmarks.plain_numpy import plain_numpy
from topple.benchmarks.row import Row, faster, longer
from topple.benchmarks.scores import Score, f1_interval, is_safe, score, share_interval
from topple.planner.cli.main import main
from topple.topology.scene.scene import Scene

KEYS = {"what", "value", "unit", "baseline", "baseline_value", "ratio", "bar", "ok"}
TINY_RELATE = relate.Extent(
    (relate.Size(300, 1, 0.001, 1000),), crowds=(3, 5), tracked=6, points=100, crowds_by_default=False,
    frame=False, repeats=1,
)  # fmt: skip
ABOVE = {"a": {"b": 1, "c": 0}, "b": {"a": 0, "c": 0}, "c": {"a": None, "b": 0}}  # b lies on a


def _box(lower: tuple[float, ...], upper: tuple[float, ...]) -> np.ndarray:
    return np.random.default_rng(0).uniform(lower, upper, (400, 3))


@pytest.fixture
def stack() -> Scene:
    """A box on a box, a third beside them."""
    clouds = {
        "low": _box((0, 0, 0), (0.1, 0.1, 0.1)),
        "top": _box((0.02, 0.02, 0.1), (0.08, 0.08, 0.15)),
        "beside": _box((0.3, 0, 0), (0.4, 0.1, 0.12)),
        "table": _box((-1, -1, -0.02), (1, 1, 0)),
    }
    return Scene(clouds, fixed=["table"], up=(0, 0, 1))


@pytest.mark.parametrize(
    ("row", "ok"),
    [
        (Row("x", 0.94, "", bar=">= 0.93"), True),
        (Row("x", 0.92, "", bar=">= 0.93"), False),
        (Row("x", 0, "pairs", bar="0"), True),
        (Row("x", 1, "pairs", bar="0"), False),
        (Row("x", 1.0, "s"), None),
        (faster("x", 1.0, "y", 12.0, ">= 12x"), True),
        (faster("x", 1.0, "y", 11.0, ">= 12x"), False),
        (longer("x", 1.1, "y", 1.0, "<= 1.2x"), True),
        (longer("x", 1.3, "y", 1.0, "<= 1.2x"), False),
        (longer("x", 1.0, "y", 16.0, "<= 1/15"), True),
        (longer("x", 1.0, "y", 14.0, "<= 1/15"), False),
        (Row("x", 100.0, "s", bar=">= 2x"), False),
    ],
)
def test_a_bar_is_cleared_or_missed(row, ok):
    assert row.ok is ok
    assert set(row.to_json()) == KEYS
    assert row.to_json()["ok"] is ok


def test_a_bar_nobody_can_read_is_no_bar():
    with pytest.raises(ValueError, match="is no bar"):
        assert Row("x", 1.0, "", bar="good").ok


def test_calls_take_turns():
    said: list[str] = []
    assert len(cpu_medians([lambda: said.append("a"), lambda: said.append("b")], 2)) == 2
    assert said == ["a", "b", "a", "b"]


def test_relate_prints_the_contracts_document(monkeypatch, capsys):
    monkeypatch.setattr(relate, "QUICK", TINY_RELATE)
    code = main(["bench", "relate", "--quick", "--json"])
    document = json.loads(capsys.readouterr().out)
    assert (document["format"], document["format_version"]) == ("topple.bench", 1)
    assert document["bench"] == "relate"
    assert document["machine"]["cores"] >= 1
    assert all(set(row) == KEYS for row in document["rows"])
    assert code == int(any(row["ok"] is False for row in document["rows"]))
    (same,) = (row for row in document["rows"] if "another matrix" in row["what"])
    assert same["value"] == 0


def test_a_missed_bar_is_code_1_and_said(monkeypatch, typed):
    def missing(quick: bool, seed: int, progress: object) -> list[dict[str, object]]:
        return [Row("speed", 1.0, "s", "another", 2.0, 2.0, ">= 3x").to_json(), Row("count", 4, "").to_json()]

    monkeypatch.setattr(motion, "rows", missing)
    out = typed("bench", "motion", "--quick", code=1).out
    assert "MISSED" in out
    assert "0 of 1 bars cleared, 1 missed" in out


@pytest.mark.parametrize("argv", [["bench", "nonsense"], ["bench", "relate", "--seed", "-1"]])
def test_wrong_use_is_code_2(argv, typed):
    assert typed(*argv, code=2).out == ""


def test_machines_are_told_apart_without_their_names():
    assert {"system", "processor", "cores", "python", "libraries"} <= machine().keys()
    json.dumps(machine())


@pytest.mark.slow
def test_order_runs_on_one_small_pile(monkeypatch):
    monkeypatch.setattr(order, "QUICK", order.Extent(1, views=(0,), scenes=1))
    monkeypatch.setattr(order, "FIRST_PILE", 502)
    document = bench("order", quick=True)
    assert all(set(row) - {"interval"} == KEYS for row in document["rows"])
    assert {row["baseline"] for row in document["rows"]} >= set(guesses())
    for row in document["rows"]:
        if "interval" in row:
            low, high = row["interval"]
            assert low <= row["value"] + 1e-9
            assert high >= row["value"] - 1e-9


def test_plain_numpy_leaves_no_point_out():
    scene = household(200, 1)
    found = plain_numpy(scene.clouds, 0.002)
    assert {frozenset(pair) for pair in found} == {frozenset(pair) for pair in combinations(scene.names, 2)}
    for (a, b), matrix in found.items():
        assert matrix.sum(axis=1).tolist() == [len(scene.clouds[a]), len(scene.clouds[b])]


def test_the_rules_of_thumb_take_the_top_of_a_stack_first(stack):
    assert box_above(stack).pairs == {("top", "low")}
    assert naive(stack).pairs == {("top", "low")}
    assert top_height(stack).order == ("top", "beside", "low")
    for guess in guesses().values():
        assert set(guess(stack, 0).order) == set(stack.movable)


def test_a_perfect_answer_scores_all():
    found = score(Guess(frozenset({("b", "a")}), ("b", "a", "c")), ABOVE, "abc")
    assert found == Score(right=1, safe=1, piles=1, lean=3, targets=3, steps=3)
    assert found.f1 == found.precision == found.recall == 1.0


def test_what_is_wrong_is_counted_once():
    found = score(Guess(frozenset({("a", "b"), ("a", "c")}), ("a", "b", "c")), ABOVE, "abc")
    assert (found.right, found.false, found.missed, found.safe, found.lean) == (0, 1, 1, 0, 2)


def test_the_unseen_is_left_out():
    found = score(Guess(frozenset(), ("a", "c")), ABOVE, "ac")
    assert found == Score(safe=1, piles=1, lean=2, targets=2, steps=2)


def test_an_order_has_to_take_everything():
    assert is_safe(Guess(frozenset(), ("b", "a", "c")), ABOVE, "abc")
    assert not is_safe(Guess(frozenset(), ("b", "a")), ABOVE, "abc")


def test_a_group_excuses_a_true_cycle_only():
    cycle = {"a": {"b": 1}, "b": {"a": 1}}
    together = Guess(frozenset(), ("a", "b"), groups=(("a", "b"),))
    assert is_safe(together, cycle, "ab")
    assert not is_safe(Guess(frozenset(), ("a", "b")), cycle, "ab")
    assert not is_safe(together, {"a": {"b": 1}, "b": {"a": 0}}, "ab")


def test_intervals_hold_the_figure():
    scores = [Score(right=3, false=1), Score(right=2, missed=2), Score(right=5)]
    low, high = f1_interval(scores)
    assert low <= sum(scores, Score()).f1 <= high
    assert share_interval(0, 0) == (0.0, 100.0)
    low, high = share_interval(26, 26)
    assert 85 < low < 100
    assert high == pytest.approx(100)


def test_a_table_for_the_docs_has_a_column_for_each_heading():
    row = {"what": "orders | a second", "value": 12.5, "unit": "/s"}
    full = {**row, "baseline": "plain", "baseline_value": 5.0, "ratio": 2.5, "bar": "at least 2x", "ok": True}
    nothing = dict.fromkeys(("baseline", "baseline_value", "ratio", "bar", "ok"))
    bare = {**row, **nothing, "interval": (12.0, 13.0)}
    machine = {"processor": "a processor", "cores": 2}
    document = {"bench": "order", "quick": True, "seed": 3, "machine": machine, "rows": [full, bare]}
    head, rule, *cells, blank, source = markdown(document)
    assert head == "| what | value | baseline | its value | ratio | bar | bar held |"
    assert rule == "| --- | ---: | --- | ---: | ---: | --- | --- |"
    assert cells[0] == "| orders \\| a second | 12.5 /s | plain | 5 /s | 2.5x | at least 2x | ok |"
    assert cells[1] == "| orders \\| a second | 12.5 /s [12, 13] |  |  |  |  |  |" and blank == ""
    assert source == "`topple bench order`: --quick, seed 3, a processor, 2 cores."


def test_figures_of_several_methods_stand_side_by_side():
    theirs = {"baseline": "paper", "baseline_value": 5.0}
    rows = [
        Row("scene 1", 6.0, "pairs", **theirs, bar=">= 6", interval=(5.9, 6.1), column="ours"),
        Row("scene 1", 2.25, "pairs", **theirs, column="boxes"),
        Row("scene 2", 3.0, "pairs", column="boxes"),
    ]
    machine = {"processor": "a processor", "cores": 2}
    written = [row.to_json() for row in rows]
    head = {"bench": "motion", "part": "plans", "quick": False, "seed": 0, "machine": machine}
    assert markdown({**head, "rows": written}) == [
        "| what | value | baseline | its value | bar | bar held |",
        "| --- | ---: | --- | ---: | --- | --- |",
        "| scene 1, ours | 6 pairs [5.9, 6.1] | paper | 5 pairs | >= 6 | ok |",
        "",
        "| what | ours | boxes | paper |",
        "| --- | ---: | ---: | ---: |",
        "| scene 1 [pairs] | 6 | 2.25 | 5 |",
        "| scene 2 [pairs] |  | 3 |  |",
        "",
        "`topple bench motion --part plans`: seed 0, a processor, 2 cores.",
    ]


def test_a_page_takes_a_table_between_its_marks(tmp_path, typed):
    page = tmp_path / "page.md"
    page.write_text("before\n<!-- table of topple bench speed -->\nold\n<!-- end of table -->\nafter\n")
    err = typed("bench", "order", "--page", page, code=2).err
    assert "expected '<!-- table of topple bench order -->'" in err
    new = replaced_table(page.read_text(), "speed", ["| a |", "| --- |"])
    assert new.splitlines()[2:4] == ["| a |", "| --- |"] and "old" not in new
    assert new.startswith("before\n<!--") and new.endswith("<!-- end of table -->\nafter\n")
    assert replaced_table(new, "speed", ["| a |", "| --- |"]) == new
    err = typed("bench", "motion", "--part", "plans", "--page", page, code=2).err
    assert "expected '<!-- table of topple bench motion --part plans -->'" in err
    for wrong in (["bench", "--page", str(page)], ["bench", "speed", "--page", str(tmp_path)]):
        assert typed(*wrong, code=2).err.count("\n") == 1


def test_tables_in_the_pages_are_of_benches_and_have_rows():
    pages = "".join(path.read_text() for path in (Path(__file__).parents[3] / "benchmarks").glob("*.md"))
    pages += "".join(
        (Path(__file__).parents[3] / f"docs/{name}.md").read_text() for name in ("results", "scenes")
    )
    marks = r"<!-- table of topple bench (\w+)(?: --\w+ \w+)? -->\n(.*?)\n<!-- end of table -->"
    marked = re.findall(marks, pages, re.DOTALL)
    assert len(marked) == pages.count("<!-- table of") == pages.count("<!-- end of table -->")
    assert {name for name, _ in marked} == {*BENCHES, *CHECKS}
    assert all(table.startswith("| what |") and table.count("\n") > 3 for _, table in marked)


def test_the_table_of_the_readme_is_that_of_the_benches():
    root = Path(__file__).parents[3]
    results = (root / "docs/results.md").read_text()
    counts = re.findall(r"nothing disturbed: demo [^|]*\| (\d+) \| (\d+) \|", results)
    tried, held = (sum(map(int, column)) for column in zip(*counts, strict=True))
    readme, trust = ((root / name).read_text() for name in ("README.md", "docs/trust.md"))
    assert all(f"{held} of {tried}" in page for page in (results, trust))
    table = runpy.run_path(str(root / "docs/figures/table.py"))
    assert readme.count(" % | `") == 5 and table["readme"](readme) == readme
