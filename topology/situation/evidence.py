"""Evidence: one relation that a conclusion rests on."""

from dataclasses import dataclass
from typing import Any

from topple.topology.sixim.pair import PairRelation
from topple.topology.sixim.table import Relation

Pixel = tuple[int, int, int]
"""Camera, from 1, row and column."""


@dataclass(frozen=True)
class Evidence:
    """A relation of two objects, as they lie or as one of them is taken.

    Attributes:
        a: Name of the first object.
        b: Name of the second object.
        relation: "a relation b".
        gap: Smallest distance of the two surfaces [m], negative by the depth of overlap; of a swept body by
            how far the other has to be pushed aside.
        observed: Whether the cameras saw it; else it was inferred.
        swept: Whether `a` is taken with all that it passes on its straight way out.
        pixels: (camera, row, column) of the pictures that show it, a place in each, cameras from 1; empty
            where it was inferred, and where the pictures are not known.
        level: Whether that way out is level, since something fixed is over `a`.
    """

    a: str
    b: str
    relation: Relation
    gap: float
    observed: bool
    swept: bool = False
    pixels: tuple[Pixel, ...] = ()
    level: bool = False

    @staticmethod
    def of(pair: PairRelation) -> "Evidence":
        """The evidence a pair is, as it lies."""
        return Evidence(pair.a, pair.b, pair.relation, float(pair.gap), pair.observed and not pair.inferred)

    def to_json(self) -> dict[str, Any]:
        """The evidence as the JSON of `topple order` has it."""
        document = {
            "a": self.a,
            "b": self.b,
            "relation": str(self.relation),
            "gap": round(self.gap, 6),
            "observed": self.observed,
            "swept": self.swept,
        } | ({"level": True} if self.level else {})
        return document | ({"pixels": [list(each) for each in self.pixels]} if self.pixels else {})

    def __str__(self) -> str:
        """In words, without the names."""
        if self.swept:
            guess = "" if self.observed else ", inferred"
            taken = "slid out" if self.level else "lifted"
            return f"{taken}, {self.a} would {_MEETS.get(self.relation, 'pass')} it{guess}"
        if not self.observed:
            return f"{self.relation}, inferred"
        return f"{self.relation}, {_apart(self.gap)}, observed"


_MEETS = {Relation.CONTAIN: "sweep over all of", Relation.PARTIAL_CONTAIN: "sweep over a part of"}


def _apart(gap: float) -> str:
    millimetres = 1e3 * gap
    return f"{abs(millimetres):.1f} mm{' deep' if millimetres < -0.05 else ''}"
