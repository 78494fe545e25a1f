"""The bench of speed: what it times is the real thing, in small."""

import numpy as np
import pytest

from topple.benchmarks import speed
from topple.benchmarks.clouds import brick_wall, stacks_of_four
from topple.benchmarks.speed import Trees, exponent
from topple.benchmarks.versions import commit_now
from topple.planner.planning.order import order
from topple.topology.base.errors import InvalidInput

in_checkout = pytest.mark.skipif(commit_now() is None, reason="this is no checkout: there are no commits")


def test_an_exponent_is_that_of_the_power():
    assert exponent((10, 1000), (0.5, 0.5 * 100**1.3)) == pytest.approx(1.3)


def test_bricks_of_a_wall_hang_together_and_stacks_do_not():
    wall = order(brick_wall(8, 0))
    supports = {(support.supporter, support.supported) for support in wall.supports}
    assert {("brick 0", "brick 6"), ("brick 1", "brick 6"), ("brick 1", "brick 7")} <= supports
    stacks = order(stacks_of_four(8, 0))
    assert stacks.order.index("brick 3") < stacks.order.index("brick 2") < stacks.order.index("brick 0")
    assert not any({one.first, one.then} == {"brick 3", "brick 4"} for one in stacks.graph.dependencies)


def test_rows_say_against_what_and_how_far(tmp_path):
    row = speed.relations_row(500, 3.5, 0, 1)
    assert (row.baseline, row.bar) == ("Qhull alone", "<= 3.5x")
    assert row.value > 0
    grows = speed.stacks_row((8, 16), 1.2, 0)
    assert grows.bar == "<= 1.2"
    assert "16 objects against 8" in grows.what
    small, large = speed.json_row(8, 0), speed.json_row(40, 0)
    assert small.value == pytest.approx(large.value, rel=0.3)  # for each object, however many there are
    assert large.baseline_value is not None and large.value < 0.6 * large.baseline_value
    alone = Trees(tmp_path, None).row("a figure", 2.0, None)
    assert (alone.bar, alone.ok) == (None, None)


@pytest.mark.slow
@pytest.mark.filterwarnings("default")  # those of the cluster's start and end are not topple's
def test_two_workers_are_held_against_one_process(tmp_path):
    paths = [speed.written(stacks_of_four(8, k), tmp_path / f"{k}_scene.npz") for k in range(2)]
    rows = speed.many_rows(paths, lambda text: None)
    assert rows[0].what == "relations of 2 scenes, two workers, processes, wall"
    assert all(row.bar == ">= 1.7x" and row.value > 0 for row in rows)


@in_checkout
def test_what_is_no_commit_is_refused(tmp_path):
    with pytest.raises(InvalidInput, match="no-such-commit is no commit"):
        Trees(tmp_path, "no-such-commit")


@in_checkout
@pytest.mark.slow
def test_a_commit_does_the_same_task_in_a_process_of_its_own(tmp_path):
    trees = Trees(tmp_path, "HEAD")
    path = speed.written(stacks_of_four(8, 0), tmp_path / "stacks_scene.npz")
    ours, theirs = trees.measure("order", {"paths": [str(path)]}, 1)
    assert theirs is not None
    assert min(*ours, *theirs) > 0
    row = trees.row("order", ours[0], theirs[0])
    assert row.ratio == pytest.approx(theirs[0] / ours[0])
    assert np.isfinite(row.value)
    qhull, commit = speed.wall_rows(trees, 12, 99.0, 0)
    assert (qhull.baseline, qhull.bar, qhull.ok) == ("Qhull alone", "<= 99x", True)
    assert (row.baseline, row.bar) == (commit.baseline, commit.bar) == (trees.name, ">= 0.9x")
    (imports,) = trees.ours("imports", {"paths": []})
    (process,) = trees.ours("process", {"paths": [str(path)]})
    assert process > imports > 0.0


@pytest.mark.slow
def test_a_task_that_fails_says_so(tmp_path):
    with pytest.raises(RuntimeError, match="order by this tree failed"):
        Trees(tmp_path, None).measure("order", {"paths": [str(tmp_path / "none_scene.npz")]}, 1)


@pytest.mark.slow
def test_waiting_is_measured_with_the_step_chosen_ahead_and_without(tmp_path, monkeypatch):
    monkeypatch.setattr(speed, "WAITING", ("tower",))
    rows = speed.waiting_rows(Trees(tmp_path, None), range(500, 501), lambda text: None)
    assert [row.bar for row in rows] == ["<= 0.4", "<= 1", None]
    for row in rows:
        assert row.baseline == "chosen after the look"
        assert row.value > 0.0
