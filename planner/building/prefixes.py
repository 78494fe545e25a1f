"""Of all orders in which units may be put down, one whose every prefix stands, with the fewest holds.

A hold keeps an object still. It only ever helps, so what is held may as well be held from its placing to the
end while the number of holds is searched for; afterwards each is made as short as it can be.
"""

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass
from heapq import heapify, heappop, heappush
from typing import Any

import networkx as nx
import numpy as np

from topple.planner.building.tolerances import MOST_STATES
from topple.topology.base.arrays import FloatArray

Names = frozenset[str]

Units = tuple[list[tuple[str, ...]], list[frozenset[int]]]
"""Names that are put down together, and the positions of the units that must be down before each."""

Falling = Callable[[Names, Names], Collection[str]]
"""(placed, held) -> those of the placed that do not stand while the held are kept still."""


def aside(distance: float) -> FloatArray:
    """(5, 3) shifts [m] with which a part has to stand: none, and a distance to each of four level sides."""
    return distance * np.array([[0, 0, 0], [1, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0]])


@dataclass(frozen=True)
class Prefixes:
    """An order whose every prefix stands.

    Attributes:
        path: Positions of the units, first to put down first.
        held: name -> (first, last): it is held from the placing of the unit at `path[first]` until the one at
            `path[last]` is down.
        proven: Whether no order needs fewer holds.
    """

    path: tuple[int, ...]
    held: Mapping[str, tuple[int, int]]
    proven: bool


_State = tuple[tuple[int, ...], Names]
"""Positions of the units put down so far, and what is held."""


def fewest_holds(
    units: Sequence[Sequence[str]],
    before: Sequence[frozenset[int]],
    falling: Falling,
    meeting: "nx.Graph[str]",
    most_states: int = MOST_STATES,
    clamped: Names = frozenset(),
) -> Prefixes:
    """Search all orders, those with fewer holds first, and of these those that prefer earlier units.

    Args:
        units: Names that are put down together, those to be preferred first.
        before: Positions of the units that must be down before each; they close no cycle.
        falling: What does not stand; nothing where everything is in place, and nothing that is held.
        meeting: Which objects are in contact: holding one helps only those it hangs together with.
        most_states: How many partial arrangements are tried until the first order found is taken.
        clamped: What a fixture holds from when it is down: it costs no hold.

    Returns:
        The order, with holds as short as they can be.
    """
    queue: list[tuple[tuple[object, ...], _State]] = []
    tried = 0

    def cost(path: tuple[int, ...], held: Names) -> tuple[object, ...]:
        counts = (len(held), -len(path)) if tried < most_states else (-len(path), len(held))
        return (*counts, path, sorted(held))

    heappush(queue, (cost((), clamped), ((), clamped)))
    stood: dict[frozenset[int], list[Names]] = {}
    while True:
        path, held = heappop(queue)[1]
        down = frozenset(path)
        if any(fewer <= held for fewer in stood.get(down, ())):
            continue
        tried += 1
        if tried == most_states:
            queue = [(cost(*state), state) for _, state in queue]
            heapify(queue)
        placed = names_of(units, path)
        fallen = falling(placed, held)
        for name in _neighbours(fallen, placed, meeting) - held:
            heappush(queue, (cost(path, held | {name}), (path, held | {name})))
        if fallen:
            continue
        stood.setdefault(down, []).append(held)
        if len(path) == len(units):
            return Prefixes(path, _shortest(units, path, held, falling), tried < most_states)
        for unit, needed in enumerate(before):
            if unit not in down and needed <= down:
                heappush(queue, (cost((*path, unit), held), ((*path, unit), held)))


def in_units(part: Collection[str], over: Collection[tuple[str, str]], rank: Callable[[str], Any]) -> Units:
    """Group the objects that have to be put down together, and find the groups that come before each.

    Args:
        part: Names.
        over: (below, above): the first of each pair has to be down before the second.
        rank: Smaller for names to be preferred.

    Returns:
        The units, those to be preferred first, and the positions of those that must be down before each.
        Pairs that close a cycle make one unit.
    """
    below: nx.DiGraph[str] = nx.DiGraph()
    below.add_nodes_from(part)
    below.add_edges_from((a, b) for a, b in over if a in part and b in part)
    condensed = nx.condensation(below)
    units = {c: tuple(sorted(condensed.nodes[c]["members"], key=rank)) for c in condensed}
    ranked = sorted(units, key=lambda c: rank(units[c][0]))
    place = {c: k for k, c in enumerate(ranked)}
    before = [frozenset(place[p] for p in condensed.predecessors(c)) for c in ranked]
    return [units[c] for c in ranked], before


def names_of(units: Sequence[Sequence[str]], path: Collection[int]) -> Names:
    """The objects of some units."""
    return frozenset(name for unit in path for name in units[unit])


def _neighbours(fallen: Collection[str], placed: Names, meeting: "nx.Graph[str]") -> Names:
    """Objects that hang together with those that fall, these included."""
    there = meeting.subgraph(placed)
    return frozenset(fallen).union(*(nx.node_connected_component(there, n) for n in fallen if n in there))


def _shortest(
    units: Sequence[Sequence[str]], path: tuple[int, ...], held: Names, falling: Falling
) -> dict[str, tuple[int, int]]:
    """Each hold begun as late and ended as early as the others, made so before it, allow."""
    placed = [names_of(units, path[: k + 1]) for k in range(len(path))]
    spans = {name: (next(k for k, there in enumerate(placed) if name in there), len(path)) for name in held}

    def stands(k: int, without: str) -> bool:
        still = {n for n, (first, last) in spans.items() if n != without and first <= k < last}
        return not falling(placed[k], frozenset(still))

    for name in sorted(held):
        first, last = spans[name]
        while last > first and stands(last - 1, name):
            last -= 1
        while first < last and stands(first, name):
            first += 1
        spans[name] = (first, last)
    return {name: span for name, span in spans.items() if span[0] < span[1]}
