"""ClutterNav's piles: a seed is one, and what a lift drags along counts."""

import numpy as np

from topple.benchmarks import clutternav
from topple.benchmarks.clutternav import _take, make_pile, rows
from topple.robots.scenarios.scenario import pose_at
from topple.robots.shapes import box
from topple.robots.world.world import World


def test_a_lift_moves_what_lies_on_it_and_takes_away_itself_alone():
    with World() as world:
        world.add_table()
        for name, x, z in (("low", 0.0, 0.0), ("high", 0.0, 0.06), ("aside", 0.3, 0.0)):
            world.add(box(name, (0.06, 0.06, 0.06)), pose_at(x, 0.0, z))
        assert world.settle()
        assert _take(world, "low") == 1
        assert world.movable == ("high", "aside")
        assert _take(world, "aside") == 0


def test_a_seed_is_a_pile_and_its_rows_tell_three_orders(monkeypatch):
    monkeypatch.setattr(clutternav, "EACH", 2)
    monkeypatch.setattr(clutternav, "QUICK", 1)
    (pile, target), (again, same) = make_pile(2000), make_pile(2000)
    assert target == same and target in pile.poses and 0 < len(pile.bodies) <= 6
    assert all(np.array_equal(again.poses[name], pose) for name, pose in pile.poses.items())
    share, *counts = rows(True, 2, lambda text: None)
    assert (share["tried"], share["bar"], len(counts)) == (1, "100", 4)
    assert counts[1]["baseline_value"] == 1 and counts[0]["value"] <= len(pile.bodies)
