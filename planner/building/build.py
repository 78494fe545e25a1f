"""Build order: how a finished arrangement is put together, base first, so that every part of it stands."""

import math
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import networkx as nx

from topple.planner.building.prefixes import Falling, Prefixes, fewest_holds
from topple.planner.building.standing import falling_in
from topple.planner.decide.arrange import Order
from topple.planner.decide.assumptions import assumptions
from topple.planner.decide.chances import reasoned
from topple.planner.decide.dependency import Dependency, DependencyGraph, Reason, dependencies
from topple.topology.errors import InvalidInput
from topple.topology.evidence import Evidence
from topple.topology.situation import Situation
from topple.topology.statics.gravity import check_up
from topple.topology.statics.rest import Statics
from topple.topology.statics.tolerances import UNSTEADY
from topple.topology.values import FrozenDict

if TYPE_CHECKING:
    from topple.topology.relations import Relations
    from topple.topology.scene import Scene


class Footing(Dependency):
    """`first` has to be down before `then` is: the dependency of their removal, the other way round."""

    def sentence(self) -> str:
        """The reason in words."""
        if self.reason is Reason.BLOCKING:
            told = f"{self.then} would be in the way of putting {self.first} down"
            return f"{self.first} before {self.then}: {told}"
        return f"{self.first} before {self.then}: {self.removal().sentence()}"

    def removal(self) -> Dependency:
        """The dependency as it is when the two are taken away."""
        return Dependency(self.then, self.first, self.reason, self.confidence, self.evidence, self.lies)

    @staticmethod
    def of(removal: Dependency) -> "Footing":
        """What a dependency between two removals means for putting down."""
        first, then = removal.then, removal.first
        return Footing(first, then, removal.reason, removal.confidence, removal.evidence, removal.lies)


@dataclass(frozen=True)
class Hold:
    """An object that stands only when it is held until a later one is there.

    Attributes:
        object: What is held.
        since: What is put down as the hold begins: the object itself, or what it could not carry alone.
        until: What has to be down before it is let go.
        because: Why, in words.
        evidence: The relations this rests on.
    """

    object: str
    since: str
    until: str
    because: str
    evidence: tuple[Evidence, ...] = ()

    def to_json(self) -> dict[str, Any]:
        """The hold as the JSON of `topple order --build` has it."""
        evidence = [each.to_json() for each in self.evidence]
        return {
            "object": self.object, "since": self.since, "until": self.until,
            "because": self.because, "evidence": evidence,
        }  # fmt: skip


@dataclass(frozen=True, eq=False)
class BuildOrder(Order):
    """An order to put things down in, base first; its dependencies are `Footing`s.

    Attributes:
        holds: What has to be held meanwhile.
        proven: Whether no order needs fewer holds.
        footings: What the order keeps, also what follows from the direct ones of `graph`.
    """

    holds: tuple[Hold, ...] = ()
    proven: bool = True
    footings: tuple[Footing, ...] = ()

    def to_json(self) -> dict[str, Any]:
        """The object that `topple order --build --json` prints."""
        holds = [hold.to_json() for hold in self.holds]
        return {**super().to_json(), "build": True, "holds": holds, "fewest_holds_proven": self.proven}


def build_order(scene: "Scene | Situation", *, relations: "Relations | None" = None) -> BuildOrder:
    """Find in which order to put down the things of a finished arrangement.

    Each is lowered straight down into its place, past nothing that already stands (6IM of the swept body);
    what is down stands by itself (static equilibrium), or is held until it does, with the fewest holds.

    Args:
        scene: The finished arrangement, which knows where up is, or the situation it was read as.
        relations: Its relations where they are known.

    Returns:
        The order. What hooks into each other goes down together, as a group.

    Raises:
        InvalidInput: The scene has no `up`, or hangs in the air with it and would stand with another; nothing
            in it can move.
    """
    situation = Situation.of(scene, relations)
    scene, statics = situation.scene, situation.statics
    if not scene.movable:
        raise InvalidInput("nothing in the scene can move: every object is fixed")
    check_up(scene, statics)
    full = dependencies(situation, direct=False)
    over = [(e.then, e.first) for e in full.dependencies if any(each.swept for each in e.evidence)]
    meeting: nx.Graph[str] = nx.Graph()
    meeting.add_nodes_from(scene.movable)
    meeting.add_edges_from((c.a, c.b) for c in statics.contacts if {c.a, c.b} <= meeting.nodes)
    falling = falling_in(statics)
    parts = nx.connected_components(nx.Graph([*meeting.edges, *over, *((n, n) for n in meeting)]))
    steps: list[str] = []
    holds: list[Hold] = []
    groups: list[tuple[str, ...]] = []
    proven = True
    for part in sorted(parts, key=lambda names: min(map(scene.movable.index, names))):
        units, found = _ordered(part, over, statics, falling, meeting)
        chosen = [units[k] for k in found.path]
        steps += [name for unit in chosen for name in unit]
        groups += [unit for unit in chosen if len(unit) > 1]
        holds += [
            _hold(name, chosen[first][-1], chosen[last][-1], full, situation)
            for name, (first, last) in sorted(found.held.items(), key=lambda each: each[1])
        ]
        proven = proven and found.proven
    place = {name: k for k, name in enumerate(steps)}
    kept = tuple(Footing.of(e) for e in full.dependencies if place[e.then] < place[e.first])
    graph = DependencyGraph(full.names, kept).reduced()
    chances = reasoned(full, statics, len(scene.viewpoints) or None)
    return BuildOrder(
        targets=(),
        order=tuple(steps),
        graph=graph,
        supports=situation.supports,
        groups=tuple(groups),
        unresolved=(),
        risk=FrozenDict(_risks(steps, holds, chances)),
        assumptions=(*scene.assumptions, *assumptions(scene, statics), *_unsteady(statics)),
        explanation=_explained(steps, holds, groups, graph),
        chances=FrozenDict({(then, first): chance for (first, then), chance in chances.items()}),
        holds=tuple(holds),
        proven=proven,
        footings=kept,
    )


def _ordered(
    part: Collection[str],
    over: Sequence[tuple[str, str]],
    statics: Statics,
    falling: Falling,
    meeting: "nx.Graph[str]",
) -> tuple[list[tuple[str, ...]], Prefixes]:
    """The units of what hangs together, the lowest first, and the best order of them."""
    below: nx.DiGraph[str] = nx.DiGraph()
    below.add_nodes_from(part)
    below.add_edges_from((a, b) for a, b in over if a in part)
    low = {name: float(statics.surfaces[name][:, 2].min()) for name in part}
    condensed = nx.condensation(below)
    units = {c: tuple(sorted(condensed.nodes[c]["members"], key=lambda n: (low[n], n))) for c in condensed}
    ranked = sorted(units, key=lambda c: (round(low[units[c][0]], 2), units[c]))
    place = {c: k for k, c in enumerate(ranked)}
    before = [frozenset(place[p] for p in condensed.predecessors(c)) for c in ranked]
    others = frozenset(statics.upright.movable) - frozenset(part)
    ordered = [units[c] for c in ranked]
    return ordered, fewest_holds(
        ordered, before, lambda placed, held: placed & frozenset(falling(placed | others, held)), meeting
    )


def _hold(name: str, since: str, until: str, removals: DependencyGraph, situation: Situation) -> Hold:
    """A hold with its reason: what would move if `until` were taken away again."""
    edge = removals.between(name, until)
    if edge is None:
        why = f"it does not stand safely without {until}"
        return Hold(name, since, until, why, situation.chain(name, until))
    return Hold(name, since, until, edge.sentence(), edge.evidence)


def _unsteady(statics: Statics) -> tuple[str, ...]:
    """What does not stand in the finished arrangement, as far as its weights are known."""
    found = [name for name, missing in statics.unexplained.items() if missing > UNSTEADY]
    return tuple(
        f"{name} stands in the whole arrangement, though its contacts do not show how" for name in found
    )


def _risks(
    steps: Sequence[str], holds: Sequence[Hold], chances: Mapping[tuple[str, str], float]
) -> dict[str, float]:
    """Chance that a thing moves as it is put down, since something that is still to come carries it."""
    held = {hold.object for hold in holds}
    return {
        name: 0.0 if name in held else 1.0 - math.prod(1.0 - chances.get((name, n), 0.0) for n in steps[k:])
        for k, name in enumerate(steps, start=1)
    }


def _explained(
    steps: Sequence[str],
    holds: Sequence[Hold],
    groups: Sequence[tuple[str, ...]],
    graph: DependencyGraph,
) -> tuple[str, ...]:
    """One sentence per step: what had to be down before it, and what is held."""
    told: list[str] = []
    for number, name in enumerate(steps, start=1):
        why = [edge.sentence() for edge in graph.dependencies if edge.then == name]
        said = "; ".join(why) or "nothing has to be down before it"
        for hold in holds:
            if hold.since == name:
                said += f"; hold {hold.object} until {hold.until} is down: {hold.because}"
            if hold.until == name:
                said += f"; then let {hold.object} go"
        for group in groups:
            if name == group[0]:
                said += f"; {' and '.join(group)} hook into each other: put them down together"
        told.append(f"{number}. {name}: {said}")
    return tuple(told)
