"""The fewest moves of a rearrangement, by integer programming over what passes through a buffer.

With free table to spare nothing needs more than one buffer: away with its first move, to its goal with its
last. A thing that goes straight to its goal is taken and put at one moment. What must happen before what then
must close no cycle: of every cycle that is closed by such moments, one of these things has to pass through a
buffer. Of these inequalities there are too many to write down; those that a solution violates are added until
it violates none. The least cost of the inequalities known so far is a bound for any sequence of moves.

The idea of buffers as a minimum feedback vertex set is that of Han et al., "Complexity Results and Fast
Methods for Optimal Tabletop Rearrangement with Overhand Grasps", IJRR 2018.
"""

from collections.abc import Callable, Collection
from dataclasses import dataclass
from itertools import pairwise

import networkx as nx
import numpy as np
from scipy.optimize import Bounds, milp
from scipy.sparse.csgraph import dijkstra

from topple.planner.budget import check_budget, seconds_left
from topple.planner.errors import NoSafePlan
from topple.planner.rearranging.problem import Act, Event, Move, Problem, To
from topple.planner.rearranging.tolerances import HARD, NODES
from topple.topology.base.arrays import FloatArray


@dataclass(frozen=True)
class Moves:
    """A sequence of moves with its proof.

    Attributes:
        moves: First to do first.
        bound: No sequence has fewer moves than this.
    """

    moves: tuple[Move, ...]
    bound: int

    @property
    def optimal(self) -> bool:
        """Whether the bound proves that no sequence is shorter."""
        return len(self.moves) <= self.bound

    @property
    def in_buffers(self) -> tuple[str, ...]:
        """Objects put out of the way, in this order."""
        return tuple(move.object for move in self.moves if move.to is To.BUFFER)


def fewest_moves(problem: Problem) -> Moves:
    """Find the shortest sequence of moves, with buffers beside everything.

    Args:
        problem: What is to be moved, and what must happen before what.

    Returns:
        The moves; `bound` counts moves.

    Raises:
        NoSafePlan: What must happen before what closes a cycle that no buffer opens.
        OutOfBudget: The budget of the call ran out.
    """
    programme = Buffers(problem)
    chosen = programme.solve()
    return Moves(tuple(sequence(problem, chosen)), programme.bound)


class Buffers:
    """The integer programme: which objects pass through a buffer, for the fewest moves.

    Attributes:
        bound: No sequence of moves is shorter.
    """

    def __init__(self, problem: Problem) -> None:
        self._problem = problem
        self._names = (*problem.moving, *problem.staying)
        self._at = {name: k for k, name in enumerate(self._names)}
        self.costs: FloatArray = np.array([1.0] * len(problem.moving) + [2.0] * len(problem.staying))
        self._rows: dict[frozenset[tuple[int, float]], float] = {}
        self.bound = len(problem.moving)
        for first, then in sorted(problem.before):
            self._leave(first, then)

    def solve(self, costs: FloatArray | None = None, nodes: int = NODES) -> frozenset[str]:
        """Choose what passes through a buffer.

        Args:
            nodes: Of the search trees, all in all: what was found by then is completed greedily.
            costs: (N,) other costs, to draw another one of equally good choices.

        Returns:
            Names with which nothing closes a cycle.

        Raises:
            NoSafePlan: Nothing opens some cycle.
            OutOfBudget: The budget of the call ran out.
        """
        while nodes > 0:
            chosen, visited = self._cheapest_names(nodes, costs)
            nodes -= max(visited, 1)
            if chosen is None:
                break
            if not (cycles := self._cycles(chosen)):
                return chosen
            for cycle in cycles:
                self._rows[frozenset((k, 1.0) for k in cycle)] = 1.0
        return self._complete(frozenset())

    def _leave(self, first: Event, then: Event) -> None:
        """Move a staying object after all where its leaving is waited for, or its return has to wait."""
        for (act, name), waits, other in ((first, Act.TAKE, then[1]), (then, Act.PUT, first[1])):
            if act is waits and name in self._problem.staying and name != other:
                entry = (self._at[name], 1.0)
                if other in self._problem.moving:
                    self._rows[frozenset((entry,))] = 1.0
                else:
                    self._rows[frozenset((entry, (self._at[other], -1.0)))] = 0.0

    def _cheapest_names(self, nodes: int, costs: FloatArray | None) -> tuple[frozenset[str] | None, int]:
        """The cheapest names that satisfy the known inequalities, None where unknown; and how many nodes."""
        if not self._rows:
            return frozenset(), 0
        check_budget()
        matrix = np.zeros((len(self._rows), len(self._names)))
        for row, entries in enumerate(self._rows):
            for k, value in entries:
                matrix[row, k] = value
        found = milp(
            self.costs if costs is None else costs,
            integrality=np.ones(len(self._names)),
            bounds=Bounds(0, 1),
            constraints=(matrix, np.array(list(self._rows.values())), np.inf),
            options={"time_limit": seconds_left(), "node_limit": nodes},
        )
        check_budget()
        if costs is None and found.mip_dual_bound is not None:
            self.bound = max(
                self.bound, len(self._problem.moving) + int(np.ceil(found.mip_dual_bound - 1e-6))
            )
        visited = int(found.mip_node_count or 0)
        if found.x is None:
            return None, visited
        chosen = (name for name, value in zip(self._names, found.x, strict=True) if value > 0.5)
        return frozenset(chosen), visited

    def _cycles(self, chosen: Collection[str]) -> list[frozenset[int]]:
        """For everything that is to happen before another a least cycle it is in, as what has to open it."""
        events = [(act, name) for name in self._names for act in Act if not self._absent(name, chosen)]
        at = {event: k for k, event in enumerate(events)}
        pairs = [(at[a], at[b]) for a, b in sorted(self._problem.before) if a in at and b in at]
        weights = np.zeros((len(events), len(events)))
        for name in {name for _, name in events}:
            take, put = at[Act.TAKE, name], at[Act.PUT, name]
            weights[take, put] = HARD
            weights[put, take] = 0.0 if name in chosen else 1.0
        for a, b in pairs:
            weights[a, b] = HARD
        far, previous = dijkstra(weights, return_predecessors=True)
        found: dict[frozenset[int], None] = {}
        for a, b in pairs:
            if events[a][1] == events[b][1] or not np.isfinite(far[b, a]):
                continue
            back = [a]
            while back[-1] != b:
                back.append(int(previous[b, back[-1]]))
            passed = {
                events[k][1]
                for k, then in pairwise(reversed(back))
                if events[k][0] is Act.PUT and events[then] == (Act.TAKE, events[k][1])
            }
            if not passed:
                words = tuple(f"{events[k][0]} {events[k][1]}" for k in [*reversed(back), b])
                raise NoSafePlan(f"no buffer opens the cycle {' before '.join(words)}", words)
            found[frozenset(self._at[name] for name in passed)] = None
        return list(found)

    def _absent(self, name: str, chosen: Collection[str]) -> bool:
        return name in self._problem.staying and name not in chosen

    def _complete(self, chosen: frozenset[str]) -> frozenset[str]:
        """Names added until nothing closes a cycle: each time what is in most of the cycles found."""
        while cycles := self._cycles(chosen):
            counts = np.bincount([k for cycle in cycles for k in cycle], minlength=len(self._names))
            chosen |= {self._names[int(np.argmax(counts))]}
        return chosen


Node = tuple[str, str]
"""A move, and of what: "take" to a buffer, "put" from there, or "move" straight to the goal."""


def contract(problem: Problem, chosen: Collection[str]) -> "nx.DiGraph[Node]":
    """Order the events: an object that goes straight to its goal is one node, others are two.

    Args:
        problem: What is to be moved.
        chosen: What passes through a buffer. What stays and is not chosen is left out.
    """
    graph: nx.DiGraph[Node] = nx.DiGraph()
    gone = set(problem.staying) - set(chosen)

    def node(event: Event) -> Node:
        return (str(event[0]) if event[1] in chosen else "move", event[1])

    pairs = [((Act.TAKE, name), (Act.PUT, name)) for name in (*problem.moving, *problem.staying)]
    for first, then in (*pairs, *sorted(problem.before)):
        if not {first[1], then[1]} & gone:
            graph.add_nodes_from((node(first), node(then)))
            if node(first) != node(then):
                graph.add_edge(node(first), node(then))
    return graph


Preference = Callable[[str], float]
"""Of several things that could be moved away, the one with the least is."""


def sequence(problem: Problem, chosen: Collection[str], preference: Preference | None = None) -> list[Move]:
    """Order the moves so that things are in buffers as shortly as may be.

    Args:
        problem: What is to be moved.
        chosen: What passes through a buffer.
        preference: Draws what is put out of the way next; where not given, that after which most can go.

    Returns:
        The moves. What can go to its goal does, from a buffer first.
    """
    graph = contract(problem, chosen)
    left: dict[Node, int] = {node: graph.in_degree(node) for node in graph}
    moves: list[Move] = []

    def done_with(node: Node, left: dict[Node, int]) -> None:
        del left[node]
        for then in graph.successors(node):
            left[then] -= 1

    def gain(node: Node) -> int:
        """How much can go to its goal once a node is done."""
        then, count = dict(left), 0
        done_with(node, then)
        while ready := [n for n, open_ in then.items() if open_ == 0 and n[0] != "take"]:
            done_with(ready[0], then)
            count += 1
        return count

    while left:
        ready = sorted(node for node, count in left.items() if count == 0)
        goals = sorted((node for node in ready if node[0] != "take"), key=lambda n: n[0] != "put")
        if goals:
            node = goals[0]
        elif preference is not None:
            node = min(ready, key=lambda n: preference(n[1]))
        else:
            node = max(ready, key=gain)
        done_with(node, left)
        moves.append(Move(node[1], To.BUFFER if node[0] == "take" else To.GOAL))
    return moves
