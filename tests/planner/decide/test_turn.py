from topple.planner.decide.arrange import Order
from topple.planner.decide.dependency import Dependency, DependencyGraph
from topple.planner.decide.turn import Ahead, out_of_turn, says
from topple.topology.statics.support import Support


def graph(*edges: Dependency) -> DependencyGraph:
    names = dict.fromkeys(name for edge in edges for name in (edge.first, edge.then))
    return DependencyGraph(tuple(names), edges)


def test_only_what_waits_by_doubtful_dependencies_alone_may_go_out_of_turn() -> None:
    doubtful = Dependency("plum", "orange", "leaning", 0.47)
    known = graph(
        doubtful,
        Dependency("plum", "pear", "leaning", 0.47),
        Dependency("can", "pear", "leaning", 0.76),
    )
    assert out_of_turn(known.names, known, ()) == {"orange": (doubtful,)}


def test_the_least_likely_to_move_something_goes_first() -> None:
    low, high = Dependency("a", "b", "leaning", 0.2), Dependency("a", "c", "leaning", 0.4)
    known = graph(high, low)
    assert list(out_of_turn(known.names, known, ())) == ["b", "c"]


def test_what_carries_another_one_never_goes_before_it() -> None:
    known = graph(Dependency("plum", "orange", "leaning", 0.3))
    rests = Support("orange", "plum", "rests", 0.5, True)
    leans = Support("orange", "plum", "leans", 0.5, True)
    assert out_of_turn(known.names, known, (rests,)) == {}
    assert list(out_of_turn(known.names, known, (leans,))) == ["orange"]


def test_the_reason_says_what_is_gone_against_and_how_far_it_is_believed() -> None:
    assert "plum leans on orange (0.47)" in says([Dependency("plum", "orange", "leaning", 0.47)])


def ordered(targets: tuple[str, ...], *names: str) -> Order:
    return Order(targets, names, graph(), (), (), (), {})


def test_an_order_that_goes_on_as_it_was_to_is_no_change() -> None:
    ahead = Ahead.of(ordered(("plate",), "spoon", "plate"), "spoon")
    assert ahead.changed(ordered(("plate",), "plate")) is None


def test_a_look_that_adds_or_drops_an_object_changes_the_order_and_says_what_it_was() -> None:
    ahead = Ahead.of(ordered(("ball",), "can", "box", "ball"), "can")
    assert ahead.changed(ordered(("ball",), "ball")) == "ball instead of box, ball"
    assert ahead.changed(ordered(("ball",), "mug", "box", "ball")) == "mug, box, ball instead of box, ball"


def test_a_step_that_failed_is_still_ahead() -> None:
    ahead = Ahead.of(ordered(("ball",), "can", "ball"), None)
    assert ahead.changed(ordered(("ball",), "can", "ball")) is None


def test_the_next_part_of_a_goal_is_no_change_and_the_same_part_again_is() -> None:
    ahead = Ahead.of(ordered(("red",), "red"), "red")
    assert ahead.changed(ordered(("green",), "green")) is None
    emptied = Ahead.of(ordered(("bowl",), "plum"), "plum")
    assert emptied.changed(ordered(("bowl",), "plum")) == "plum though nothing was left to take"
