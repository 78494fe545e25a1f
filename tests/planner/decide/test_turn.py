from topple.planner.decide.arrange import Order, arrange
from topple.planner.decide.dependency import Dependency, DependencyGraph
from topple.planner.decide.hold import Hold
from topple.planner.decide.turn import Ahead, may_begin


def ordered(targets: tuple[str, ...], *names: str) -> Order:
    return Order(targets, names, DependencyGraph((), ()), (), (), (), {})


def test_an_order_that_goes_on_as_it_was_to_is_no_change():
    ahead = Ahead.of(ordered(("plate",), "spoon", "plate"), True)
    assert ahead.change_to(ordered(("plate",), "plate")) is None


def test_a_look_that_adds_or_drops_an_object_changes_the_order_and_says_what_it_was():
    ahead = Ahead.of(ordered(("ball",), "can", "box", "ball"), True)
    assert ahead.change_to(ordered(("ball",), "ball")) == "ball instead of box, ball"
    assert ahead.change_to(ordered(("ball",), "mug", "box", "ball")) == "mug, box, ball instead of box, ball"


def test_a_step_that_failed_is_still_ahead():
    ahead = Ahead.of(ordered(("ball",), "can", "ball"), False)
    assert ahead.change_to(ordered(("ball",), "can", "ball")) is None


def test_the_next_part_of_a_goal_is_no_change_and_the_same_part_again_is():
    ahead = Ahead.of(ordered(("red",), "red"), True)
    assert ahead.change_to(ordered(("green",), "green")) is None
    emptied = Ahead.of(ordered(("bowl",), "plum"), True)
    assert emptied.change_to(ordered(("bowl",), "plum")) == "plum though nothing was left to take"


def test_a_hold_begins_once_what_has_to_go_before_what_is_taken_in_it_is_gone():
    graph = DependencyGraph(("a", "b", "c"), (Dependency("a", "c", "supported", 0.9),))
    found = arrange(graph, (), {})
    assert found.order == ("a", "b", "c")
    assert not may_begin(Hold("c", "b", "c", "they lean on each other"), found), (
        "the hand would take a with it"
    )
    assert may_begin(Hold("c", "b", "b", "c alone does not stand"), found), "it lets go again"
    assert may_begin(Hold("c", "a", "c", "both go in it"), found)
