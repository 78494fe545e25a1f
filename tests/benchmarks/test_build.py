"""The judge of build orders: what stands in simulation, what falls, and what is hit on its way down."""

import numpy as np
import pytest

from topple.benchmarks.arrangements import KINDS, arrangement
from topple.benchmarks.build import Trial
from topple.benchmarks.piles import Pile, observe
from topple.planner import build_order, order
from topple.robots.scenarios.scenario import pose_at
from topple.robots.shapes import box


@pytest.fixture(scope="module")
def balance() -> Pile:
    """A plank past the edge of a pier, kept there by a weight."""
    bodies = (
        box("pier", (0.08, 0.1, 0.1)),
        box("plank", (0.3, 0.06, 0.02)),
        box("weight", (0.06, 0.06, 0.08)),
    )
    places = (pose_at(0, 0, 0), pose_at(0.08, 0, 0.1), pose_at(-0.03, 0, 0.12))
    return Pile(bodies, {body.name: pose for body, pose in zip(bodies, places, strict=True)})


def test_a_plank_falls_without_its_counterweight_unless_it_is_held(balance):
    found = build_order(observe(balance, 0, 0))
    assert [(hold.object, hold.until) for hold in found.holds] == [("plank", "weight")]
    trial = Trial(balance)
    assert trial.stands(("pier", "plank", "weight")) == [True, False, True]
    assert trial.stands(found.order, found) == [True, True, True]


def test_a_plank_falls_as_its_counterweight_is_lifted_unless_it_is_held(balance):
    found = order(observe(balance, 0, 0))
    assert [(hold.object, hold.since) for hold in found.holds] == [("plank", "weight")]
    trial = Trial(balance)
    assert not trial.cleared(found.order)
    assert trial.cleared(found.order, found.holds)


def test_what_comes_from_above_may_not_pass_what_stands(balance):
    assert Trial(balance).stands(("plank", "weight", "pier"))[-1] is False


@pytest.mark.parametrize("seed", [3, 10])
def test_an_arrangement_stands_and_is_the_same_for_the_same_seed(seed):
    (kind, first), (_, second) = arrangement(seed), arrangement(seed)
    assert kind in KINDS
    assert first.poses.keys() == second.poses.keys()
    assert all(np.array_equal(first.poses[name], second.poses[name]) for name in first.poses)
    assert Trial(first).stands(tuple(first.poses))[-1]
