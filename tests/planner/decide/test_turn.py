from topple.planner.decide.arrange import Order, arrange
from topple.planner.decide.dependency import Dependency, DependencyGraph
from topple.planner.decide.turn import Ahead, may_begin, steadied


def ordered(targets: tuple[str, ...], *names: str) -> Order:
    return Order(targets, names, DependencyGraph((), ()), (), (), (), {})


def test_an_order_that_goes_on_as_it_was_to_is_no_change() -> None:
    ahead = Ahead.of(ordered(("plate",), "spoon", "plate"), True)
    assert ahead.changed(ordered(("plate",), "plate")) is None


def test_a_look_that_adds_or_drops_an_object_changes_the_order_and_says_what_it_was() -> None:
    ahead = Ahead.of(ordered(("ball",), "can", "box", "ball"), True)
    assert ahead.changed(ordered(("ball",), "ball")) == "ball instead of box, ball"
    assert ahead.changed(ordered(("ball",), "mug", "box", "ball")) == "mug, box, ball instead of box, ball"


def test_a_step_that_failed_is_still_ahead() -> None:
    ahead = Ahead.of(ordered(("ball",), "can", "ball"), False)
    assert ahead.changed(ordered(("ball",), "can", "ball")) is None


def test_the_next_part_of_a_goal_is_no_change_and_the_same_part_again_is() -> None:
    ahead = Ahead.of(ordered(("red",), "red"), True)
    assert ahead.changed(ordered(("green",), "green")) is None
    emptied = Ahead.of(ordered(("bowl",), "plum"), True)
    assert emptied.changed(ordered(("bowl",), "plum")) == "plum though nothing was left to take"


def held(*edges: tuple[str, str, str]) -> list[tuple[str, str, str, bool]]:
    """What is held, since when and until when, of an order of a, b and c; and whether that may begin."""
    found = steadied(
        arrange(DependencyGraph(("a", "b", "c"), tuple(Dependency(*e, 0.9) for e in edges)), (), {})
    )
    return [(hold.object, hold.since, hold.until, may_begin(hold, found)) for hold in found.holds]


def test_what_something_leans_on_is_held_and_taken_by_that_hand_where_it_is_next() -> None:
    assert held(("a", "b", "supported")) == []
    assert held(("a", "b", "leaning"), ("b", "c", "supported")) == [("b", "a", "b", True)]
    assert held(("a", "c", "leaning"), ("a", "b", "supported"), ("b", "c", "supported")) == [
        ("c", "a", "a", True)
    ]
    assert held(("b", "c", "leaning"), ("a", "b", "supported")) == [("c", "b", "b", False)], "a is on b"
