"""Situation: a scene, and what is read of it, each part worked out once and only when it is asked for."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from typing import TYPE_CHECKING

import networkx as nx

from topple.topology.arrays import FloatArray
from topple.topology.evidence import Evidence
from topple.topology.relations import Relations
from topple.topology.rule.relate import relate
from topple.topology.sixim.table import classify
from topple.topology.statics.contact import Contact
from topple.topology.statics.rest import Statics
from topple.topology.statics.support import Support, supports
from topple.topology.statics.sweep import overlap, swept_matrix

if TYPE_CHECKING:
    from topple.topology.scene import Scene


@dataclass(frozen=True, eq=False)
class Situation:
    """A scene with its relations, and with gravity what follows from them.

    The relations are the one reading of the clouds: between two objects that they call disjoint there is no
    contact, and none carries, leans on or holds the other.

    Attributes:
        scene: What was seen; it knows where up is where contacts are asked for.
        given: Relations that are known already, ours or somebody else's; None to work them out.
    """

    scene: "Scene"
    given: Relations | None = None

    @staticmethod
    def of(scene: "Scene | Situation", relations: Relations | None = None) -> "Situation":
        """A scene as a situation; a situation as it is, unless other relations are given.

        Args:
            scene: The scene, or what is known of it.
            relations: Relations that are known already.
        """
        if isinstance(scene, Situation):
            return scene if relations is None else Situation(scene.scene, relations)
        return Situation(scene, relations)

    @cached_property
    def relations(self) -> Relations:
        """The relation of every pair."""
        return relate(self.scene) if self.given is None else self.given

    @cached_property
    def statics(self) -> Statics:
        """Completed bodies, their weights and contacts, in a frame whose z is up.

        Raises:
            InvalidInput: The scene has no `up`.
        """
        return Statics.of(self.scene, relations=self.relations)

    @property
    def movable(self) -> tuple[str, ...]:
        """Names that can move."""
        return self.scene.movable

    @property
    def surfaces(self) -> Mapping[str, FloatArray]:
        """The completed bodies: name -> (N, 3) upright points [m] of the whole surface."""
        return self.statics.surfaces

    @property
    def contacts(self) -> tuple[Contact, ...]:
        """Patches between bodies that meet."""
        return self.statics.contacts

    @cached_property
    def supports(self) -> tuple[Support, ...]:
        """What carries what: see `topple.topology.statics.support.supports`."""
        return supports(self.statics, self.relations)

    def between(self, a: str, b: str) -> Evidence:
        """The relation of two objects as they lie."""
        return Evidence.of(self.relations.between(a, b))

    def swept(self, name: str, other: str) -> Evidence:
        """The relation of an object, with all that it passes as it is lifted straight up, to another one.

        Args:
            name: What is lifted.
            other: What may be in its way.
        """
        body, met = self.surfaces[name], self.surfaces[other]
        over = overlap(met, body)
        gap = self.relations.between(name, other).gap if over is None else -over.evasion
        seen = self.relations.between(name, other).observed
        return Evidence(name, other, classify(swept_matrix(body, met)), gap, seen, swept=True)

    def hang_together(self, a: str, b: str) -> bool:
        """Whether two movable objects are in contact, or each with others that are."""
        return bool(nx.has_path(self._meeting, a, b))

    def chain(self, a: str, b: str) -> tuple[Evidence, ...]:
        """The relations by which two movable objects hang together, through as few others as possible.

        Args:
            a: One of them.
            b: The other one.

        Returns:
            The relation of each to the next, from a to b; empty where they do not.
        """
        if not self.hang_together(a, b):
            return ()
        path = nx.shortest_path(self._meeting, a, b)
        return tuple(self.between(one, other) for one, other in pairwise(path))

    @cached_property
    def _meeting(self) -> "nx.Graph[str]":
        """The movable objects, those in contact joined."""
        graph: nx.Graph[str] = nx.Graph()
        graph.add_nodes_from(self.movable)
        for a, b in sorted(map(sorted, self.relations.meeting)):
            if a in graph and b in graph:
                graph.add_edge(a, b)
        return graph
