"""A top's edge is where its own side is seen below it, and not where a picture of it ends."""

import numpy as np
from by_the_edge import END, by_the_edge

from topple.topology.bodies.edges import edge_ahead, top_under

AHEAD, MIDDLE = np.array([0.0, 1.0, 0.0]), np.array([-0.1, 0.05, 0.0])
WIDE = [(-0.08, 0.08)]


def test_an_edge_is_where_the_side_of_the_table_is_seen() -> None:
    scene = by_the_edge()
    found = top_under("book", scene)
    assert found is not None and found[0] == "table"
    edge = edge_ahead(*found, scene, MIDDLE, AHEAD, WIDE)
    assert edge is not None
    assert np.allclose(edge.outward, AHEAD, atol=0.02)
    beyond = edge.beyond(np.array([[0.0, END + 0.03, 0.0], [0.0, END - 0.05, 0.0]]))
    assert np.allclose(beyond, [0.03, -0.05], atol=0.004)


def test_the_end_of_what_was_seen_is_no_edge() -> None:
    scene = by_the_edge(side=False)
    found = top_under("book", scene)
    assert found is not None
    assert edge_ahead(*found, scene, MIDDLE, AHEAD, WIDE) is None
    ended = by_the_edge()  # the other ends of the same table show no side either
    for away in (-AHEAD, np.array([1.0, 0.0, 0.0])):
        assert edge_ahead(*found, ended, MIDDLE, away, WIDE) is None


def test_an_edge_that_is_not_square_to_the_way_is_none() -> None:
    scene = by_the_edge()
    found = top_under("book", scene)
    assert found is not None
    askew = np.array([np.sin(0.6), np.cos(0.6), 0.0])
    assert edge_ahead(*found, scene, MIDDLE, askew, WIDE) is None
