from itertools import combinations

from hypothesis import given, settings
from hypothesis import strategies as st

from topple.planner.report.layout import NODE_HEIGHT, layered

names = [f"n{i}" for i in range(9)]
edge_sets = st.sets(
    st.tuples(st.sampled_from(names), st.sampled_from(names)).filter(lambda edge: edge[0] != edge[1])
)
acyclic = edge_sets.map(lambda edges: {edge for edge in edges if edge[0] < edge[1]})


def laid_out(edges):
    return layered(names, {edge: "supported" for edge in sorted(edges)}, {name: name for name in names})


@given(edge_sets)
@settings(max_examples=60, deadline=None)
def test_no_two_boxes_overlap_and_all_lie_in_the_drawing(edges):
    layout = laid_out(edges)
    assert set(layout.centres) == set(names)
    for (a, (x, y)), (b, (u, v)) in combinations(layout.centres.items(), 2):
        apart = abs(x - u) >= (layout.widths[a] + layout.widths[b]) / 2 - 1e-6
        assert apart or abs(y - v) >= NODE_HEIGHT
    for name, (x, y) in layout.centres.items():
        assert x - layout.widths[name] / 2 >= 0 and x + layout.widths[name] / 2 <= layout.width
        assert 0 <= y - NODE_HEIGHT / 2 and y + NODE_HEIGHT / 2 <= layout.height


@given(acyclic)
@settings(max_examples=60, deadline=None)
def test_what_goes_first_stands_above(edges):
    layout = laid_out(edges)
    assert set(layout.routes) == edges
    for first, then in edges:
        assert layout.centres[first][1] < layout.centres[then][1]
        ys = [y for _, y in layout.routes[(first, then)]]
        assert ys == sorted(ys)


@given(edge_sets)
@settings(max_examples=60, deadline=None)
def test_no_label_covers_a_box(edges):
    layout = laid_out(edges)
    assert set(layout.labels) <= edges  # one that finds no room is left out
    assert bool(layout.labels) == bool(edges)
    for x, y in layout.labels.values():
        for name, (u, v) in layout.centres.items():
            assert abs(x - u) > layout.widths[name] / 2 or abs(y - v) > NODE_HEIGHT / 2


def test_nothing_to_draw_is_no_error():
    layout = layered([], {}, {})
    assert layout.centres == {} and layout.width > 0 and layout.height > 0
