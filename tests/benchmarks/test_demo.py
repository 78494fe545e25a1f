"""The count of the demos' seeds: from the journal of runs; the default seed succeeds by a wide margin."""

import json
from pathlib import Path

import pytest

from topple.benchmarks.demo import SEEDS, count_of, rows
from topple.benchmarks.episodes import Ending, Episode
from topple.benchmarks.journal import Journal
from topple.benchmarks.versions import commit_now
from topple.planner.execution.demo_seeds import FORMAT, SeedCount, counted, default_seed
from topple.robots.scenarios import SCENARIOS


def _ending(seed: int, how: str = "success", used: float = 0.1) -> Ending:
    return Ending(Episode("pile", seed), how, used=used)


def test_played_by_default_is_the_first_seed_that_succeeds_by_a_wide_margin() -> None:
    endings = [_ending(0, "disturbed", 2.0), _ending(1, used=0.9), _ending(2), _ending(3)]
    assert count_of(endings) == SeedCount((0, 1, 2, 3), (1, 2, 3), 2)


def test_where_all_that_succeed_are_close_the_least_close_is_played() -> None:
    count = count_of([_ending(0, used=0.9), _ending(1, used=0.7), _ending(2, "hit", 0.0)])
    assert count is not None and count.default == 1


def test_a_scene_that_was_not_played_has_no_count() -> None:
    assert count_of([]) is None
    assert counted("opera") is None
    assert default_seed("opera") == 0


def test_a_count_in_words_says_which_seeds_it_is_of() -> None:
    assert str(SeedCount((0, 1, 2), (0, 2), 0)) == "of seeds 0 to 2, 2 reach the goal with nothing disturbed"
    assert str(SeedCount((0, 4), (), 0)) == "of 2 seeds from 0 to 4, 0 reach the goal with nothing disturbed"


def test_the_bench_counts_from_the_journal_of_runs_and_writes_what_the_demo_tells(tmp_path: Path) -> None:
    with Journal(tmp_path / "runs.jsonl") as book:
        for name in SCENARIOS:
            book.add(Ending(Episode(name, 7), "hit" if name == "pile" else "success").to_json())
    file, said = tmp_path / "seeds.json", list[str]()
    found = rows(True, 7, said.append, journal=book.path, counts=file)
    assert said == []  # nothing was left to play
    shares = {row["what"]: row["value"] for row in found if row["what"].startswith("goal reached")}
    assert sorted(shares.values()) == [0.0] + [100.0] * (len(list(SCENARIOS)) - 1)
    document = json.loads(file.read_text())
    assert document["format"] == FORMAT
    assert document["commit"] == commit_now()
    assert document["topple"] and "topple bench demo" in document["made_by"]
    assert document["scenes"]["pile"] == {"played": [7], "reached": [], "default": 7}
    assert document["scenes"]["sort"] == {"played": [7], "reached": [7], "default": 7}


@pytest.mark.parametrize("name", list(SCENARIOS))
def test_every_demo_has_a_count_and_plays_a_seed_that_succeeded(name: str) -> None:
    count = counted(name)
    assert count is not None
    assert default_seed(name) in count.reached
    assert set(count.reached) <= set(count.played) <= set(range(SEEDS))
