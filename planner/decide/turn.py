"""Which object's turn it is, and which may go out of turn because little speaks against it."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from topple.planner.decide.arrange import Order
from topple.planner.decide.dependency import Dependency, DependencyGraph
from topple.planner.decide.tolerances import LIKELY
from topple.topology.statics.support import Support


@dataclass(frozen=True)
class Ahead:
    """What an order leaves to be done once a step of it is.

    Attributes:
        targets: What is still to be freed.
        names: What is still to be taken, first to take first.
    """

    targets: tuple[str, ...]
    names: tuple[str, ...]

    @staticmethod
    def of(chosen: Order, done: str | None) -> "Ahead":
        """What an order leaves.

        Args:
            chosen: The order.
            done: What was taken of it; None where that failed.
        """
        targets = tuple(name for name in chosen.targets if name != done)
        return Ahead(targets, tuple(name for name in chosen.order if name != done))

    def changed(self, chosen: Order) -> str | None:
        """How a later order differs, in words.

        Args:
            chosen: The order that the next step is of.

        Returns:
            The words; None where it goes on as it was to, or is about the next part of the goal.
        """
        if chosen.order == self.names or not (self.names or self.targets == chosen.targets):
            return None
        was = f"instead of {', '.join(self.names)}" if self.names else "though nothing was left to take"
        return f"{', '.join(chosen.order)} {was}"


def may_go(chosen: Order) -> list[str]:
    """Objects of an order that wait for nothing in it, in its order."""
    rank = {name: place for place, name in enumerate(chosen.order)}
    # within a cycle's group the order says what starts, so only what comes earlier is waited for
    waiting = {
        edge.then
        for edge in chosen.graph.dependencies
        if edge.first in rank and edge.then in rank and rank[edge.first] < rank[edge.then]
    }
    return [name for name in chosen.order if name not in waiting]


def why_first(name: str, chosen: Order) -> str:
    """Why an object goes before others of an order, in words."""
    after = [
        f"{edge.then} ({edge.reason})"
        for edge in chosen.graph.dependencies
        if edge.first == name and edge.then in chosen.order
    ]
    if after:
        return f"it has to go before {' and '.join(after)}"
    return chosen.explanation[chosen.order.index(name)].partition(": ")[2] or "it is in the way"


def out_of_turn(
    names: Sequence[str], graph: DependencyGraph, carried: Sequence[Support]
) -> Mapping[str, tuple[Dependency, ...]]:
    """Objects that wait for others by doubtful dependencies alone, those most likely free of them first.

    What carries another one is never among them.

    Args:
        names: Objects to look at.
        graph: Every dependency, also those that follow from others.
        carried: What carries what.

    Returns:
        name -> the dependencies that taking it now would go against.
    """
    carriers = {(support.supported, support.supporter) for support in carried if support.kind == "rests"}
    found: dict[str, tuple[Dependency, ...]] = {}
    for name in names:
        against = tuple(edge for edge in graph.dependencies if edge.then == name)
        doubted = all(e.confidence < LIKELY and (e.first, name) not in carriers for e in against)
        if against and doubted:
            found[name] = against
    return dict(sorted(found.items(), key=lambda item: sum(edge.confidence for edge in item[1])))


def says(against: Sequence[Dependency]) -> str:
    """The reason of a step that goes against dependencies, in words."""
    told = " and ".join(f"{edge.sentence()} ({edge.confidence:.2f})" for edge in against)
    return f"nothing else can be taken, and more likely than not it is not so that {told}"
