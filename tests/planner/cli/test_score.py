"""What `topple score` counts, against counts by hand."""

import json
from pathlib import Path

import numpy as np
import pytest

from topple.planner.cli.main import main
from topple.robots.shapes.boxes import box
from topple.topology.io import load_scene

LABELS = {
    "1": {"2": 1, "3": 0, "4": None},
    "2": {"1": 0, "3": 0, "4": 0},
    "3": {"1": 0, "2": 1, "4": 0},
    "4": {"1": 0, "2": 0, "3": 0},
}
"""The second block lies on the first, and is said to hold the third as well; nobody sees the fourth."""


@pytest.fixture
def pile(tmp_path: Path) -> Path:
    """A recorded pile: a block on a block and one beside them, on a table."""
    rng = np.random.default_rng(0)
    x, y = np.meshgrid(np.arange(-0.3, 0.3, 0.008), np.arange(-0.3, 0.3, 0.008))
    clouds = {
        "table": np.column_stack([x.ravel(), y.ravel(), np.zeros(x.size)]),
        "1": box("1", (0.05, 0.05, 0.05)).surface(1500, rng),
        "2": box("2", (0.05, 0.05, 0.05)).surface(1500, rng) + np.array([0.0, 0.0, 0.0502]),
        "3": box("3", (0.05, 0.05, 0.05)).surface(1500, rng) + np.array([0.2, 0.0, 0.0]),
    }
    stored = {name: np.round(cloud * 1e4).astype(np.int16) for name, cloud in clouds.items()}
    np.savez(
        tmp_path / "pile.npz",
        labels=json.dumps(LABELS),
        up=[0.0, 0.0, 1.0],
        fixed=["table"],
        viewpoints1=[[0.5, 0.0, 0.6]],
        **{f"full/{name}": cloud for name, cloud in stored.items()},
        **{f"view1/{name}": cloud for name, cloud in stored.items() if name != "3"},
    )
    return tmp_path / "pile.npz"


def scored(capsys: pytest.CaptureFixture[str], *argv: object) -> list[dict]:
    assert main(["score", *map(str, argv), "--json"]) == 0
    return [json.loads(line) for line in capsys.readouterr().out.splitlines()]


def test_a_view_of_a_recorded_pile_is_a_scene(pile):
    whole, seen = load_scene(pile), load_scene(pile, view="view1")
    assert whole.names == ("table", "1", "2", "3") and seen.names == ("table", "1", "2")
    assert whole.fixed == {"table"} and len(whole.viewpoints) == 0 and len(seen.viewpoints) == 1
    assert np.ptp(whole.clouds["1"], axis=0) == pytest.approx([0.05] * 3, abs=2e-3)


def test_pairs_and_unsafe_steps_are_those_counted_by_hand(pile, capsys):
    (document,) = scored(capsys, pile)
    assert (document["format"], document["labels_format"]) == ("topple.score", "pile")
    assert (document["right"], document["false"], document["missed"]) == (1, 0, 1)
    assert document["f1"] == pytest.approx(2 / 3)
    assert document["missed_pairs"] == [{"first": "2", "then": "3"}]
    assert document["unseen"] == ["4"]
    assert document["unsafe"] == [{"object": "3", "moves": ["2"]}]  # nothing says so but the labels
    assert (document["steps"], document["unsafe_steps"], document["safe"]) == (3, 1, 0)


def test_an_order_of_another_program_is_scored_as_written(pile, tmp_path, capsys):
    edges = [{"first": "1", "then": "2"}, {"first": "2", "then": "3"}]
    theirs = {"format": "topple.order", "order": ["1", "2", "3"], "dependencies": edges, "groups": []}
    (tmp_path / "theirs.json").write_text(json.dumps(theirs), encoding="utf-8")
    (document,) = scored(capsys, tmp_path / "theirs.json", "--labels", pile)
    # of 1 < 2 < 3 follow three pairs: 2 before 3 is right, 1 before 2 and 1 before 3 are false
    assert (document["right"], document["false"], document["missed"]) == (1, 2, 1)
    assert document["unsafe"] == [{"object": "1", "moves": ["2"]}] and document["safe"] == 0


def test_several_scenes_are_pooled(pile, tmp_path, capsys, typed):
    again = tmp_path / "again.npz"
    again.write_bytes(pile.read_bytes())
    *each, everything = scored(capsys, pile, again)
    assert len(each) == 2 and everything["scene"] is None and everything["scenes"] == 2
    for key in ("right", "missed", "steps", "safe"):
        assert everything[key] == sum(document[key] for document in each)
    assert "all 2 scenes: F1 0.667" in typed("score", pile, again, "--orderer", "cautious").out


@pytest.mark.parametrize(
    ("argv", "words"),
    [
        (("PILE", "--labels", "PILE", "PILE"), "1 scenes and 2 files of labels"),
        (("PILE", "PILE"), "a scene is given twice"),
        (("PILE", "--orderer", "cautious", "--verify"), "leave out --orderer"),
        (("PILE", "--view", "view9"), "the pile has no view 'view9': expected full, view1"),
        (("BROKEN", "--labels", "PILE"), "lacks 'order'"),
        (("OTHER", "--labels", "PILE"), "expected a topple.order"),
    ],
)
def test_wrong_use_is_one_line(pile, argv, words, typed):
    broken, other = pile.with_name("broken.json"), pile.with_name("other.json")
    broken.write_text('{"format": "topple.order", "dependencies": []}', encoding="utf-8")
    other.write_text('{"format": "topple.plan"}', encoding="utf-8")
    files = {"PILE": pile, "BROKEN": broken, "OTHER": other}
    printed = typed("score", *(str(files.get(word, word)) for word in argv), code=2)
    assert printed.out == "" and words in printed.err and printed.err.count("\n") == 1
