import sys
from itertools import combinations, permutations
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from topple.planner.decide.arrange import arrange
from topple.planner.decide.beliefs import Beliefs
from topple.planner.decide.dependency import Dependency, DependencyGraph, dependencies
from topple.planner.planning.order import order
from topple.topology import InvalidInput, Scene, UnknownObject, load_scene

sys.path.insert(0, str(Path(__file__).parents[2] / "topology"))
from made import CHANGES, pile, seen, whole

SHARED = Path(__file__).resolve().parents[3].parent / "shared"
NAMES = tuple("abcdefgh")


@st.composite
def graphs(draw: st.DrawFn) -> DependencyGraph:
    names = NAMES[: draw(st.integers(1, 8))]
    pairs = [(a, b) for a in names for b in names if a != b]
    chosen = draw(st.lists(st.sampled_from(pairs), unique=True, max_size=12)) if pairs else []
    return DependencyGraph(names, tuple(Dependency(a, b, "supported", 0.9) for a, b in chosen))


def _allowed(graph: DependencyGraph, taken: frozenset[str]) -> bool:
    """Whether no one who must go before a taken one is left behind."""
    return all(e.first in taken for e in graph.dependencies if e.then in taken)


@given(graphs(), st.data())
def test_no_smaller_set_of_removals_frees_the_targets(graph, data):
    targets = data.draw(st.lists(st.sampled_from(graph.names), unique=True, min_size=1))
    found = arrange(graph, targets, {})
    assert _allowed(graph, frozenset(found.order))
    for count in range(len(targets), len(found.order)):
        for taken in combinations(graph.names, count):
            assert not (set(targets) <= set(taken) and _allowed(graph, frozenset(taken)))


def _least(graph: DependencyGraph, target: str) -> int:
    """The fewest removals that free a target, by trying every set."""
    for count in range(1, len(graph.names) + 1):
        for taken in combinations(graph.names, count):
            if target in taken and _allowed(graph, frozenset(taken)):
                return count
    raise AssertionError("taking everything is always allowed")


@pytest.mark.parametrize("count", [1, 2, 3, pytest.param(4, marks=pytest.mark.slow)])
def test_the_order_is_least_on_every_graph_up_to_four_objects(count):
    # Of graphs of one shape it is enough to free the first object: the others are other names for it.
    names = NAMES[:count]
    pairs = list(permutations(names, 2))
    for bits in range(2 ** len(pairs)):
        chosen = [pair for k, pair in enumerate(pairs) if bits >> k & 1]
        graph = DependencyGraph(names, tuple(Dependency(a, b, "supported", 0.9) for a, b in chosen))
        assert len(arrange(graph, names[:1], {}).order) == _least(graph, names[0])


@pytest.mark.slow
def test_the_order_is_least_on_every_acyclic_graph_of_five_objects():
    # With its objects named in a possible order, an acyclic graph has edges from earlier to later names only.
    names = NAMES[:5]
    pairs = list(combinations(names, 2))
    for bits in range(2 ** len(pairs)):
        chosen = [pair for k, pair in enumerate(pairs) if bits >> k & 1]
        graph = DependencyGraph(names, tuple(Dependency(a, b, "supported", 0.9) for a, b in chosen))
        for target in names[2:]:
            assert len(arrange(graph, [target], {}).order) == _least(graph, target)


def _tops(**heights: float) -> dict[str, np.ndarray]:
    return {name: np.array([0.0, 0.0, height]) for name, height in heights.items()}


def test_the_safer_of_two_goes_first_and_then_the_higher():
    graph = DependencyGraph(("a", "b", "c"), ())
    tops = _tops(a=0.1, b=0.3, c=0.2)
    assert arrange(graph, (), tops).order == ("b", "c", "a")
    found = arrange(graph, (), tops, chances={("a", "b"): 0.4})
    assert found.order == ("c", "a", "b")
    assert found.risk["b"] == 0.0


def test_the_risk_of_a_step_is_the_chance_that_anything_left_moves():
    chances = {("b", "a"): 0.5, ("c", "a"): 0.2, ("a", "b"): 0.9, ("a", "c"): 0.9}
    found = arrange(DependencyGraph(("a", "b", "c"), ()), ["a"], {}, chances=chances)
    assert found.order == ("a",)
    assert found.risk["a"] == pytest.approx(1 - 0.5 * 0.8)


def test_more_is_taken_where_that_risks_less_and_the_reason_says_so():
    graph = DependencyGraph(("a", "b", "c"), ())
    doubt = {("b", "a"): 0.3, ("c", "a"): 0.02, ("c", "b"): 0.02}
    assert arrange(graph, ["a"], {}, chances=doubt).order == ("a",)
    found = arrange(graph, ["a"], {}, chances=doubt, removal_risk=0.05)
    assert found.order == ("b", "a") and found.explanation[0] == "1. b: taking a might move it (0.30)"
    assert arrange(graph, ["a"], {}, chances=doubt, removal_risk=0.5).order == ("a",)


def test_what_earlier_looks_found_weighs_on(tower):
    for wrong in (-0.1, 1.1, float("nan")):
        with pytest.raises(InvalidInput, match=r"removal_risk is .*: expected (a chance from 0 to 1|number)"):
            order(tower, ["top"], removal_risk=wrong)
    alone = order(tower, ["top"], removal_risk=0.05)
    assert alone.order == ("top",) and alone.chances["top", "low"] > 0.9
    past = Beliefs({("aside", "top"): (0.9, 0.9)})
    assert order(tower, ["top"], removal_risk=0.05, beliefs=past).order == ("aside", "top")


def test_of_equally_safe_orders_the_shortest_way_is_taken():
    tops = {name: np.array([x, 0.0, 0.1]) for name, x in (("a", 0.0), ("b", 0.5), ("c", 0.1), ("d", 0.4))}
    assert arrange(DependencyGraph(("a", "b", "c", "d"), ()), (), tops).order == ("a", "c", "d", "b")


def test_a_cycle_is_named_with_its_weakest_edge_and_broken_there():
    edges = (
        Dependency("a", "b", "leaning", 0.9),
        Dependency("b", "a", "supported", 0.5),
        Dependency("b", "c", "supported", 0.8),
    )
    found = arrange(DependencyGraph(("a", "b", "c"), edges), (), {})
    assert found.groups == (("a", "b"),)
    assert found.unresolved == ()
    assert found.order == ("a", "b", "c")
    assert "a and b hold each other: take them together" in found.explanation[0]
    assert "a before b before a" in found.explanation[0]
    assert "b rests on a (0.50)" in found.explanation[0]
    assert found.risk["a"] == pytest.approx(0.5)


@given(graphs())
def test_nothing_goes_before_what_must_precede_it_but_in_a_cycle(graph):
    found = arrange(graph, (), {})
    assert sorted(found.order) == sorted(graph.names)
    place = {name: i for i, name in enumerate(found.order)}
    together = [set(group) for group in found.groups]
    for edge in graph.dependencies:
        if not any({edge.first, edge.then} <= group for group in together):
            assert place[edge.first] < place[edge.then]
    assert {frozenset(c) for c in graph.cycles()} == {frozenset(g) for g in together}


@given(graphs())
def test_leaving_out_what_follows_changes_no_ancestor(graph):
    reduced = graph.reduced()
    assert all(reduced.before(name) == graph.before(name) for name in graph.names)


def _box(size: tuple[float, float, float], centre: tuple[float, float, float]) -> np.ndarray:
    rng = np.random.default_rng(5)
    points = rng.uniform(-0.5, 0.5, (1500, 3))
    axis = rng.integers(0, 3, len(points))
    points[np.arange(len(points)), axis] = rng.choice([-0.5, 0.5], len(points))
    return points * size + centre


@pytest.fixture
def tower() -> Scene:
    clouds = {
        "low": _box((0.1, 0.1, 0.05), (0, 0, 0.025)),
        "middle": _box((0.08, 0.08, 0.05), (0, 0, 0.075)),
        "top": _box((0.06, 0.06, 0.05), (0, 0, 0.125)),
        "aside": _box((0.06, 0.06, 0.05), (0.2, 0, 0.025)),
        "table": np.random.default_rng(0).uniform(-0.3, 0.3, (900, 3)) * [1, 1, 0],
    }
    return Scene(clouds, fixed=["table"], up=(0, 0, 1))


def test_a_tower_comes_down_from_the_top(tower):
    found = order(tower, ["low"])
    assert found.order == ("top", "middle", "low")
    assert {(e.first, e.then, e.reason) for e in found.graph.dependencies} == {
        ("top", "middle", "supported"), ("middle", "low", "supported"),
    }  # fmt: skip
    assert "rests on" in found.explanation[0]


def test_the_document_has_the_contract_keys(tower):
    document = order(tower).to_json()
    assert document["format"] == "topple.order"
    keys = ("targets", "order", "dependencies", "supports", "groups", "unresolved", "risk", "access")
    assert all(key in document for key in keys)


def test_targets_are_checked(tower):
    with pytest.raises(UnknownObject, match="aside"):
        order(tower, ["spoon"])
    with pytest.raises(InvalidInput, match="fixed"):
        order(tower, ["table"])


def test_without_up_and_without_a_fixed_object():
    clouds = {"a": _box((0.1, 0.1, 0.1), (0, 0, 0.05))}
    with pytest.raises(InvalidInput, match="up="):
        order(Scene(clouds))
    assert any("no object is fixed" in said for said in order(Scene(clouds, up=(0, 0, 1))).assumptions)


def test_the_graph_does_not_depend_on_where_the_scene_lies(tower):
    c, s = np.cos(0.7), np.sin(0.7)
    turn = np.array([[c, -s, 0], [s, c, 0], [0, 0, 1.0]]) @ np.array(
        [[1, 0, 0], [0, 0.6, -0.8], [0, 0.8, 0.6]]
    )
    moved = Scene({n: p @ turn.T + 1.0 for n, p in tower.clouds.items()}, fixed=["table"], up=turn[:, 2])
    assert {(e.first, e.then) for e in dependencies(moved).dependencies} == {
        ("top", "middle"), ("middle", "low"),
    }  # fmt: skip


@pytest.mark.skipif(not SHARED.exists(), reason="needs the recorded scenes beside the checkout")
def test_on_a_real_frame_nothing_goes_before_what_stands_on_it():
    found = order(load_scene(SHARED / "data/rgbd/osd_test47.npz", fixed=["1"]))
    place = {name: i for i, name in enumerate(found.order)}
    assert all(place[a] < place[b] for a, b in (("7", "3"), ("5", "4"), ("6", "4"), ("6", "3")))


def test_an_object_sunk_into_the_table_is_said():
    rng = np.random.default_rng(3)
    box = rng.uniform(0.0, 0.1, (2000, 3))
    box[np.arange(2000), rng.integers(3, size=2000)] = rng.choice([0.0, 0.1], 2000)
    table = np.column_stack([rng.uniform(-0.5, 0.5, (6000, 2)), np.zeros(6000)])
    clouds = {
        "table": table,
        "sunk": box - np.array([0, 0, 0.04]),
        "fine": box + np.array([0.2, 0, 0]),
        "aside": box + np.array([0.45, 0, -0.04]),
    }
    said = order(Scene(clouds, fixed=["table"], up=(0, 0, 1))).assumptions
    assert [line for line in said if "into table" in line] == [
        "sunk reaches 4 cm into table, which no body can: where one of them was seen is wrong by as much"
    ]


@pytest.mark.parametrize("change", [name for name in CHANGES if "ball" not in name])
@pytest.mark.parametrize("cameras", [0, 3])
def test_a_scene_told_otherwise_has_the_same_order(change, cameras):
    """A ball far off is taken too, and what lies on the shortest way to it comes last."""
    rng = np.random.default_rng(5)
    boxes = pile(rng, 8)
    scene = seen(boxes, rng, cameras) if cameras else whole(boxes, rng)
    before, after = order(scene), order(CHANGES[change](scene, rng))
    assert len(before.order) > 3
    assert after.order == before.order
    assert {(e.first, e.then) for e in after.graph.dependencies} == {
        (e.first, e.then) for e in before.graph.dependencies
    }
