"""The seven relations of the 6-intersection model and the mask table that decides them.

The model counts which points of one cloud lie in the interior °, on the boundary ∂ and in the exterior ⁻ of
the other's hull: R(A, B) = [[A∩B°, A∩∂B, A∩B⁻], [A°∩B, ∂A∩B, A⁻∩B]] (section 3.1, equation 1). Every pattern
of empty and non-empty cells that two non-empty clouds can make matches exactly one row of Table 1.
"""

import numpy as np
from numpy.typing import ArrayLike

from topple.topology.base.arrays import IntArray
from topple.topology.base.errors import InvalidInput
from topple.topology.base.values import Word


class Relation(Word):
    """How a cloud A lies to a cloud B (Definitions 4-10 of section 3.1).

    Examples:
        >>> str(Relation.WITHIN.converse)
        'contain'
    """

    CROSS = "cross"
    """Both have points in the other's interior."""
    WITHIN = "within"
    """A has points in B's interior and none outside B; B has none in A's."""
    PARTIAL_WITHIN = "partial within"
    """A has points in B's interior and others outside B; B has none in A's."""
    CONTAIN = "contain"
    """B is within A."""
    PARTIAL_CONTAIN = "partial contain"
    """B is partial within A."""
    TOUCH = "touch"
    """Neither has points in the other's interior, each has points on the other's boundary."""
    DISJOINT = "disjoint"
    """None of the others."""

    __str__ = str.__str__  # printed and formatted as the word, on every Python

    @property
    def converse(self) -> "Relation":
        """The relation of B to A where this is the relation of A to B."""
        return _CONVERSE[self]


_CONVERSE = {
    Relation.CROSS: Relation.CROSS,
    Relation.WITHIN: Relation.CONTAIN,
    Relation.PARTIAL_WITHIN: Relation.PARTIAL_CONTAIN,
    Relation.CONTAIN: Relation.WITHIN,
    Relation.PARTIAL_CONTAIN: Relation.PARTIAL_WITHIN,
    Relation.TOUCH: Relation.TOUCH,
    Relation.DISJOINT: Relation.DISJOINT,
}

ONE_SIDED_CONTACT = "one-sided contact"
"""Kind of a disjoint pair of which one cloud reaches the other's boundary: so an occluded support looks."""
COINCIDENT = "coincident"
"""Kind of a touch of which neither has a point outside the other: the same object twice."""

TABLE_1: tuple[tuple[Relation, str], ...] = (
    (Relation.CROSS, "T**T**"),
    (Relation.WITHIN, "T*FF**"),
    (Relation.PARTIAL_WITHIN, "T*TF**"),
    (Relation.CONTAIN, "F**T*F"),
    (Relation.PARTIAL_CONTAIN, "F**T*T"),
    (Relation.TOUCH, "FT*FT*"),
    (Relation.DISJOINT, "FT*FFT"),
    (Relation.DISJOINT, "FFTFT*"),
    (Relation.DISJOINT, "FFTFFT"),
)
"""The paper's Table 1, cells of R(A, B) row by row: T non-empty, F empty, * either."""


def _matches(pattern: tuple[bool, ...], mask: str) -> bool:
    return all(wanted == "*" or (wanted == "T") == bit for wanted, bit in zip(mask, pattern, strict=True))


def _lookup() -> dict[int, Relation]:
    table: dict[int, Relation] = {}
    for code in range(64):
        pattern = tuple(bool(code >> (5 - cell) & 1) for cell in range(6))
        if any(pattern[:3]) and any(pattern[3:]):  # a non-empty cloud has a point somewhere
            table[code] = next(relation for relation, mask in TABLE_1 if _matches(pattern, mask))
    return table


_RELATION_OF_CODE = _lookup()


def pattern_code(matrix: ArrayLike) -> int:
    """Number of a matrix's pattern: its six cells as bits, A∩B° the highest.

    Args:
        matrix: (2, 3) counts or truth values R(A, B).
    """
    cells = np.asarray(matrix).ravel() != 0
    return sum(1 << (5 - cell) for cell in range(6) if cells[cell])


def classify(matrix: ArrayLike) -> Relation:
    """Relation of A to B by Table 1.

    Args:
        matrix: (2, 3) counts or truth values R(A, B) of two non-empty clouds.

    Returns:
        The one relation whose row of Table 1 matches.

    Raises:
        InvalidInput: It is of another shape, or a row is empty: no non-empty cloud has a point nowhere
            (Table 2).

    See Also:
        converse_matrix: `classify(converse_matrix(m))` is `classify(m).converse`.

    >>> classify([[0, 4, 96], [0, 2, 98]])
    <Relation.TOUCH: 'touch'>
    >>> classify([[0, 0, 100], [0, 2, 98]])  # contact that only B's points show
    <Relation.DISJOINT: 'disjoint'>
    """
    code = pattern_code(matrix) if np.shape(matrix) == (2, 3) else -1
    if code not in _RELATION_OF_CODE:
        raise InvalidInput(
            f"no two non-empty clouds have the intersection matrix {np.asarray(matrix).tolist()}"
        )
    return _RELATION_OF_CODE[code]


def kind_of(matrix: ArrayLike) -> str | None:
    """Name of the special case a matrix shows, if any: one-sided contact or coincident.

    Args:
        matrix: (2, 3) counts or truth values R(A, B) of two non-empty clouds.

    >>> kind_of([[0, 0, 100], [0, 2, 98]])
    'one-sided contact'
    """
    cells = np.asarray(matrix) != 0
    relation = classify(cells)
    if relation is Relation.DISJOINT and (cells[0, 1] or cells[1, 1]):
        return ONE_SIDED_CONTACT
    if relation is Relation.TOUCH and not cells[0, 2] and not cells[1, 2]:
        return COINCIDENT
    return None


def converse_matrix(matrix: IntArray) -> IntArray:
    """R(B, A) from R(A, B), (2, 3): the rows trade places."""
    return matrix[::-1]
