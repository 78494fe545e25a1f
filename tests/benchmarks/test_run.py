"""Episodes are kept in a journal, counted with intervals, and compared with rules of thumb."""

import json
from pathlib import Path

import numpy as np
import pytest

from topple.benchmarks.episodes import Ending, Episode, play
from topple.benchmarks.frames import frames_in, wanted_of
from topple.benchmarks.journal import Journal
from topple.benchmarks.plans import REARRANGED
from topple.benchmarks.recorded import Frame
from topple.benchmarks.row import Row
from topple.benchmarks.rules import RULES, order_by
from topple.benchmarks.run import collected, endurance, fallback_rows, figures, rows
from topple.benchmarks.series import QUICK, Series
from topple.benchmarks.versions import code_key, commit_now
from topple.planner.decide.beliefs import Beliefs
from topple.robots import scenario
from topple.robots.scenarios import SCENARIOS
from topple.topology.base.errors import InvalidInput
from topple.topology.scene.scene import Scene
from topple.topology.situation.situation import Situation


def _box(x: float, z: float, height: float, rng: np.random.Generator) -> np.ndarray:
    return rng.uniform([x, 0.0, z], [x + 0.05, 0.05, z + height], (400, 3))


@pytest.fixture
def shelf() -> Scene:
    """A can on a book, and a tall bottle far from both, near to the arm at x = -0.5."""
    rng = np.random.default_rng(0)
    table = np.column_stack([rng.uniform(-0.4, 0.4, (4000, 2)), np.zeros(4000)])
    clouds = {"book": _box(0.1, 0, 0.03, rng), "can": _box(0.1, 0.03, 0.1, rng)}
    clouds |= {"bottle": _box(-0.3, 0, 0.3, rng), "table": table}
    return Scene(clouds, fixed=["table"], up=[0, 0, 1])


@pytest.mark.parametrize(
    ("rule", "taken"),
    [
        ("nearest first", ("bottle", "can", "book")),
        ("top height first", ("bottle", "can", "book")),
        ("plain 6IM + height", ("can", "book")),
    ],
)
def test_a_rule_takes_all_that_comes_first_by_it(shelf, rule, taken):
    base = np.eye(4)
    base[0, 3] = -0.5
    found = order_by(rule, base)(Situation(shelf), ("book",), seed=0)
    assert set(found.order) == set(taken)
    assert found.order[-1] == "book"


def test_a_rule_takes_nothing_twice(shelf):
    put_down = Beliefs(alone=frozenset(["bottle"]))
    rule = order_by("top height first", np.eye(4))
    found = rule(Situation(shelf), ("book",), seed=0, beliefs=put_down)
    assert found.order == ("can", "book")


def test_an_ending_is_read_back_equal(tmp_path):
    ending = Ending(Episode("pile", 3, 1, RULES[0]), "hit", ("box_1 was hit",), violated=1, seconds=31.5)
    Journal(tmp_path / "endings.jsonl").add(ending.to_json())
    (entry,) = Journal(tmp_path / "endings.jsonl").entries
    assert Ending.from_json(entry) == ending


def test_a_line_that_was_cut_off_is_left_out_and_the_next_is_whole(tmp_path):
    path = tmp_path / "endings.jsonl"
    kept = Ending(Episode("dishes", 0), "success")
    Journal(path).add(kept.to_json())
    with path.open("a") as file:
        file.write('{"format": "topple.epis')
    with Journal(path) as book:
        book.add(Ending(Episode("dishes", 1), "success").to_json())
    assert [entry["episode"]["seed"] for entry in Journal(path).entries] == [0, 1]


def _played(path: Path, seeds: dict[int, bool], **version: str) -> None:
    lines = [
        {**Ending(Episode("pile", seed), "success" if good else "hit", memory=10**8).to_json(), **version}
        for seed, good in seeds.items()
    ]
    with path.open("a") as file:
        file.writelines(json.dumps(line) + "\n" for line in lines)


@pytest.mark.parametrize("version", [{}, {"commit": "a2ac90c", "code": "0123456789ab"}])
def test_results_of_other_code_do_not_count(version, tmp_path):
    path = tmp_path / "endings.jsonl"
    _played(path, {3: True}, **version)
    with Journal(path) as book:
        assert (book.entries, book.stale) == ([], 1)
        book.add(Ending(Episode("pile", 4), "success").to_json())
    (entry,) = Journal(path).entries
    assert (entry["episode"]["seed"], entry["code"], entry["commit"]) == (4, code_key(), commit_now())


def test_what_was_kept_is_counted_by_the_code_of_the_last_line(tmp_path):
    path = tmp_path / "endings.jsonl"
    _played(path, {0: False, 1: True}, code="one")
    _played(path, {1: True, 2: True, 3: False}, code="other")
    found = rows(False, 0, lambda text: None, path, minutes=0)
    (reached,) = (row for row in found if row["what"].startswith("goal reached"))
    assert "3 of 100 seeds" in reached["what"] and reached["value"] == pytest.approx(200 / 3)


def test_a_comment_or_a_docstring_is_no_other_code(tmp_path):
    def key(name: str, text: str) -> str:
        (tmp_path / name / "topology").mkdir(parents=True)
        (tmp_path / name / "topology" / "one.py").write_text(text)
        return code_key(tmp_path / name)

    plain = key("plain", "x = 1\n\n\ndef f():\n    return x\n")
    assert (
        key("told", '"""What x is."""\n\nx = (1)  # why\n\ndef f():\n    """Give x."""\n    return x\n')
        == plain
    )
    assert key("changed", "x = 2\n\n\ndef f():\n    return x\n") != plain


def test_the_same_seeds_of_two_journals_are_paired(tmp_path):
    ours, theirs = tmp_path / "ours.jsonl", tmp_path / "theirs.jsonl"
    _played(ours, {seed: seed >= 8 for seed in range(40)}, code="new")
    _played(theirs, {seed: True for seed in range(4, 60)}, code="old")
    found = rows(False, 0, lambda text: None, ours, minutes=0, against=str(theirs))
    lost = [row for row in found if "lost against" in row["what"]]
    assert [row["value"] for row in lost] == pytest.approx([100 * 4 / 36] * 2)
    assert "36 seeds of both" in lost[0]["what"]
    assert [row["ok"] for row in lost] == [None, False], "all series together decide"
    with pytest.raises(InvalidInput, match="expected another journal"):
        rows(False, 0, lambda text: None, ours, minutes=0, against=str(ours))


@pytest.mark.slow  # every scene is built
def test_scenes_that_are_rearranged_are_named():
    for name in SCENARIOS:
        with scenario(name) as stage:
            assert (stage.finished is not None) == (name in REARRANGED), name


def test_an_episode_is_kept_with_its_folders_as_they_were_given(tmp_path, monkeypatch):
    (tmp_path / "empty").mkdir()
    monkeypatch.chdir(tmp_path)
    frame = Episode("none", 0, folder="empty")  # no such frame: the episode crashes
    found = collected([frame], lambda text: None, tmp_path / "endings.jsonl")
    assert list(found) == [frame]
    assert [entry["episode"]["folder"] for entry in Journal(tmp_path / "endings.jsonl").entries] == ["empty"]


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"episode": 3}, r"expected an object - at `\$.episode`"),
        ({"episode": {}}, r"no scenario, .* - at `\$.episode`"),
        ({"seconds": "long"}, r"Expected `float`, got `str` - at `\$.seconds`"),
        ({"seconds": float("nan")}, r"NaN is no number of JSON"),
        ({"seconds": 2e15}, r"2000000000000000.0 is none of 0 to 1e\+15 - at `\$.seconds`"),
        ({"seconds": 10**400}, r"at `\$.seconds`"),
        ({"memory": 10**400}, r"at `\$.memory`"),
        ({"steps": -1}, r"at `\$.steps`"),
        ({"placed": 3, "places": 2}, "3 of 2 places"),
        ({"violations": "none"}, r"Expected `array`, got `str` - at `\$.violations`"),
        ({"ending": None}, r"Expected `str`, got `null` - at `\$.ending`"),
    ],
)
def test_a_line_of_another_shape_is_refused_by_its_number(change, words, tmp_path):
    path = tmp_path / "endings.jsonl"
    kept = {**Ending(Episode("pile", 3), "success").to_json(), "code": code_key()}
    path.write_text(f"{json.dumps(kept)}\n{json.dumps({**kept, **change})}\n")
    with pytest.raises(InvalidInput, match=f"endings.jsonl: line 2 is no journal of a bench.*{words}"):
        Journal(path)


@pytest.mark.parametrize(
    "text",
    ['{"a": 1}', "[1, 2]", "3", "null", "notes of mine", "[" * 100_000, '{"format": "topple.episode",}'],
)
def test_another_file_is_no_journal(tmp_path, text):
    path = tmp_path / "mine.jsonl"
    path.write_text(f"\n{text}\n")
    with pytest.raises(InvalidInput, match=r"mine.jsonl: line 2 is no journal of a bench"):
        Journal(path)
    assert path.read_text() == f"\n{text}\n"


def test_a_folder_is_no_journal(tmp_path):
    with pytest.raises(InvalidInput, match="cannot keep results there"):
        Journal(tmp_path)


def test_one_process_keeps_a_journal_at_a_time(tmp_path):
    path = tmp_path / "endings.jsonl"
    with Journal(path), pytest.raises(InvalidInput, match="another process keeps its results there"):
        Journal(path)
    assert Journal(path).entries == []


@pytest.mark.parametrize("path", ["/dev/full", "/dev/null", "/nowhere/endings.jsonl", "/"])
def test_where_no_results_can_be_kept_is_refused(path):
    with pytest.raises(InvalidInput, match="give another"):
        Journal(Path(path))


def test_a_bench_goes_on_from_its_journal(tmp_path):
    with Journal(tmp_path / "endings.jsonl") as book:
        for series in QUICK:
            for episode in series.episodes(5):
                book.add(Ending(episode, "success", seconds=40.0).to_json())
    said: list[str] = []
    found = rows(True, 5, said.append, journal=book.path)
    assert said == []  # nothing was left to play
    assert [row["value"] for row in found if row["what"].startswith("goal reached")] == [100.0] * 3


def test_what_is_left_is_said(tmp_path):
    with Journal(tmp_path / "endings.jsonl") as book:
        book.add(Ending(QUICK[0].episodes(5)[0], "success", seconds=40.0).to_json())
    said: list[str] = []
    found = rows(True, 5, said.append, journal=book.path, minutes=0.0)
    assert found[0]["what"] == "episodes left to play"
    assert found[0]["value"] == len(QUICK) - 1
    left = len(QUICK) - 1
    assert said == [f"{left} of {len(QUICK)} episodes are left: the same command goes on with them"]


def test_frames_are_counted_by_what_stayed_and_what_went_well(tmp_path):
    series = Series("real frames", 2, bar=">= 70", folder=tmp_path, frames=("a", "b"))
    first, second = series.episodes(0)
    assert first == Episode("a", 0, folder=str(tmp_path))
    endings = [Ending(first, "success", sagged=0.004), Ending(second, "disturbed", sagged=0.02)]
    found = {row.what: row for row in figures({series: endings})}
    assert _only(found, "rebuilt, every body moves below 1 cm").value == 50.0
    assert _only(found, "goal reached, nothing disturbed: real frames").value == 50.0


def test_of_a_frame_that_is_freed_which_waits_for_most(shelf):
    needed = frozenset({("3", "2"), ("4", "3"), ("6", "5")})
    assert wanted_of(Frame("frame", shelf, needed, frozenset())) == "2"


def test_a_folder_without_frames_is_said(tmp_path):
    with pytest.raises(InvalidInput, match="no frames with removal constraints"):
        frames_in(tmp_path)


def test_shares_have_intervals_and_endings_are_counted():
    series = Series("pile", 4, bar=">= 90")
    ways = ["success", "success", "hit", "no plan"]
    found = {row.what: row for row in figures({series: _endings(series, ways)})}
    share = _only(found, "goal reached")
    assert (share.value, share.ok) == (50.0, False)
    assert share.interval is not None
    assert share.interval[0] < 50 < share.interval[1]
    assert _only(found, "nothing disturbed").value == 75.0
    assert _only(found, "hit").value == 1
    assert _only(found, "no plan").value == 1


def test_orders_are_compared_on_the_seeds_that_both_played():
    ours, theirs = Series("pile", 2), [Series("pile", 2, rule=rule) for rule in RULES]
    found = {ours: _endings(ours, ["success", "hit"])}
    found |= {one: _endings(one, ["hit", "hit"][: 1 + number]) for number, one in enumerate(theirs)}
    row = next(row for row in figures(found) if row.baseline == RULES[0] and row.what.startswith("things"))
    assert (row.value, row.baseline_value) == (0, 1)  # of seed 0 alone


@pytest.mark.parametrize(("leak", "ok"), [(0, True), (40, False)])
def test_memory_that_grows_on_is_a_leak_and_loading_is_none(leak, ok):
    loaded = [min(300 + 100 * place, 1000) + leak * place for place in range(30)]
    endings = [Ending(Episode("pile", place), "success", memory=m) for place, m in enumerate(loaded)]
    row = next(row for row in endurance(endings) if row.what.startswith("memory"))
    assert row.ok is ok


def test_fallbacks_are_counted_with_what_came_of_them():
    stood = (("narrow", True), ("empty", False), ("narrow", False))
    endings = [
        Ending(Episode("pile", 0), "success", steps=3, fallbacks=stood),
        Ending(Episode("pile", 1), "hit", steps=1),
    ]
    assert Ending.from_json(endings[0].to_json()) == endings[0]
    found = {row.what: row.value for row in fallback_rows(endings)}
    assert found["steps by narrow, of 4"] == 2
    assert found["steps by let fall, of 4"] == 0
    assert (found["of these succeeded: narrow"], found["of these succeeded: empty"]) == (50.0, 0.0)


def test_a_scene_that_is_none_is_an_ending():
    ending = play(Episode("kitchen", 0))
    assert ending.ending == "no plan"
    assert "there is no scene 'kitchen'" in ending.violations[0]


def _endings(series: Series, ways: list[str]) -> list[Ending]:
    pairs = zip(series.episodes(0), ways, strict=False)
    return [Ending(episode, way, violated=int(way == "hit")) for episode, way in pairs]


def _only(rows: dict[str, Row], start: str) -> Row:
    (found,) = (row for what, row in rows.items() if what.startswith(start))
    return found
