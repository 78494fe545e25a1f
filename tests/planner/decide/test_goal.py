import numpy as np
import pytest

from topple.planner.decide.goal import Place, holds, parse_goal
from topple.planner.errors import NoSafePlan
from topple.topology import InvalidInput, Scene, UnknownObject, relate
from topple.topology.statics.support import Support

NAMES = (*"lemon bowl plate red green blue".split(), "salt and pepper", "bin_can", "can_1", "can_2", "table")


@pytest.fixture
def scene() -> Scene:
    rng = np.random.default_rng(0)
    return Scene({n: rng.random((20, 3)) + i for i, n in enumerate(NAMES)}, fixed=["table"], up=(0, 0, 1))


def test_within_names_object_and_container(scene):
    assert parse_goal("lemon within bowl", scene).places == (Place("lemon", "within", "bowl"),)


def test_a_tower_is_built_from_below(scene):
    goal = parse_goal("red on green on blue", scene)
    assert goal.places == (Place("green", "on", "blue"), Place("red", "on", "green"))
    assert goal.targets() == ("green", "red")


def test_names_are_what_free_targets_says(scene):
    assert parse_goal(["plate"], scene).free == parse_goal("free plate", scene).free == ("plate",)


def test_the_words_of_names_to_free_are_read_back_as_those_names(scene):
    goal = parse_goal(["red", "bowl"], scene)
    assert parse_goal(goal.text, scene).free == ("red", "bowl")


def test_clauses_join_and_names_may_hold_and(scene):
    goal = parse_goal("free salt and pepper and empty bowl, red on blue", scene)
    assert goal.free == ("salt and pepper",)
    assert goal.empty == ("bowl",)
    assert goal.places == (Place("red", "on", "blue"),)


def test_sort_sends_every_kind_to_its_bin(scene):
    assert {p.object for p in parse_goal("sort", scene).places} == {"can_1", "can_2"}


def test_a_goal_that_goes_round_names_the_cycle(scene):
    with pytest.raises(NoSafePlan, match="red") as caught:
        parse_goal("red on green on blue on red", scene)
    assert all(name in caught.value.certificate[0] for name in ("red", "green", "blue"))


@pytest.mark.parametrize(
    ("goal", "says"),
    [
        ("", "empty"),
        ("juggle lemon", "not understood"),
        ("table on plate", "fixed"),
        ("free table", "fixed"),
        ("red on red", "itself"),
        ("red on green, red on blue", "both"),
        ("free red, red on blue", "places it too"),
        ([], "no target"),
    ],
)
def test_what_is_no_goal_is_said_so(scene, goal, says):
    with pytest.raises(InvalidInput, match=says):
        parse_goal(goal, scene)


@pytest.mark.parametrize("goal", ["free spoon", "lemon within jar", ["nothing"]])
def test_unknown_names_list_the_known_ones(scene, goal):
    with pytest.raises(UnknownObject, match="lemon"):
        parse_goal(goal, scene)


def test_on_is_carried_and_not_leaning_at_the_side(scene):
    place, relations = Place("red", "on", "green"), relate(scene)
    rests = Support("green", "red", "rests", 1.0, False)
    leans = Support("green", "red", "leans", 1.0, False)
    stands = Support("table", "red", "leans", 1.0, False)
    assert not holds(place, relations, [])
    assert holds(place, relations, [rests]) and holds(place, relations, [leans])
    assert not holds(place, relations, [stands, leans])
    table, beside = (Support("table", name, "rests", 1.0, False) for name in ("green", "red"))
    assert holds(place, relations, [table, rests])
    assert not holds(place, relations, [table, rests, beside])  # as a can on a table and on a plate's rim
    pier = Support("blue", "red", "rests", 1.0, False)
    assert holds(place, relations, [table, rests, pier])  # as a plank on two piers
    assert not holds(Place("red", "within", "green"), relations, [rests])
    assert not holds(Place("gone", "on", "green"), relations, [rests])
