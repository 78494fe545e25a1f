"""The safest order that a dependency graph allows, and what is said of it."""

import math
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import groupby, repeat
from typing import Any, NamedTuple

import networkx as nx

from topple.planner.decide.dependency import DependencyGraph
from topple.planner.decide.hold import Hold
from topple.planner.decide.names import rename
from topple.planner.decide.sequence import safest
from topple.planner.decide.words import first_rows, order_heading, order_notes, order_rows
from topple.topology.base.arguments import checked_arguments
from topple.topology.base.arrays import FloatArray
from topple.topology.base.notebook import in_cell
from topple.topology.base.values import ByValue, FrozenDict, in_columns
from topple.topology.statics.support import Support


@dataclass(frozen=True)
class Apart:
    """How what an order takes comes apart with a second hand.

    Attributes:
        order: The names, first to take first.
        holds: What has to be held meanwhile.
        proven: Whether no order needs fewer holds.
        unresolved: What as many hands as there are cannot take apart; None where nobody said how many.
    """

    order: tuple[str, ...]
    holds: tuple[Hold, ...] = ()
    proven: bool = True
    unresolved: tuple[tuple[str, ...], ...] | None = None


TakeApart = Callable[[Sequence[str], Sequence[Sequence[str]]], Apart]
"""(order to be preferred, its groups) -> how it comes apart."""


class OrderStep(NamedTuple):
    """A step of an order, as `for step in order` gives it.

    Attributes:
        object: What is taken.
        reason: Why at this place, in words.
        risk: Chance, 0..1, that taking it moves something else.
        before: What has to go before it, first to go first.
    """

    object: str
    reason: str
    risk: float
    before: tuple[str, ...]


@dataclass(frozen=True, eq=False)
class Order(ByValue):
    """A safe order, and everything it was derived from; `for step in order` gives an `OrderStep` each.

    Attributes:
        targets: What is to be freed; the last of `order`.
        order: Names, first to take first; exactly the targets and all that must go before them. Of a
            rearrangement a name for each move: what makes room stands in it twice.
        graph: Dependencies among all movable objects.
        supports: What carries what.
        groups: Objects of one cycle that must be taken together or held.
        unresolved: What as many hands as there are cannot take apart; empty where nobody said how many.
        risk: name -> chance, 0..1, that taking it at its turn moves something that is still there. It ranks
            steps; as a chance it is hardly better than how often steps move something at all (`calibrated`).
        access: With a robot, what bars the gripper's way: mappings with first, then, reason.
        assumptions: What was assumed and not seen, in sentences.
        explanation: One sentence per step.
        verified: True where simulation has checked the order.
        chances: (first, then) -> chance that taking `then` moves `first`, as this scene shows it.
        notes: More entries of the JSON object.
        called: How people call what a label's number names; print says it.
        holds: What a second hand has to hold so that it comes apart.
        proven: Whether no order of the groups needs fewer holds.

    Examples:
        >>> found = order(scene, "book")
        >>> found.next.object, found.next.reason
        ('cup', 'it rests on book.')
        >>> for step in found:
        ...     print(step.object, "before", step.before)
        cup before ()
        book before ('cup',)
    """

    targets: tuple[str, ...]
    order: tuple[str, ...]
    graph: DependencyGraph
    supports: tuple[Support, ...]
    groups: tuple[tuple[str, ...], ...]
    unresolved: tuple[tuple[str, ...], ...]
    risk: Mapping[str, float]
    access: tuple[Mapping[str, str], ...] = ()
    assumptions: tuple[str, ...] = ()
    explanation: tuple[str, ...] = ()
    verified: bool = False
    chances: Mapping[tuple[str, str], float] = field(default_factory=lambda: FrozenDict({}))
    notes: Mapping[str, Any] = field(default_factory=lambda: FrozenDict({}))
    holds: tuple[Hold, ...] = ()
    proven: bool = True
    called: Mapping[str, str] = field(default_factory=lambda: FrozenDict({}), compare=False, repr=False)

    def _repr_html_(self) -> str | None:
        """Show the order in a notebook."""
        return in_cell(self)

    def __iter__(self) -> Iterator[OrderStep]:
        """The steps, first to take first."""
        for _, name, reason, _ in order_rows(self.to_json()):
            needed = self.graph.before(name)
            before = tuple(other for other in dict.fromkeys(self.order) if other in needed)
            yield OrderStep(name, reason, self.risk.get(name, 0.0), before)

    @property
    def next(self) -> OrderStep | None:
        """The first step; None where nothing is to be taken."""
        return next(iter(self), None)

    def __str__(self) -> str:
        """The steps as `topple order` prints them, what is held, and what has no order."""
        document = rename(self.to_json(), self.called)
        rows, told = first_rows(document)
        lines = [*in_columns([(number, name, sure, why) for number, name, why, sure in rows]), *told]
        lines += order_notes(document)
        cycles = rename(self.certificate, self.called)
        lines += [f"no safe order: each has to go first, {cycle}" for cycle in cycles]
        return "\n".join([order_heading(document, len(self.graph.names)), *lines])

    @property
    def certificate(self) -> tuple[str, ...]:
        """Why there is no safe order: each unresolved cycle, and what would have to be held."""
        return tuple(
            " before ".join([*cycle, cycle[0]])
            + "".join(f"; with more hands, {h.sentence(self.order)}" for h in self.holds if h.object in cycle)
            for cycle in self.unresolved
        )

    def as_taken(self, steps: Sequence[str]) -> "Order":
        """The order as it is carried out: what the arm can take now goes first, what is gone is left out.

        Args:
            steps: Names of this order, first to take first.
        """
        if tuple(steps) == self.order:
            return self
        gone = set(self.order) - set(steps)
        edges = (edge for edge in self.graph.dependencies if not {edge.first, edge.then} & gone)
        graph = DependencyGraph(tuple(n for n in self.graph.names if n not in gone), tuple(edges))
        left = (tuple(name for name in group if name not in gone) for group in self.groups)
        cycles = {frozenset(cycle) for cycle in graph.cycles()}
        groups = tuple(group for group in left if frozenset(group) in cycles)
        holds = tuple(hold for hold in self.holds if {hold.since, hold.until} <= set(steps))
        wanted = set(self.targets or graph.names)
        return replace(
            self,
            order=tuple(steps),
            graph=graph,
            groups=groups,
            holds=holds,
            risk=FrozenDict({name: self.risk[name] for name in steps if name in self.risk}),
            explanation=_explain(steps, groups, graph, wanted, self.chances, holds),
        )

    def to_json(self) -> dict[str, Any]:
        """The object that `topple order --json` prints."""
        return {
            "format": "topple.order",
            "format_version": 1,
            "targets": list(self.targets),
            "order": list(self.order),
            "dependencies": [edge.to_json() for edge in self.graph.dependencies],
            "supports": [support.to_json() for support in self.supports],
            "groups": [list(group) for group in self.groups],
            "holds": [hold.to_json() for hold in self.holds],
            "fewest_holds_proven": self.proven,
            "unresolved": [list(cycle) for cycle in self.unresolved],
            "risk": {name: round(risk, 3) for name, risk in self.risk.items()},
            "calibrated": False,
            "access": [dict(entry) for entry in self.access],
            "assumptions": list(self.assumptions),
            "explanation": list(self.explanation),
            "verified": self.verified,
            **self.notes,
        }


@checked_arguments
def arrange(
    graph: DependencyGraph,
    targets: Sequence[str],
    tops: Mapping[str, FloatArray],
    carried: tuple[Support, ...] = (),
    assumptions: tuple[str, ...] = (),
    chances: Mapping[tuple[str, str], float] | None = None,
    removal_risk: float | None = None,
    take_apart: TakeApart | None = None,
) -> Order:
    """Order the objects of a dependency graph.

    Args:
        graph: What must go before what.
        targets: What is to be freed; all objects where empty.
        tops: name -> (3,) highest point [m]. Of orders equally safe the one with the shortest level way from
            top to top is taken, and of those equally short the one that takes the highest first.
        carried: Supports to report.
        assumptions: Sentences to report.
        chances: (first, then) -> chance that there is a dependency, whatever the graph says: of all orders
            that the graph allows, the safest is taken.
        removal_risk: See `order`.
        take_apart: Says how groups come apart with a second hand. Without it a group begins where its edges
            are the least certain.

    Returns:
        The order with fewest removals: the targets and their ancestors, cycles as groups; or, where
        `removal_risk` is given, the one with the least risk.

    Examples:
        >>> tops = {name: cloud.max(axis=0) for name, cloud in scene.clouds.items()}
        >>> arrange(dependencies(scene), ["book"], tops).order
        ('cup', 'book')
    """
    wanted = tuple(targets) or graph.names
    needed = set(wanted).union(*(graph.before(name) for name in targets))
    part = graph.graph().subgraph(needed if removal_risk is None else graph.names)
    height = {name: float(top[2]) for name, top in tops.items()}
    condensed = nx.condensation(part)
    members = {c: _least_bad(part.subgraph(condensed.nodes[c]["members"]), height) for c in condensed}
    ranked = sorted(
        members, key=lambda c: (-max(height.get(name, 0.0) for name in members[c]), sorted(members[c]))
    )
    place = {c: i for i, c in enumerate(ranked)}
    chances = {} if chances is None else chances
    chosen = safest(
        [members[c] for c in ranked],
        [frozenset(place[p] for p in condensed.predecessors(c)) for c in ranked],
        chances,
        # how far down the arm reaches is the same in any order: the way between the takes is level
        {name: top[:2] for name, top in tops.items()},
        frozenset(i for i, c in enumerate(ranked) if needed.intersection(members[c])),
        removal_risk or 0.0,
    )
    units = [members[ranked[i]] for i in chosen]
    unit_of = {name: number for number, unit in enumerate(units) for name in unit}
    found = Apart(tuple(unit_of))
    if take_apart is not None:
        found = take_apart(found.order, [unit for unit in units if len(unit) > 1])
    steps = found.order
    sure = () if found.unresolved is None else found.holds
    kept = {(hold.object, name) for hold in sure for name in hold.meanwhile(steps)}
    groups = tuple(tuple(sorted(unit, key=steps.index)) for unit in units if len(unit) > 1)
    units = [list(unit) for _, unit in groupby(steps, unit_of.__getitem__)]
    return Order(
        targets=tuple(targets),
        order=steps,
        graph=graph,
        supports=carried,
        groups=groups,
        unresolved=found.unresolved or (),
        risk=FrozenDict(_risks(units, graph, chances, kept)),
        assumptions=assumptions,
        explanation=_explain(steps, groups, graph, set(wanted), chances, found.holds),
        holds=found.holds,
        proven=found.proven,
    )


def _least_bad(cycle: "nx.DiGraph[str]", heights: Mapping[str, float]) -> list[str]:
    """Order the objects of a cycle so that the edges gone against are the least certain ones."""
    left: nx.DiGraph[str] = nx.DiGraph(cycle)
    steps: list[str] = []
    while len(left):

        def regret(name: str) -> tuple[float, float, str]:
            against = sum(float(d["confidence"]) for _, _, d in left.in_edges(name, data=True))
            return (round(against, 6), -heights.get(name, 0.0), name)

        chosen = min(left.nodes, key=regret)
        steps.append(chosen)
        left.remove_node(chosen)
    return steps


def _risks(
    units: Sequence[Sequence[str]],
    graph: DependencyGraph,
    chances: Mapping[tuple[str, str], float],
    kept: Collection[tuple[str, str]],
) -> dict[str, float]:
    """Chance that a step moves something that is still there, its group apart from the others.

    Args:
        units: What is taken, groups at once.
        graph: What must go before what.
        chances: (first, then) -> chance that taking `then` moves `first`.
        kept: The same pairs where a hand keeps `first` still.
    """
    risk: dict[str, float] = {}
    left = sorted(graph.names)
    for unit in units:
        left = [other for other in left if other not in unit]
        for number, name in enumerate(unit, start=1):
            free = [other for other in left if (other, name) not in kept] if kept else left
            moved = map(chances.get, zip(free, repeat(name), strict=False), repeat(0.0))
            safe = math.prod(1.0 - chance for chance in moved)
            rest = [other for other in unit[number:] if (other, name) not in kept]
            against = [e.confidence for e in graph.dependencies if e.then == name and e.first in rest]
            risk[name] = max(1.0 - safe, *against, 0.0)
    return risk


def _explain(
    steps: Sequence[str],
    groups: Sequence[tuple[str, ...]],
    graph: DependencyGraph,
    wanted: set[str],
    chances: Mapping[tuple[str, str], float],
    holds: Sequence[Hold] = (),
) -> tuple[str, ...]:
    """One sentence per step: what it frees, and why it had to go."""
    sentences: list[str] = []
    last = {name: number for number, name in enumerate(steps, start=1)}
    for number, name in enumerate(steps, start=1):
        edges = [e for e in graph.dependencies if e.first == name and last.get(e.then, 0) > number]
        group = next((g for g in groups if name in g), None)
        say = f"{number}. {name}"
        if edges:
            say += ": " + "; ".join(edge.sentence() for edge in edges)
        elif name in wanted:
            say += ": nothing that is left depends on it"
        elif later := sorted({*steps[number:]}):
            doubted = max(later, key=lambda other: chances.get((name, other), 0.0))
            say += f": taking {doubted} might move it ({chances.get((name, doubted), 0.0):.2f})"
        if group is not None and name == group[0]:
            say += f" ({_cycle_words(group, graph, [h.sentence(steps) for h in holds if h.object in group])})"
        sentences.append(say)
    return tuple(sentences)


def _cycle_words(group: Sequence[str], graph: DependencyGraph, holds: Sequence[str]) -> str:
    """A cycle in words: what holds what, the edge one would rather doubt, and what to do."""
    inside = [e for e in graph.dependencies if e.first in group and e.then in group]
    weakest = min(inside, key=lambda e: (e.confidence, e.first, e.then))
    members: nx.DiGraph[str] = nx.DiGraph([(e.first, e.then) for e in inside])
    ring = [edge[0] for edge in nx.find_cycle(members, group[0])]
    return (
        f"{' and '.join(group)} hold each other: take them together, or "
        f"{' and '.join(holds) or 'hold the others'}; the cycle is "
        f"{' before '.join([*ring, ring[0]])}, and the least certain part of it that {weakest.sentence()} "
        f"({weakest.confidence:.2f})"
    )
