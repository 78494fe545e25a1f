"""Frozen behaviour: what counts in a digest, what is told of a difference, when the file may be written."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from topple.benchmarks import frozen, frozen_cases
from topple.benchmarks.behaviour import BEHAVIOUR, EPISODE, ORDER, PLAN, RELATIONS, digest
from topple.benchmarks.frozen import FILE, Frozen, differences, merged, rows
from topple.benchmarks.frozen_cases import EPISODES, PILES, PLANS, Item, cases
from topple.planner.cli.main import main
from topple.planner.formats.plan_format import Plan
from topple.planner.planning.order import order
from topple.topology.errors import InvalidInput
from topple.topology.relations import relate
from topple.topology.scene import Scene


@pytest.fixture(scope="module")
def scene() -> Scene:
    """A box on a box, on a table."""
    rng = np.random.default_rng(0)
    low = rng.uniform([0, 0, 0], [0.1, 0.1, 0.1], (400, 3))
    top = rng.uniform([0.02, 0.02, 0.1], [0.08, 0.08, 0.15], (400, 3))
    table = rng.uniform([-0.5, -0.5, -0.02], [0.5, 0.5, 0], (400, 3))
    return Scene({"low": low, "top": top, "table": table}, fixed=["table"], up=(0, 0, 1))


@pytest.fixture
def one_pile(monkeypatch: pytest.MonkeyPatch) -> None:
    """Of all that is frozen, the first generated pile, which takes seconds."""
    monkeypatch.setattr(frozen_cases, "EPISODES", ())
    monkeypatch.setattr(frozen_cases, "PLANS", ())
    monkeypatch.setattr(frozen_cases, "PILES", 1)
    monkeypatch.setattr(frozen_cases, "PILES_QUICK", 1)


def _of_gap(gap: float) -> dict[str, str]:
    return digest({"relations": [{"gap": gap}]}, RELATIONS)


def test_last_bits_do_not_count_and_a_tenth_of_a_millimetre_does() -> None:
    assert _of_gap(0.1 + 0.2) == _of_gap(0.3)
    assert _of_gap(-1e-12) == _of_gap(0.0) == _of_gap(0)
    for gap in (0.0, 0.01234, 0.012345, -0.4, 1.99995):
        assert _of_gap(gap) != _of_gap(gap + 1e-4) != _of_gap(gap - 1e-4)


def _grown(value: Any) -> Any:
    """JSON data with one more key in every object that has keys of its own."""
    if isinstance(value, list):
        return [_grown(entry) for entry in value]
    if isinstance(value, dict):
        return {"evidence": ["touch"], **{key: v if key == "risk" else _grown(v) for key, v in value.items()}}
    return value


def test_added_keys_do_not_count(scene: Scene) -> None:
    for document, paths in ((relate(scene).to_json(), RELATIONS), (order(scene).to_json(), ORDER)):
        assert _grown(document) != document
        assert digest(_grown(document), paths) == digest(document, paths)


@pytest.mark.parametrize("key", ["relation", "matrix", "gap", "gap_exact", "confidence", "observed", "a"])
def test_every_key_of_a_relation_counts(scene: Scene, key: str) -> None:
    document = relate(scene).to_json()
    whole = digest(document, RELATIONS)
    del document["relations"][0][key]
    assert digest(document, RELATIONS) != whole


@pytest.mark.parametrize(
    ("change", "parts"),
    [
        (lambda found: found["order"].reverse(), {"order"}),
        (lambda found: found["dependencies"][0].update(reason="leaning"), {"dependencies"}),
        (lambda found: found["supports"].pop(), {"supports", "confidence"}),
        (lambda found: found["risk"].update(top=0.99), {"risk"}),
        (lambda found: found["groups"].append(["low", "top"]), {"cycles"}),
        (lambda found: found["access"].append({"first": "top", "then": "low", "reason": "hand"}), {"access"}),
        (lambda found: found["supports"].reverse(), set[str]()),
        (lambda found: found["explanation"].append("so it is"), set[str]()),
    ],
)
def test_what_of_an_order_counts(
    scene: Scene, change: Callable[[dict[str, Any]], None], parts: set[str]
) -> None:
    document = order(scene).to_json()
    assert document["order"] == ["top", "low"]
    assert len(document["supports"]) > 1
    before = digest(document, ORDER)
    change(document)
    after = digest(document, ORDER)
    assert {part for part in before if before[part] != after[part]} == parts


def test_a_plan_counts_but_for_the_time_it_took_and_its_words() -> None:
    steps = [{"object": "can", "action": "free", "reason": "asked for", "planning_seconds": 3.0}]
    plan = {"steps": steps, "planning_seconds": 3.0, "seconds": 8.0}
    slow = {
        "steps": [{**steps[0], "reason": "", "planning_seconds": 9.0}],
        "planning_seconds": 9.0,
        "seconds": 8.0,
    }
    assert digest(plan, PLAN) == digest(slow, PLAN)
    assert digest(plan, PLAN) != digest({**plan, "seconds": 8.1}, PLAN)
    named = {path.split(".")[0] for paths in PLAN.values() for path in paths}
    assert named <= set(Plan.__struct_fields__)


def test_other_actions_are_another_episode() -> None:
    step = {"object": "can", "action": "remove", "robot_seconds": 12.5, "seconds": 40.0}
    run = {"success": True, "stopped": "", "violations": [], "steps": [step]}
    assert digest(run, EPISODE) == digest({**run, "steps": [{**step, "seconds": 50.0}]}, EPISODE)
    for change in ({"object": "box"}, {"action": "free"}, {"robot_seconds": 12.6}):
        assert digest(run, EPISODE) != digest({**run, "steps": [{**step, **change}]}, EPISODE)
    assert digest(run, EPISODE) != digest({**run, "violations": ["box fell"]}, EPISODE)


def test_the_file_is_of_the_stated_version_and_has_all_that_topple_makes_by_itself() -> None:
    kept = Frozen.read(FILE)
    assert kept.behaviour == BEHAVIOUR
    known = [case.what for case in cases(False, None, None)]
    assert len(known) == len(EPISODES) + len(PLANS) + PILES
    assert all(any(what.startswith(one) for what in kept.own) for one in known)
    assert all(any(what.startswith(one) for one in known) for what in kept.own)


def _item(what: str, word: str) -> Item:
    return Item(what, digest({"order": [word]}, ORDER), word)


def test_a_difference_is_told_and_what_is_new_is_none() -> None:
    before = {"a": _item("a", "x"), "b": _item("b", "x"), "gone": _item("gone", "x")}
    found = differences(before, {"a": _item("a", "x"), "b": _item("b", "y"), "c": _item("c", "y")}, before)
    assert [(one.what, one.parts, one.was, one.now) for one in found] == [
        ("b", ("order",), "x", "y"),
        ("gone", (), "x", "not there any more"),
    ]


def test_of_the_same_version_what_was_not_computed_is_kept_and_of_another_it_is_not() -> None:
    now = Frozen(own={"a": _item("a", "x")})
    kept = Frozen(own={"b": _item("b", "x")}, recorded={"c": _item("c", "x")})
    assert set(merged(kept, now).items) == {"a", "b", "c"}
    assert set(merged(Frozen(BEHAVIOUR - 1, own=kept.own, recorded=kept.recorded), now).items) == {"a"}


def test_a_file_is_read_back_equal_one_item_a_line(tmp_path: Path) -> None:
    kept = Frozen(own={"a": _item("a", "x"), "b": _item("b", "y")})
    (tmp_path / "frozen.json").write_text(kept.text())
    assert Frozen.read(tmp_path / "frozen.json") == kept
    assert sum('"what"' in line for line in kept.text().splitlines()) == 2


@pytest.mark.slow
def test_a_changed_order_is_told_and_not_written_without_a_raised_version(
    one_pile: None, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "frozen.json"
    command = ["bench", "frozen", "--file", str(file)]
    assert main([*command, "--write"]) == 0
    assert main(command) == 0
    (what,) = (name for name in Frozen.read(file).own if name.endswith("3 cameras: order"))
    document = json.loads(file.read_text())
    (entry,) = (one for one in document["own"] if one["what"] == what)
    true = dict(entry)
    entry |= {"digest": {**entry["digest"], "order": "00000000"}, "summary": "another order"}
    file.write_text(json.dumps(document))
    other = file.read_text()
    capsys.readouterr()

    assert main([*command, "--quick"]) == 1
    said = capsys.readouterr().out
    assert f"{what} (order)\n  was  another order\n  now  {true['summary']}\n" in said

    assert main([*command, "--write"]) == 1
    assert "not written: raise" in " ".join(capsys.readouterr().out.split())
    assert file.read_text() == other

    monkeypatch.setattr(frozen, "BEHAVIOUR", BEHAVIOUR + 1)
    with pytest.raises(InvalidInput, match="leave --quick out"):
        rows(True, 0, lambda text: None, file=file, write=True)
    rewritten = Frozen(BEHAVIOUR - 1, own=Frozen.read(file).own)
    monkeypatch.setattr(frozen, "BEHAVIOUR", BEHAVIOUR)
    file.write_text(rewritten.text())
    assert main([*command, "--write"]) == 0
    assert json.loads(file.read_text())["behaviour"] == BEHAVIOUR
    assert Frozen.read(file).own[what] == Item(**true)


def test_nothing_is_lost_to_a_raised_version_unsaid(tmp_path: Path) -> None:
    file = tmp_path / "frozen.json"
    file.write_text(Frozen(BEHAVIOUR - 1, recorded={"a": _item("a", "x")}).text())
    with pytest.raises(InvalidInput, match="give --data"):
        rows(False, 0, lambda text: None, file=file, write=True)
    file.write_text(Frozen(BEHAVIOUR + 1).text())
    with pytest.raises(InvalidInput, match="raise BEHAVIOUR"):
        rows(False, 0, lambda text: None, file=file, write=True)


@pytest.mark.parametrize("text", [None, "", "[]", '{"format": "topple.order", "format_version": 1}'])
def test_another_file_is_wrong_use(text: str | None, tmp_path: Path) -> None:
    file = tmp_path / "frozen.json"
    if text is not None:
        file.write_text(text)
    assert main(["bench", "frozen", "--file", str(file)]) == 2
