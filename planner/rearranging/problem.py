"""A rearrangement as what has to happen before what: things are taken from places and put to others."""

from collections.abc import Collection, Sequence
from dataclasses import dataclass

from topple.topology.base.errors import InvalidInput
from topple.topology.base.values import Word


class Act(Word):
    """What is done to a thing."""

    TAKE = "take"
    """It leaves the place it has at the start."""
    PUT = "put"
    """It comes to the place it has in the goal."""


Event = tuple[Act, str]
"""What is done, and to which object."""

Pair = tuple[Event, Event]
"""What has to happen before what."""


class To(Word):
    """Where a move ends."""

    GOAL = "goal"
    BUFFER = "buffer"


@dataclass(frozen=True)
class Move:
    """One pick and place.

    Attributes:
        object: What is moved.
        to: To its place in the goal, or out of the way.
    """

    object: str
    to: To


@dataclass(frozen=True)
class Problem:
    """What is to be moved, and what must happen before what.

    Attributes:
        moving: Objects whose place in the goal is another one than at the start.
        staying: Objects whose place is the same: they are moved only where something else demands it. What is
            never moved was put before all else, and is taken after it.
        before: Pairs of events of these objects; a pair within one object is implied.

    Raises:
        InvalidInput: A pair names another object, or an object is there twice.
    """

    moving: tuple[str, ...]
    staying: tuple[str, ...] = ()
    before: frozenset[Pair] = frozenset()

    def __post_init__(self) -> None:
        """Check the names."""
        names = (*self.moving, *self.staying)
        if len(set(names)) < len(names):
            raise InvalidInput("an object is there twice: give each one name, moving or staying")
        unknown = {name for pair in self.before for _, name in pair} - set(names)
        if unknown:
            raise InvalidInput(f"{', '.join(sorted(unknown))}: in a pair, but neither moving nor staying")

    def check(self, moves: Sequence[Move]) -> str | None:
        """Say what is wrong with a sequence of moves; None where it does what is asked.

        Args:
            moves: First to do first.
        """
        done: set[Event] = set()
        waits: dict[Event, set[Event]] = {}
        for first, then in self.before:
            waits.setdefault(then, set()).add(first)
        handled = {move.object for move in moves}
        absent = set(self.staying) - handled
        for first, then in sorted(self.before):
            if first[1] in handled and then[0] is Act.PUT and then[1] in absent:
                return f"{then[1]} is never moved, though it has to be put after {first[0]} {first[1]}"
        for move in moves:
            events = [(Act.TAKE, move.object)] if (Act.TAKE, move.object) not in done else []
            events += [(Act.PUT, move.object)] if move.to is To.GOAL else []
            for event in events:
                for first in sorted(waits.get(event, ())):
                    if first not in done and not _stays(first, absent):
                        return f"{event[0]} {event[1]} before {first[0]} {first[1]}"
                done.add(event)
        left = [name for name in (*self.moving, *handled) if (Act.PUT, name) not in done]
        return f"{left[0]} is not in its place" if left else None


def _stays(event: Event, absent: Collection[str]) -> bool:
    """Whether an event need not be waited for: what stays was put where it is before all began."""
    return event[1] in absent and event[0] is Act.PUT
