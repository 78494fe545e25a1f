"""The count of the demos' seeds: from the journal of runs; the default seed succeeds by a wide margin."""

import json
from collections.abc import Sequence

import numpy as np
import pytest

from topple.benchmarks.demo import SEEDS, count_of, default_of, rows, variants
from topple.benchmarks.episodes import Ending, Episode, copied
from topple.benchmarks.journal import Journal
from topple.benchmarks.versions import commit_now
from topple.planner.execution.demo_seeds import FORMAT, SeedCount, default_seed, seed_count
from topple.robots import scenario
from topple.robots.scenarios import SCENARIOS


def _ending(seed: int, how: str = "success", used: float = 0.1) -> Ending:
    return Ending(Episode("pile", seed), how, used=used)


def test_played_by_default_is_the_first_seed_that_succeeds_by_a_wide_margin():
    endings = [_ending(0, "disturbed", 2.0), _ending(1, used=0.9), _ending(2), _ending(3)]
    assert count_of(endings) == SeedCount((0, 1, 2, 3), (1, 2, 3), 2)


def test_played_by_default_is_a_seed_that_succeeds_turned_a_degree_and_rougher_or_smoother():
    assert {(e.turned, e.friction) for e in variants("pile", 1)} == {
        (0.0, 1.0), (1.0, 1.0), (359.0, 1.0), (0.0, 0.8), (0.0, 1.2)
    }  # fmt: skip
    count, played = SeedCount((0, 1, 2, 3), (0, 1, 3), 1), list[Episode]()

    def ended(some: Sequence[Episode]) -> list[Ending]:
        played.extend(some)
        return [Ending(e, "hit" if e.seed == 1 and e.friction < 1.0 else "success") for e in some]

    assert default_of("pile", count, ended) == 0
    assert {episode.seed for episode in played} == {0, 1}
    assert default_of("pile", count, lambda some: [Ending(e, "hit") for e in some]) == 1


def test_a_scene_is_played_turned_and_smoother_as_the_episode_says():
    with scenario("swap", 0) as stage, copied(stage.world, Episode("swap", 0, turned=359.0)) as turned:
        smooth = copied(stage.world, Episode("swap", 0, friction=0.8))
        for name in stage.world.movable:
            here, there = stage.world.pose(name), turned.pose(name)
            angle = np.degrees(np.arctan2(here[1, 3], here[0, 3]) - np.arctan2(there[1, 3], there[0, 3]))
            assert angle == pytest.approx(1.0, abs=1e-3)
            assert smooth.body(name).friction == pytest.approx(0.8 * stage.world.body(name).friction)
        assert smooth.body("table").friction == stage.world.body("table").friction
        smooth.close()


def test_where_all_that_succeed_are_close_the_least_close_is_played():
    count = count_of([_ending(0, used=0.9), _ending(1, used=0.7), _ending(2, "hit", 0.0)])
    assert count is not None and count.default == 1


def test_a_scene_that_was_not_played_has_no_count():
    assert count_of([]) is None
    assert seed_count("opera") is None
    assert default_seed("opera") == 0


def test_a_count_in_words_says_which_seeds_it_is_of():
    assert str(SeedCount((0, 1, 2), (0, 2), 0)) == "of seeds 0 to 2, 2 reach the goal with nothing disturbed"
    assert str(SeedCount((0, 4), (), 0)) == "of 2 seeds from 0 to 4, 0 reach the goal with nothing disturbed"


def test_the_bench_counts_from_the_journal_of_runs_and_writes_what_the_demo_tells(tmp_path):
    with Journal(tmp_path / "runs.jsonl") as book:
        for name in SCENARIOS:
            for episode in variants(name, 7):
                book.add(Ending(episode, "hit" if name == "pile" else "success").to_json())
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
def test_every_demo_has_a_count_and_plays_a_seed_that_succeeded(name):
    count = seed_count(name)
    assert count is not None
    assert default_seed(name) in count.reached
    assert set(count.reached) <= set(count.played) <= set(range(SEEDS))
