"""Seeded piles and their truth: what the orders are developed on has to be what it says it is."""

import numpy as np
import pytest

from topple.benchmarks.piles import Pile, label, make_pile, observe, truth
from topple.planner.simulate.lift import Move
from topple.robots import shapes


def _at(x: float, z: float) -> np.ndarray:
    pose = np.eye(4)
    pose[0, 3], pose[2, 3] = x, z
    return pose


@pytest.fixture(scope="module")
def stack() -> Pile:
    """A box on a box, a third far off."""
    low, top, aside = (shapes.box(name, (0.1, 0.1, 0.05)) for name in ("low", "top", "aside"))
    return Pile((low, top, aside), {"low": _at(0, 0), "top": _at(0, 0.05), "aside": _at(0.3, 0)})


@pytest.mark.slow
def test_the_same_seed_makes_the_same_pile():
    first, again, other = make_pile(3), make_pile(3), make_pile(4)
    assert list(first.poses) == list(again.poses)
    assert all(np.array_equal(first.poses[name], again.poses[name]) for name in first.poses)
    assert list(first.poses) != list(other.poses)


def test_a_pile_is_at_rest_on_its_table():
    pile = make_pile(3)
    with pile.world() as world:
        before = world.poses()
        world.step(120)
        moved = [np.linalg.norm(world.pose(name)[:3, 3] - before[name][:3, 3]) for name in pile.poses]
    assert max(moved) < 0.003


def test_who_lies_on_a_lifted_box_had_to_go_first_and_nobody_else(stack):
    verdicts = truth(stack)
    moved = {(first, then) for then, row in verdicts.items() for first, value in row.items() if value == 1}
    assert moved == {("top", "low")}
    assert all(first != then for then, row in verdicts.items() for first in row)


def test_whole_surfaces_show_undersides_and_cameras_do_not(stack):
    whole, seen = observe(stack, 0, seed=1), observe(stack, 1, seed=1)
    assert set(whole.names) == {"low", "top", "aside", "table"}
    assert len(whole.viewpoints) == 0
    assert len(seen.viewpoints) == 1
    assert (whole.clouds["aside"][:, 2] < 0.002).mean() > 0.1
    assert (seen.clouds["aside"][:, 2] < 0.002).mean() < 0.05
    # 1 mm of noise along the line of sight: the seen top is thicker than the true one, and not by much.
    tops = seen.clouds["aside"][seen.clouds["aside"][:, 2] > 0.045]
    assert 0.0003 < tops[:, 2].std() < 0.003


def test_a_label_needs_agreement_at_every_friction():
    far, near, still = Move(0.05, 0.0), Move(0.008, 0.0), Move(0.0, 0.0)
    assert label([{"a": far}] * 3, "a") == 1
    assert label([{"a": still}, {"a": near}, {"a": still}], "a") == 0
    assert label([{"a": far}, {"a": still}, {"a": still}], "a") is None
    assert label([{"a": near}, {"a": near}, {"a": still}], "a") is None
