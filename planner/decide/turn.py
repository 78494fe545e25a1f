"""Which object's turn it is, and why."""

from dataclasses import dataclass

from topple.planner.decide.arrange import Order
from topple.planner.decide.hold import Hold


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
    def of(chosen: Order, done: bool) -> "Ahead":
        """Take the rest of an order, with or without its first object.

        Args:
            chosen: The order.
            done: Whether its first object was taken.
        """
        left = chosen.order[done:]
        gone = set(chosen.order) - set(left)
        return Ahead(tuple(name for name in chosen.targets if name not in gone), left)

    def change_to(self, chosen: Order) -> str | None:
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
    waiting = {then for _, then in _waits(chosen)}
    return [name for name in chosen.order if name not in waiting]


def may_begin(hold: Hold, chosen: Order) -> bool:
    """Whether nothing that is taken in a hold waits for something else in its order."""
    taken = {*hold.meanwhile(chosen.order), hold.until}
    return all(first in taken for first, then in _waits(chosen) if then in taken)


def _waits(chosen: Order) -> list[tuple[str, str]]:
    """(first, then) of an order; within a cycle it says what starts, so only what comes earlier counts."""
    rank = {name: place for place, name in enumerate(chosen.order)}
    pairs = [(edge.first, edge.then) for edge in chosen.graph.dependencies]
    return [(first, then) for first, then in pairs if rank.get(first, len(rank)) < rank.get(then, -1)]


def why_first(name: str, chosen: Order) -> str:
    """Why an object goes before others of an order, in words."""
    after = [
        f"{edge.then} ({edge.word} it)"
        for edge in chosen.graph.dependencies
        if edge.first == name and edge.then in chosen.order
    ]
    if after:
        return f"it has to go before {' and '.join(after)}"
    return chosen.explanation[chosen.order.index(name)].partition(": ")[2] or "it is in the way"
