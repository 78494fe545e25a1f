"""The relation of one object to another, with what was counted and measured of it."""

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import cached_property, partial
from math import inf
from typing import Any

import numpy as np

from topple.topology.base.arrays import IntArray
from topple.topology.base.values import ByValue, decimal
from topple.topology.sixim.table import Relation, converse_matrix


@dataclass(frozen=True, eq=False)
class PairRelation(ByValue):
    """The relation of one object to another: "a relation b".

    Attributes:
        a: Name of the first object.
        b: Name of the second object.
        relation: Relation of a to b.
        counts: The matrix as it was counted, or what counts it: rules that know the relation sooner leave it
            until asked for.
        distance: The gap, or what measures it.
        gap_exact: False where `gap` is only a lower bound, the distance of the boxes of a far pair.
        confidence: How sure the relation is, 0 to 1.
        observed: False where no camera saw the space between the two, so that a gap proves nothing.
        kind: "one-sided contact" or "coincident" where the matrix shows one, else None.
        inferred: True where the relation was concluded from gravity and not from the clouds alone.
        reason: What decided, where it was anything else than Table 1 on the matrix; None where it was that.
        least_gap: What the gap is at least [m], known without measuring it.

    Examples:
        >>> pair = relate(scene)["cup", "book"]
        >>> str(pair.relation), pair.observed, round(pair.gap, 3)
        ('touch', True, 0.0)
    """

    a: str
    b: str
    relation: Relation
    counts: IntArray | Callable[[], IntArray] = field(repr=False)
    distance: float | Callable[[], float] = field(repr=False)
    gap_exact: bool = True
    confidence: float = 1.0
    observed: bool = True
    kind: str | None = None
    inferred: bool = False
    reason: str | None = None
    least_gap: float = -inf

    @cached_property
    def matrix(self) -> IntArray:
        """(2, 3) counts [[A∩B°, A∩∂B, A∩B⁻], [A°∩B, ∂A∩B, A⁻∩B]]."""
        return self.counts if isinstance(self.counts, np.ndarray) else self.counts()

    @cached_property
    def gap(self) -> float:
        """Smallest distance of the two surfaces [m], negative by the depth of overlap."""
        return self.distance if isinstance(self.distance, float | int) else self.distance()

    def within(self, limit: float) -> bool:
        """Tell whether the gap is at most so wide [m], measuring it only where its bound does not tell."""
        return self.least_gap <= limit and self.gap <= limit

    def _comparison(self) -> list[Any]:
        """Counts and measures, not how they were found."""
        return [self.matrix, self.gap, *self.to_json().values()]

    def __reduce__(self) -> tuple[object, ...]:
        """Pickle what is counted and measured."""
        more = (self.gap_exact, self.confidence, self.observed, self.kind, self.inferred, self.reason)
        return (PairRelation, (self.a, self.b, self.relation, self.matrix, self.gap, *more))

    @property
    def converse(self) -> "PairRelation":
        """The same pair told from b: "b converse a"."""
        return replace(
            self,
            a=self.b,
            b=self.a,
            relation=self.relation.converse,
            counts=partial(_converse_counts, self),
            distance=partial(_same_gap, self),
        )

    def cells(self) -> tuple[str, ...]:
        """The pair as a row: both names with the relation between, the gap in mm, and if no camera saw it."""
        gap = f"{'' if self.gap_exact else '> '}{decimal(1000 * float(self.gap), 1)} mm"
        return self.a, str(self.relation), self.b, gap, "inferred" if self.inferred else ""

    def __str__(self) -> str:
        """One line: "fork partial within plate  0.3 mm"."""
        return " ".join(self.cells()).rstrip()

    def to_json(self) -> dict[str, Any]:
        """The pair as one entry of the relations' JSON."""
        entry: dict[str, Any] = {
            "a": self.a,
            "b": self.b,
            "relation": str(self.relation),
            "matrix": self.matrix.tolist(),
            "gap": round(float(self.gap), 6),
            "gap_exact": self.gap_exact,
            "confidence": round(float(self.confidence), 4),
            "observed": self.observed,
            "inferred": self.inferred,
            "reason": self.reason,
        }
        if self.kind is not None:
            entry["kind"] = self.kind
        return entry


def _converse_counts(pair: PairRelation) -> IntArray:
    return converse_matrix(pair.matrix)


def _same_gap(pair: PairRelation) -> float:
    return pair.gap
