"""Dependencies checked in rebuilt worlds."""

from itertools import permutations

import numpy as np
import pytest

from topple.benchmarks.rates import counted, rates
from topple.planner.budget import OutOfBudget
from topple.planner.decide.dependency import Dependency, DependencyGraph, reason_out
from topple.planner.decide.rates import likelihoods, posterior, stances
from topple.planner.planning.order import order
from topple.planner.simulate.votes import Votes, ask, chances, confirm
from topple.robots import shapes
from topple.topology.scene.scene import Scene
from topple.topology.situation.situation import Situation
from topple.topology.statics.rest import Statics

NOTHING = DependencyGraph.of(("plate", "on", "beside"), ())


@pytest.fixture(scope="module")
def scene() -> Scene:
    """A can on a plate, another beside it."""
    rng = np.random.default_rng(0)
    on, beside = (shapes.can(name, diameter=0.06, height=0.08) for name in ("on", "beside"))
    table = np.column_stack([rng.uniform(-0.3, 0.5, (3000, 2)), np.zeros(3000)])
    return Scene(
        {
            "plate": shapes.plate("plate").surface(2500, rng),
            "on": on.surface(1500, rng) + np.array([0.01, 0.0, 0.0065]),
            "beside": beside.surface(1500, rng) + np.array([0.2, 0.0, 0.0]),
            "table": table,
        },
        fixed=["table"],
        up=(0, 0, 1),
    )


@pytest.fixture(scope="module")
def statics(scene: Scene) -> Statics:
    """The scene at rest."""
    return Statics.of(scene)


@pytest.fixture(scope="module")
def votes(statics: Statics) -> Votes:
    """What simulation says about it."""
    return ask(statics, NOTHING)


def test_taking_the_plate_moves_the_can_on_it_and_not_the_one_beside(votes):
    assert votes.trials == 9
    assert votes.moved["on", "plate"] == (True, True, True)
    assert not any(votes.moved["beside", "plate"])
    assert not any(votes.moved["plate", "on"])
    assert votes.steady("on", "plate")


@pytest.mark.slow
def test_the_same_seed_gives_the_same_votes(statics, votes):
    again = ask(statics, NOTHING)
    assert again.moved == votes.moved
    assert again.sagged == votes.sagged


def test_a_budget_that_runs_out_is_a_failure_that_says_so_and_no_other_answer(scene):
    with pytest.raises(OutOfBudget, match=r"the budget of 0\.01 s ran out"):
        order(scene, verify=True, budget=0.01)
    assert order(scene, verify=True, budget=600.0).verified


def test_an_edge_that_reasoning_made_up_is_dropped_and_one_it_overlooked_is_added(votes):
    wrong = DependencyGraph.of(NOTHING.names, [Dependency("beside", "plate", "blocking", confidence=0.6)])
    prior = dict.fromkeys(permutations(NOTHING.names, 2), 0.1) | {("beside", "plate"): 0.6}
    checked = confirm(wrong, chances(prior, votes, cameras=None), votes)
    assert {(edge.first, edge.then) for edge in checked.dependencies} == {("on", "plate")}


def test_bodies_that_sag_by_themselves_add_no_dependency():
    nothing, moved = DependencyGraph.of(("a", "b"), ()), {("a", "b"): (True, True, True)}
    chance = {("a", "b"): 0.9, ("b", "a"): 0.1}
    steady, sagging = (Votes(moved, {"a": sag, "b": 0.0}, 3) for sag in (0.1, 0.9))
    assert len(confirm(nothing, chance, steady).dependencies) == 1
    assert not confirm(nothing, chance, sagging).dependencies


@pytest.mark.parametrize("cameras", [None, 3, 1])
def test_more_trials_that_moved_make_a_dependency_likelier(cameras):
    for steady in (True, False):
        chance = [posterior(0.5, moved, 3, likelihoods(cameras, steady)) for moved in range(4)]
        assert chance[0] < 0.5 < chance[3]
        assert chance[0] < chance[1] <= chance[3]


def test_what_was_not_tried_stays_as_reasoned():
    graph = DependencyGraph.of(("a", "b"), [Dependency("a", "b", "leaning", confidence=0.45)])
    nothing = Votes({}, {}, 0)
    prior = {("a", "b"): 0.45, ("b", "a"): 0.3}
    assert chances(prior, nothing, cameras=3) == prior
    assert confirm(graph, prior, nothing).dependencies == graph.dependencies


def test_that_bodies_with_guessed_sides_stand_refutes_nothing():
    graph = DependencyGraph.of(("a", "b"), [Dependency("a", "b", "leaning", confidence=0.357)])
    prior = {("a", "b"): 0.357, ("b", "a"): 0.1}
    stood = Votes({pair: (False,) * 3 for pair in prior}, {"a": 0.0, "b": 0.0}, 6)
    moved = Votes({pair: (True,) * 3 for pair in prior}, {"a": 0.0, "b": 0.0}, 6)
    for cameras in (1, 3):
        assert chances(prior, stood, cameras) == prior
        assert confirm(graph, prior, stood).dependencies == graph.dependencies
        assert len(confirm(graph, chances(prior, moved, cameras), moved).dependencies) == 2
    assert not confirm(graph, chances(prior, stood, cameras=None), stood).dependencies


def test_counted_rates_tell_what_happened_with_a_dependency_and_without(statics, votes):
    labels = {
        then: {first: int((first, then) == ("on", "plate")) for first in NOTHING.names}
        for then in NOTHING.names
    }
    counts = trials, overlooked = counted(labels, votes, [("beside", "plate")], stances(statics))
    assert trials[0, 3].tolist() == [1, 0] and trials[0, 0].tolist() == [0, 5]
    assert overlooked[0, 1].tolist() == [1, 0]
    found = rates([counts, counts])
    assert found["steady"][3] == [round(2.5 / 4, 3), round(0.5 / 12, 3)]
    assert sum(with_it for with_it, _ in found["steady"]) == pytest.approx(1, abs=2e-3)
    assert found["overlooked"][0][1] == round(2.5 / 3, 3)


def test_of_things_that_touch_the_higher_is_likelier_to_depend_on_the_lower(scene):
    stand = stances(Statics.of(scene))
    assert (stand["on", "plate"], stand["plate", "on"], stand["beside", "plate"]) == ((0, 1), (0, 0), (2, 1))
    _, chance = reason_out(Situation(scene))
    assert chance["on", "plate"] > chance["plate", "on"] > chance["beside", "plate"]
