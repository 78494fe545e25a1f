"""What has to be down before a thing so that it stands, beyond what it would be barred by: counterweights."""

from collections.abc import Iterable

import networkx as nx

from topple.planner.building.prefixes import Falling, Names


def brace(names: Iterable[str], below: Iterable[tuple[str, str]], falling: Falling) -> "nx.DiGraph[str]":
    """Add to what must be down before what, until each thing stands on what is before it.

    Args:
        names: The objects of an arrangement.
        below: (a, b): a has to be down before b; without cycles.
        falling: What does not stand of a part of the arrangement.

    Returns:
        All pairs as edges. Where nothing that may come before a thing makes it stand, it is left as it is: it
        would have to be held.
    """
    graph: nx.DiGraph[str] = nx.DiGraph()
    graph.add_nodes_from(names)
    graph.add_edges_from(below)
    still = frozenset[str]()
    for name in list(nx.lexicographical_topological_sort(graph)):
        while falling(there := _with_all_before(graph, name), still):
            later = nx.descendants(graph, name)
            helped = (
                other
                for other in sorted(graph)
                if other not in there and other not in later
                if not falling(there | _with_all_before(graph, other), still)
            )
            helper = min(helped, key=lambda other: (len(_with_all_before(graph, other)), other), default=None)
            if helper is None:
                break
            graph.add_edge(helper, name)
    return graph


def _with_all_before(graph: "nx.DiGraph[str]", name: str) -> Names:
    """A thing and all that has to be down before it."""
    return frozenset(nx.ancestors(graph, name)) | {name}
