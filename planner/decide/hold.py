"""A hold: a second hand keeps an object still while others come or go."""

from collections.abc import Collection, Sequence
from dataclasses import dataclass
from typing import Any

from topple.topology.situation.evidence import Evidence


@dataclass(frozen=True)
class Hold:
    """An object that stands only when it is held while others are put down, or taken.

    Attributes:
        object: What is held.
        since: What is put down or taken as the hold begins. Of a build: the object itself, or what it could
            not carry alone. Of a removal: what it would not stand without.
        until: What is down, or gone, when it is let go. Of a removal: the object itself, which is taken then,
            or what it could not carry alone.
        because: Why, in words.
        evidence: The relations this rests on.
        fixture: Whether what clamps the object where it stands holds it, and no hand has to.

    Examples:
        >>> Hold("cup", "book", "lid", "it leans on book").sentence(["book", "lid"])
        'hold cup while book and lid are taken: it leans on book'
    """

    object: str
    since: str
    until: str
    because: str
    evidence: tuple[Evidence, ...] = ()
    fixture: bool = False

    def to_json(self) -> dict[str, Any]:
        """The hold as the JSON of `topple order` has it."""
        evidence = [each.to_json() for each in self.evidence]
        return {
            "object": self.object, "since": self.since, "until": self.until,
            "because": self.because, "evidence": evidence,
            **({"fixture": True} if self.fixture else {}),
        }  # fmt: skip

    def meanwhile(self, order: Sequence[str]) -> tuple[str, ...]:
        """Objects of an order that are put down or taken while it is held."""
        begin, end = order.index(self.since), order.index(self.until)
        return tuple(name for name in order[begin : end + 1] if name != self.object)

    def sentence(self, order: Sequence[str]) -> str:
        """Say what to do in an order of removals, and why."""
        taken = self.meanwhile(order)
        verb = "is" if len(taken) == 1 else "are"
        begin = "keep" if self.fixture else "hold"
        kept = " clamped" if self.fixture else ""
        return f"{begin} {self.object}{kept} while {' and '.join(taken)} {verb} taken: {self.because}"


def fixture_assumptions(fixture: Collection[str]) -> tuple[str, ...]:
    """State the assumptions about a fixture, a sentence each."""
    return tuple(f"a fixture keeps {name} where it stands until it is taken" for name in sorted(fixture))


def hands_for(order: Sequence[str], holds: Sequence[Hold]) -> int:
    """How many hands an order takes: one that takes or puts down, and those that hold what is not clamped."""
    held = [name for hold in holds if not hold.fixture for name in hold.meanwhile(order)]
    return 1 + max((held.count(name) for name in held), default=0)
