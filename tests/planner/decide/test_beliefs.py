import pytest

from topple.planner.decide.beliefs import Beliefs

FOUND = {("a", "b"): 0.8, ("b", "a"): 0.1, ("a", "c"): 0.2}


def test_the_mean_of_all_looks_counts_while_nothing_moves():
    once = Beliefs().after(FOUND, (), ())
    twice = once.after({**FOUND, ("a", "b"): 0.2}, (), ())
    assert twice.weigh({("a", "b"): 0.2}, ()) == pytest.approx({("a", "b"): 0.4})


def test_what_moved_is_judged_anew():
    beliefs = Beliefs().after(FOUND, {"a"}, ())
    assert beliefs.chances == {}
    assert beliefs.weigh(FOUND, ()) == FOUND


def test_of_what_was_put_down_alone_nothing_is_overlooked_but_what_is_found_counts():
    beliefs = Beliefs().after(FOUND, {"c"}, {"c"})
    assert beliefs.weigh({("a", "c"): 0.2}, ()) == {("a", "c"): 0.0}
    assert beliefs.weigh({("a", "c"): 0.9}, {("a", "c")}) == {("a", "c"): 0.9}
    assert beliefs.after(FOUND, {"c"}, ()).alone == frozenset()


def test_what_a_watched_lift_moved_is_known_until_one_of_the_two_is_elsewhere():
    beliefs = Beliefs().learn((), ["b"], "a")
    assert beliefs.measured == {("b", "a")}
    assert beliefs.after(FOUND, {"a"}, ()).learn(["c"], ["a"], "b").measured == {("b", "a"), ("a", "b")}
    assert beliefs.learn(["b"], (), "c").measured == set()
