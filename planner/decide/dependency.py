"""What must go first: a directed graph whose every edge has a reason and the relations it rests on."""

from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass
from functools import cache, partial
from typing import TYPE_CHECKING, Any

import networkx as nx
import numpy as np

from topple.planner.decide.chances import chances, seen_by
from topple.planner.decide.disturbance import (
    Disturbance,
    Pair,
    disturbances,
    fallen_without,
    without_cascades,
)
from topple.planner.decide.rates import oversights
from topple.planner.decide.tolerances import CARRIES, COUNTS, PRESSED, RESTS
from topple.planner.decide.words import WORDS, said
from topple.topology.base.arguments import checked_arguments
from topple.topology.base.errors import InvalidInput, UnknownObject
from topple.topology.base.values import ByValue, Word
from topple.topology.io.load import AnyScene
from topple.topology.situation.evidence import Evidence
from topple.topology.situation.situation import Situation
from topple.topology.sixim.table import Relation
from topple.topology.statics.rest import Statics

if TYPE_CHECKING:
    from topple.topology.relations.relate import Relations


class Reason(Word):
    """Why one object has to go before another."""

    CONTAINED = "contained"
    """It lies in the other."""
    SUPPORTED = "supported"
    """It rests on the other."""
    LEANING = "leaning"
    """It leans on the other."""
    COUNTERWEIGHT = "counterweight"
    """The other holds it in place by its weight."""
    BLOCKING = "blocking"
    """It is in the way of taking the other."""
    MEASURED = "measured"
    """It moved when an arm began to lift the other."""


REASONS = tuple(Reason)


INSIDE = (Relation.WITHIN, Relation.PARTIAL_WITHIN)


@dataclass(frozen=True)
class Dependency:
    """Taking `then` away while `first` is there would move `first`.

    Attributes:
        first: What goes first.
        then: What must wait.
        reason: Why; a string of one of its values is taken for it.
        confidence: 0..1.
        evidence: The relations it rests on: of the two as they lie, of those through which they hang
            together, or of `then` with all that it passes on its way out.
        lies: "on" or "in" where a person would say of what leans that it lies there; it changes words alone.

    Examples:
        >>> tie = dependencies(scene).between("cup", "book")
        >>> tie.sentence()
        'cup rests on book (touch, 0.0 mm, observed)'
    """

    first: str
    then: str
    reason: Reason
    confidence: float
    evidence: tuple[Evidence, ...] = ()
    lies: str = ""

    def __post_init__(self) -> None:
        """Take a reason by its name.

        Raises:
            InvalidInput: There is no such reason.
        """
        if str(self.reason) not in REASONS:
            raise InvalidInput(f"{self.reason!r} is no reason: expected one of {', '.join(REASONS)}")
        object.__setattr__(self, "reason", Reason(self.reason))

    @property
    def word(self) -> str:
        """How `first` lies to `then`: rests on, leans on, is inside, blocks, or is balanced by it."""
        return WORDS[said({"reason": self.reason, "lies": self.lies})]

    def to_json(self) -> dict[str, Any]:
        """The dependency as the JSON of `topple order` has it."""
        document = {
            "first": self.first,
            "then": self.then,
            "reason": str(self.reason),
            "word": self.word,
            "confidence": round(self.confidence, 3),
            "evidence": [each.to_json() for each in self.evidence],
        }
        if self.reason is Reason.MEASURED:
            document["measured"] = True
        return document | ({"lies": self.lies} if self.lies else {})

    def sentence(self) -> str:
        """The reason in words."""
        told = f"{self.first} {self.word} {self.then}"
        lying = [each for each in self.evidence if not each.swept] or self.evidence
        return f"{told} ({'; '.join(map(str, lying))})" if lying else told


@checked_arguments
@dataclass(frozen=True, eq=False)
class DependencyGraph(ByValue):
    """Dependencies between named objects, edges first -> then.

    Attributes:
        names: The movable objects, in the scene's order.
        dependencies: One per ordered pair at most.

    Raises:
        UnknownObject: A dependency names an object that is not among `names`.

    Examples:
        >>> sorted(dependencies(scene).before("book"))
        ['cup']
    """

    names: tuple[str, ...]
    dependencies: tuple[Dependency, ...]

    def __post_init__(self) -> None:
        """Check that every edge is between two known names."""
        known = {*self.names}
        ends = (name for edge in self.dependencies for name in (edge.first, edge.then))
        if unknown := [name for name in ends if name not in known]:
            raise UnknownObject(unknown[0], self.names)

    @staticmethod
    def of(names: Iterable[str], dependencies: Iterable[Dependency]) -> "DependencyGraph":
        """Collect dependencies, the most confident one per ordered pair."""
        best: dict[tuple[str, str], Dependency] = {}
        for edge in dependencies:
            known = best.get((edge.first, edge.then))
            if known is None or edge.confidence > known.confidence:
                best[edge.first, edge.then] = edge
        return DependencyGraph(tuple(names), tuple(best.values()))

    def graph(self) -> "nx.DiGraph[str]":
        """A fresh networkx graph, edges first -> then with `reason` and `confidence`."""
        graph: nx.DiGraph[str] = nx.DiGraph()
        graph.add_nodes_from(self.names)
        for edge in self.dependencies:
            graph.add_edge(edge.first, edge.then, reason=edge.reason, confidence=edge.confidence)
        return graph

    def reduced(self) -> "DependencyGraph":
        """The same order with direct edges only: none whose ends another path joins, cycles kept whole."""
        graph = self.graph()
        condensed = nx.condensation(graph)
        home = {name: c for c in condensed for name in condensed.nodes[c]["members"]}
        direct = set(nx.transitive_reduction(condensed).edges)
        kept = [
            e
            for e in self.dependencies
            if home[e.first] == home[e.then] or (home[e.first], home[e.then]) in direct
        ]
        return DependencyGraph(self.names, tuple(kept))

    def before(self, name: str) -> frozenset[str]:
        """Everything that must go before an object, directly or not; in a cycle, the cycle too."""
        return frozenset(nx.ancestors(self.graph(), name)) - {name}

    def cycles(self) -> tuple[tuple[str, ...], ...]:
        """Sets of objects each of which must go before all others of the set, in the scene's order."""
        rank = {name: i for i, name in enumerate(self.names)}
        found = [sorted(c, key=rank.__getitem__) for c in nx.strongly_connected_components(self.graph())]
        return tuple(tuple(c) for c in sorted((c for c in found if len(c) > 1), key=lambda c: rank[c[0]]))

    def swept(self) -> tuple[tuple[str, str], ...]:
        """(first, then) of every pair in which the lift of `then` meets `first`."""
        edges = (e for e in self.dependencies if any(each.swept for each in e.evidence))
        return tuple((e.first, e.then) for e in edges)

    def between(self, first: str, then: str) -> Dependency | None:
        """The dependency of an ordered pair, or None."""
        return next((e for e in self.dependencies if (e.first, e.then) == (first, then)), None)


@checked_arguments
def dependencies(
    scene: AnyScene | Situation, relations: "Relations | None" = None, *, direct: bool = True
) -> DependencyGraph:
    """Find what must go before what.

    Two questions are asked of every pair: does the straight way out of `then` run into `first`
    (`topple.topology.statics.sweep`), and is `first` still in equilibrium once `then` is gone
    (`topple.topology.statics.rest`)?

    Args:
        scene: A scene that knows where up is, or the situation it was read as.
        relations: Its relations where they are known: there is contact between the pairs that they do not
            call disjoint, and between no others.
        direct: Leave out edges that follow from a chain of others.

    Returns:
        The graph over the movable objects.

    Raises:
        InvalidInput: The scene has no `up`.

    Examples:
        >>> [(tie.first, tie.then, str(tie.reason)) for tie in dependencies(scene).dependencies]
        [('cup', 'book', 'supported')]
    """
    graph, _ = reason_out(Situation.of(scene, relations))
    return graph.reduced() if direct else graph


def reason_out(situation: Situation) -> tuple[DependencyGraph, dict[Pair, float]]:
    """Every dependency, direct or not, and how likely one holds of each ordered pair.

    A dependency is what is likely enough, and what a question finds where surfaces are whole. From cameras
    the surfaces are guesses, and so is by how much a lift misses a thing: there it is enough that the one
    lies on the other or was seen to hang over it. That it is higher up is none.

    Args:
        situation: A scene that knows where up is.

    Returns:
        The graph over the movable objects; (first, then) -> 0..1 before any simulation.
    """
    situation = situation.sized
    statics, cameras = situation.statics, len(situation.scene.viewpoints)
    asked = disturbances(situation)
    weighed = partial(chances, view=seen_by(situation.scene))
    asked = without_cascades(asked, edges_of(asked, weighed(asked), cameras), statics)
    chance = weighed(asked)
    edges = [_edge(pair, asked[pair], chance[pair], situation) for pair in edges_of(asked, chance, cameras)]
    told = {(edge.first, edge.then): edge.confidence for edge in edges}
    return DependencyGraph(situation.movable, tuple(edges)), oversights(statics, cameras) | told


def with_measured(
    graph: DependencyGraph, measured: Collection[Pair], situation: Situation
) -> DependencyGraph:
    """Add dependencies that tried lifts showed; none that would close a cycle.

    Args:
        graph: The dependencies that were reasoned.
        measured: (first, then) where lifting `then` moved `first`.
        situation: What is seen.
    """
    for first, then in sorted(measured):
        if {first, then} <= set(graph.names) and then not in graph.before(first):
            shown = situation.chain(first, then) or (situation.swept(then, first),)
            edge = Dependency(first, then, Reason.MEASURED, 1.0, shown)
            graph = DependencyGraph.of(graph.names, (*graph.dependencies, edge))
    return graph


def edges_of(asked: Mapping[Pair, Disturbance], chance: Mapping[Pair, float], cameras: int) -> list[Pair]:
    """Pairs of which a dependency counts: a question finds it, or of half seen surfaces, what they show.

    Args:
        asked: What was found of pairs.
        chance: How likely each makes a dependency.
        cameras: How many cameras saw the scene; 0 for whole surfaces.
    """
    return [
        pair
        for pair, found in asked.items()
        if chance[pair] >= COUNTS and (found.meets or found.falls or (cameras > 0 and found.shows))
    ]


def _edge(pair: Pair, found: Disturbance, chance: float, situation: Situation) -> Dependency:
    """The dependency of a pair, with its reason and the relations it rests on."""
    first, then = pair
    inside = situation.relations.between(first, then).relation in INSIDE
    reason = _reason(found, inside)
    chain = () if reason is Reason.BLOCKING else situation.chain(first, then)
    swept = (situation.swept(then, first),) if found.meets or not chain else ()
    return Dependency(first, then, reason, chance, (*chain, *swept), _lies(pair, reason, inside, situation))


def _reason(found: Disturbance, inside: bool) -> Reason:
    """Why the one has to go before the other."""
    if inside and found.meets:
        return Reason.CONTAINED
    if found.up is not None and found.up > CARRIES:
        return Reason.SUPPORTED if found.up > RESTS else Reason.LEANING
    if not found.falls:
        return Reason.BLOCKING
    if found.up is None:
        return Reason.SUPPORTED
    return Reason.COUNTERWEIGHT if found.up < PRESSED else Reason.LEANING


def _lies(pair: Pair, reason: Reason, inside: bool, situation: Situation) -> str:
    """Whether what leans on something would be said to lie on it or in it: its middle is then over it."""
    if reason is not Reason.LEANING:
        return ""
    if inside:
        return "in"
    surfaces = situation.statics.surfaces
    first, then = pair
    around = surfaces[then][:, :2] - surfaces[first][:, :2].mean(axis=0)
    angles = np.sort(np.arctan2(around[:, 1], around[:, 0]))
    # inside an outline there is some of it in every half plane
    return "on" if np.diff(angles, append=angles[0] + 2 * np.pi).max() < np.pi else ""


def with_fixture(graph: DependencyGraph, statics: Statics, clamped: Collection[str]) -> DependencyGraph:
    """Drop dependencies made needless by a fixture, which keeps objects in place until they are taken.

    Args:
        graph: The dependencies without it, with every edge.
        statics: The scene at rest.
        clamped: Names that the fixture keeps.

    Returns:
        The same dependencies without those of what stays as it is: what is clamped, and what falls no more
        since it does. What a lift meets is met with a fixture, too.
    """
    swept, held = frozenset(graph.swept()), frozenset(clamped)

    @cache
    def kept(then: str) -> frozenset[str]:
        still = fallen_without(statics, [then], held - {then})
        return held | (fallen_without(statics, [then]).keys() - still.keys())

    left = [
        edge
        for edge in graph.dependencies
        if (edge.first, edge.then) in swept or edge.first not in kept(edge.then)
    ]
    return DependencyGraph(graph.names, tuple(left))
