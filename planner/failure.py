"""Why an object could not be moved, as an object: step, check, where the arm was, and what barred it."""

from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from topple.topology.base.arrays import FloatArray
from topple.topology.base.values import Word

STEPS = ("grasp", "approach", "lift", "place", "retreat", "transfer", "move")
"""In the order in which a search looks at them: what fails later got further."""

TOLD = 2  # reasons in a sentence for people: the rest is rarer, and in `TransferFailure.reasons`


class Check(Word):
    """What a try can fail of."""

    ROOM = "room"
    """There is no grasp or place at all."""
    REACH = "reach"
    """The arm does not get there."""
    COLLISION = "collision"
    """Something touches."""
    SEARCH = "search"
    """No way was found."""
    STAND = "stand"
    """The object would not stay there."""
    STRENGTH = "strength"
    """Gravity takes more of a joint, or of the arm, than it is rated for."""
    PROOF = "proof"
    """Something may touch between the samples of a way."""


HELP = {
    Check.ROOM: "another hand may take it",
    Check.REACH: "a base nearer to it, or an arm that reaches further, would get there",
    Check.COLLISION: "more room around it, or another place for the base, would help",
    Check.SEARCH: "another seed may find a way",
    Check.STAND: "a level place with room for it would help",
    Check.STRENGTH: "an arm that carries more would help",
    Check.PROOF: "more room along the way would help",
}
"""What would help where nothing that could be taken away is in the way."""


@dataclass(frozen=True, eq=False)
class FailedCheck:
    """One thing that did not work.

    Attributes:
        step: One of `STEPS`.
        check: What it failed of.
        text: In words.
        q: (n,) joint values at which it happened [rad], where the arm got that far.
        pair: What met what.
    """

    step: str
    check: Check
    text: str
    q: FloatArray | None = None
    pair: tuple[str, str] | None = None


@dataclass(frozen=True, eq=False)
class TransferFailure:
    """Why an object could not be moved: the certificate.

    Attributes:
        object: What should have been moved.
        reasons: What each tried grasp or placement failed of, with counts.
        blocking: The object that stood in the way most often, or None.
        furthest: What failed in the try that got furthest, or None where nothing was tried.
        barring: All objects that stood in the way, with counts: the removals to try, most often first.
    """

    object: str
    reasons: Mapping[str, int]
    blocking: str | None
    furthest: FailedCheck | None = None
    barring: Mapping[str, int] = field(default_factory=dict[str, int])

    @staticmethod
    def no_place(name: str, text: str, barring: Mapping[str, int] | None = None) -> "TransferFailure":
        """That an object has no place to go to, for a reason in words."""
        failed, first = FailedCheck("place", Check.ROOM, text), next(iter(barring or {}), None)
        return TransferFailure(name, {text: 1}, first, failed, barring or {})

    def __str__(self) -> str:
        """One sentence: what bars the try that got furthest, what most others fail of, what would help."""
        return "; ".join(filter(None, (f"cannot move {self.object}: {self._obstacle()}", self._help())))

    def _obstacle(self) -> str:
        got = self.furthest
        first = () if got is None or got.check is Check.ROOM else (got.text,)  # of no room the commonest
        return ", and ".join(list(dict.fromkeys((*first, *self.reasons)))[:TOLD]) or "nothing was tried"

    def _help(self) -> str:
        if self.blocking and not (self.furthest and self.furthest.check is Check.STRENGTH):
            return f"in the way: {self.blocking}"
        if self.furthest is None:
            return ""
        placed = self.furthest.step == "place" and self.furthest.check is Check.ROOM
        return HELP[Check.STAND if placed else self.furthest.check]


@dataclass
class FailureLog:
    """What went wrong in one search so far.

    Attributes:
        objects: Names that can bar the way; links and what is carried are none.
        reasons: What tries failed of, with counts.
        barring: What stood in the way, with counts.
        furthest: What failed in the try that got furthest.
    """

    objects: frozenset[str]
    reasons: Counter[str] = field(default_factory=Counter[str])
    barring: Counter[str] = field(default_factory=Counter[str])
    furthest: FailedCheck | None = None

    def __post_init__(self) -> None:
        self._reached = (-1, 0)

    def note(
        self,
        step: str,
        check: Check,
        text: str,
        q: FloatArray | None = None,
        pair: tuple[str, str] | None = None,
    ) -> None:
        """Add one."""
        self.reasons[text] += 1
        for name in pair or ():
            if name in self.objects:
                self.barring[name] += 1
        got = _progress(step, q is not None, check)
        if got > self._reached:
            self._reached = got
            self.furthest = FailedCheck(step, check, text, None if q is None else np.array(q), pair)

    def further(self, step: str, stands: bool) -> bool:
        """Whether what a step failed of says more than the furthest so far; `stands`: with joint values."""
        return _progress(step, stands) > self._reached

    def failure(self, name: str) -> TransferFailure:
        """The certificate that says that an object cannot be moved."""
        barring = dict(self.barring.most_common())
        first = next(iter(barring), None)
        return TransferFailure(name, dict(self.reasons.most_common()), first, self.furthest, barring)


def _progress(step: str, stands: bool, check: Check | None = None) -> tuple[int, int]:
    """How far a try got: by its step, then with joint values, then to where the object would not stay.

    What is too heavy to be carried is told whatever else fails: no other place is a way out.
    """
    if check is Check.STRENGTH:
        return len(STEPS), 0
    return STEPS.index(step), 2 if check is Check.STAND else int(stands)
