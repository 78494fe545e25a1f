"""Both engines side by side: only seeds played on both count, and each that differs is told of."""

import pytest

pytest.importorskip("mujoco", reason="MuJoCo is not installed: pip install '.[mujoco]'")

from topple.benchmarks.engines import compared, rows
from topple.benchmarks.episodes import Ending, Episode, play
from topple.benchmarks.journal import Journal
from topple.robots.engines import BULLET, ENGINES, MUJOCO


def _ending(seed: int, engine: str, how: str = "success", *said: str) -> Ending:
    return Ending(Episode("tower", seed, engine=engine), how, said)


def _pair(seed: int, **how: str) -> dict[str, Ending]:
    return {engine: _ending(seed, engine, how.get(engine, "success"), "red fell") for engine in ENGINES}


def test_shares_of_both_and_what_differs_are_told():
    both = [_pair(0), _pair(1, mujoco="dropped"), _pair(2, bullet="no plan", mujoco="no plan")]
    found = {row.what: row for row in compared("tower", both, 40)}
    ours, theirs = (
        found[f"goal reached, nothing disturbed: tower, {name}, 3 of 40 seeds"]
        for name in ("PyBullet", "MuJoCo")
    )
    assert (ours.value, theirs.value) == pytest.approx((200 / 3, 100 / 3))
    assert ours.interval is not None and ours.interval[0] < ours.value < ours.interval[1]
    same = found["same verdict on both: tower"]
    assert (same.tried, same.held) == (3, 2)
    assert same.wrong == ("seed 1: PyBullet: success: red fell; MuJoCo: dropped: red fell",)


def test_another_failure_that_disturbs_is_another_verdict():
    (row,) = compared("dishes", [_pair(0, bullet="no plan", mujoco="disturbed")], 1)[-1:]
    assert row.held == 0


def test_the_bench_goes_on_from_its_journal(tmp_path, typed):
    with Journal(tmp_path / "engines.jsonl") as book:
        for engine in ENGINES:
            book.add(_ending(7, engine).to_json())
    said: list[str] = []
    found = rows(True, 7, said.append, journal=book.path)
    assert said == []  # nothing was left to play
    assert found[0]["value"] == 0
    assert {row["value"] for row in found[1:]} == {100.0}
    found = typed("bench", "engines", "--quick", "--seed", "7", "--journal", book.path, "--json").document
    assert found["bench"] == "engines"


def test_a_journal_of_before_is_of_the_scenes_own_arm_on_pybullet():
    entry = Ending(Episode("tower", 3), "success").to_json()
    entry["episode"] = {
        key: value for key, value in entry["episode"].items() if key not in ("robot", "engine")
    }
    assert Ending.from_json(entry).episode == Episode("tower", 3, robot="", engine=BULLET)


@pytest.mark.slow
def test_a_scene_that_settled_on_one_engine_is_played_on_the_other():
    ending = play(Episode("tower", 0, engine=MUJOCO))
    assert ending.success, ending.violations
    assert ending.sagged is not None and ending.sagged < 0.001
