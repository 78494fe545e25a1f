from topple.planner.dependency import Dependency, DependencyGraph
from topple.planner.turn import out_of_turn, says
from topple.topology.support import Support


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
