from itertools import combinations, pairwise

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from topple.planner.report.graph import HIGH, DrawnGraph

names = [f"n{i}" for i in range(9)]
edge_sets = st.sets(
    st.tuples(st.sampled_from(names), st.sampled_from(names)).filter(lambda edge: edge[0] != edge[1])
)
acyclic = edge_sets.map(lambda edges: {edge for edge in edges if edge[0] < edge[1]})


def drawn(edges):
    ties = [{"first": a, "then": b, "reason": "supported"} for a, b in sorted(edges)]
    return DrawnGraph.of(names, {"order": names, "dependencies": ties})


@given(edge_sets)
@settings(max_examples=60, deadline=None)
def test_no_two_boxes_overlap_and_all_lie_in_the_drawing(edges):
    graph = drawn(edges)
    assert set(graph.boxes) == set(names)
    for (x, y, w), (u, v, width) in combinations(graph.boxes.values(), 2):
        assert abs(x - u) >= (w + width) / 2 - 1e-6 or abs(y - v) >= HIGH
    for x, y, width in graph.boxes.values():
        assert x - width / 2 >= 0 and x + width / 2 <= graph.width
        assert 0 <= y - HIGH / 2 and y + HIGH / 2 <= graph.height


@given(acyclic)
@settings(max_examples=60, deadline=None)
def test_what_goes_first_stands_above(edges):
    graph = drawn(edges)
    assert set(graph.routes) == edges
    for first, then in edges:
        assert graph.boxes[first][1] < graph.boxes[then][1]
        ys = [y for _, y in graph.routes[(first, then)]]
        assert ys == sorted(ys)


@given(edge_sets)
@settings(max_examples=60, deadline=None)
def test_every_arrow_has_its_label(edges):
    assert set(drawn(edges).labels) == edges


@given(acyclic)
@settings(max_examples=60, deadline=None)
def test_no_label_covers_a_box(edges):
    graph = drawn(edges)
    assert bool(graph.labels) == bool(edges)
    for x, y in graph.labels.values():
        for u, v, width in graph.boxes.values():
            assert abs(x - u) > width / 2 or abs(y - v) > HIGH / 2


@given(acyclic)
@settings(max_examples=60, deadline=None)
def test_no_arrow_runs_through_a_box(edges):
    graph = drawn(edges)
    parts = [np.linspace(a, b, 50) for route in graph.routes.values() for a, b in pairwise(route)]
    assert len(parts) >= len(edges)
    for x, y, width in graph.boxes.values():
        for part in parts:
            inside = np.abs(part - (x, y)) < (width / 2 - 0.01, HIGH / 2 - 0.01)
            assert not inside.all(axis=1).any()


def test_nothing_to_draw_is_no_error():
    graph = DrawnGraph.of([], {})
    assert graph.boxes == {} and graph.width > 0 and graph.height > 0
