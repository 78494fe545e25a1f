"""Why an object could not be moved, as an object: step, check, where the arm was, and who barred it."""

from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from topple.topology.arrays import FloatArray

STEPS = ("grasp", "approach", "lift", "place", "retreat", "transfer", "move")
"""In the order in which a search looks at them: what fails later got further."""

TOLD = 4  # reasons in a line for people: the rest is rarer, and in `TransferFailure.reasons`


@dataclass(frozen=True, eq=False)
class Setback:
    """One thing that did not work.

    Attributes:
        step: One of `STEPS`.
        check: "room" (no grasp or place at all), "reach", "collision", "search" (no way found in time),
            "stand" (it would not stay there) or "proof" (it touches something between the samples).
        text: In words.
        q: (n,) joint values at which it happened [rad], where the arm got that far.
        pair: Who met whom.
    """

    step: str
    check: str
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
        furthest: The setback of the try that got furthest, or None where nothing was tried.
        barring: All objects that stood in the way, with counts: the removals to try, most often first.
    """

    object: str
    reasons: Mapping[str, int]
    blocking: str | None
    furthest: Setback | None = None
    barring: Mapping[str, int] = field(default_factory=dict[str, int])

    def __str__(self) -> str:
        """One line for people, with the commonest reasons."""
        counted = [f"{count} x {reason}" for reason, count in self.reasons.items()]
        more = ["and rarer ones"] if len(counted) > TOLD else []
        words = f"cannot move {self.object}: {'; '.join([*counted[:TOLD], *more]) or 'nothing was tried'}"
        if self.blocking:
            words += f" (in the way: {self.blocking})"
        return words


@dataclass
class Tally:
    """What went wrong in one search so far.

    Attributes:
        objects: Names that can bar the way; links and what is carried are none.
        reasons: What tries failed of, with counts.
        barring: Who stood in the way, with counts.
        furthest: The setback of the try that got furthest.
    """

    objects: frozenset[str]
    reasons: Counter[str] = field(default_factory=Counter[str])
    barring: Counter[str] = field(default_factory=Counter[str])
    furthest: Setback | None = None

    def note(
        self,
        step: str,
        check: str,
        text: str,
        q: FloatArray | None = None,
        pair: tuple[str, str] | None = None,
    ) -> None:
        """Add a setback."""
        self.reasons[text] += 1
        for name in pair or ():
            if name in self.objects:
                self.barring[name] += 1
        if self.further(step, q is not None):
            self.furthest = Setback(step, check, text, None if q is None else np.array(q), pair)

    def further(self, step: str, stands: bool) -> bool:
        """Whether a setback of a step says more than the furthest so far; `stands`: with joint values."""
        if self.furthest is None:
            return True
        ahead = STEPS.index(step) - STEPS.index(self.furthest.step)
        return ahead > 0 or (ahead == 0 and stands and self.furthest.q is None)

    def failure(self, name: str) -> TransferFailure:
        """The certificate that says that an object cannot be moved."""
        barring = dict(self.barring.most_common())
        first = next(iter(barring), None)
        return TransferFailure(name, dict(self.reasons.most_common()), first, self.furthest, barring)
