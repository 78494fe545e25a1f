"""How likely each object has to go before each other one, before any simulation."""

from collections.abc import Mapping

import networkx as nx

from topple.planner.decide.dependency import DependencyGraph
from topple.planner.decide.rates import rates_for
from topple.planner.decide.tolerances import MEETING
from topple.topology.statics.rest import Statics


def standing(statics: Statics) -> Mapping[tuple[str, str], tuple[int, int]]:
    """How objects stand to each other.

    Args:
        statics: The scene at rest.

    Returns:
        (first, then) -> row and column of `Overlooked`, for every ordered pair of movable objects.
    """
    names = statics.upright.movable
    meeting: nx.Graph[str] = nx.Graph()
    meeting.add_nodes_from(names)
    movable = set(names)
    for contact in statics.contacts:
        if {contact.a, contact.b} <= movable and contact.gaps.min() <= MEETING:
            meeting.add_edge(contact.a, contact.b)
    island = {name: i for i, part in enumerate(nx.connected_components(meeting)) for name in part}
    top = {name: float(statics.surfaces[name][:, 2].max()) for name in names}
    return {
        (first, then): (
            0 if meeting.has_edge(first, then) else 1 if island[first] == island[then] else 2,
            int(top[first] > top[then]),
        )
        for first in names
        for then in names
        if first != then
    }


def reasoned(graph: DependencyGraph, statics: Statics, cameras: int | None) -> dict[tuple[str, str], float]:
    """Chance of every dependency before any simulation.

    Args:
        graph: Dependencies by reasoning, with every edge, not reduced.
        statics: The scene at rest.
        cameras: How many cameras saw the scene; None for whole surfaces.

    Returns:
        (first, then) -> 0..1, for every ordered pair.
    """
    overlooked = rates_for(cameras).overlooked
    chance = {pair: overlooked[row][column] for pair, (row, column) in standing(statics).items()}
    return chance | {(edge.first, edge.then): edge.confidence for edge in graph.dependencies}
