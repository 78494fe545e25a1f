"""The paper's rule for `relate`: the answers of `topple.topology.sixim.plain`, of few points and few facets.

The relation needs six bits, not six counts, and few bits need a hull: bounds of both hulls settle most, the
hulls the rest. Counts and gap are worked out when somebody asks for them.
"""

from collections.abc import Collection
from dataclasses import dataclass
from functools import cached_property, partial

import numpy as np

from topple.topology.base.arrays import FloatArray, IntArray
from topple.topology.base.tolerances import TOLERANCES
from topple.topology.geometry.hull import Hull
from topple.topology.scene.scene import Scene
from topple.topology.sixim.fast.bracket import SLACK, Bracket
from topple.topology.sixim.fast.regions import Regions, in_box
from topple.topology.sixim.pair import PairRelation
from topple.topology.sixim.relation_table import AnyTable
from topple.topology.sixim.table import classify, kind_of

PROBES = 256
"""Points in the other's box that are looked at before all: most contacts show in a few."""


@dataclass(frozen=True, eq=False)
class PlainCloud:
    """One object's cloud, with what is derived from it when first needed.

    Attributes:
        name: Name of the object.
        columns: (3, N) points [m], each axis contiguous: box tests read one at a time.
        lower: (3,) least corner of the box [m].
        upper: (3,) greatest corner of the box [m].
        deviation: The deviation factor δ [m].
    """

    name: str
    columns: FloatArray
    lower: FloatArray
    upper: FloatArray
    deviation: float

    @property
    def size(self) -> int:
        """Number of points."""
        return self.columns.shape[1]

    @cached_property
    def bracket(self) -> Bracket:
        """Bounds of the hull."""
        return Bracket(self.columns)

    @cached_property
    def regions(self) -> Regions:
        """Interior, boundary and exterior of the hull."""
        return Regions(Hull.of(self.columns.T), self.deviation)

    def within_box(self, other: "PlainCloud", margin: float) -> FloatArray:
        """(3, n) points [m] in another's box, enlarged by a margin [m]."""
        inside = in_box(self.columns, other.lower - margin, other.upper + margin)
        return self.columns[:, np.flatnonzero(inside)]


@dataclass(frozen=True)
class PlainRule:
    """Relations by Table 1 on the counts of equation (4).

    Attributes:
        deviation: The deviation factor δ [m].
    """

    deviation: float

    @property
    def reach(self) -> float:
        """Boxes further apart than δ leave every point exterior [m]."""
        return self.deviation

    def prepare(self, name: str, cloud: FloatArray) -> PlainCloud:
        """Take in a cloud (N, 3)."""
        columns = np.ascontiguousarray(cloud.T)
        return PlainCloud(name, columns, columns.min(axis=1), columns.max(axis=1), self.deviation)

    def relate(self, a: PlainCloud, b: PlainCloud) -> PairRelation:
        """Relate two clouds."""
        bits = pattern(a, b)
        return PairRelation(
            a=a.name,
            b=b.name,
            relation=classify(bits),
            counts=partial(_counts, a, b),
            distance=partial(_hull_gap, a, b),
            kind=kind_of(bits),
        )

    def after(self, scene: Scene, changed: Collection[str], looked_again: bool) -> "PlainRule":
        """The same rule: it looks at two clouds and nothing else."""
        return self

    def look_again(self, pair: PairRelation, a: PlainCloud, b: PlainCloud) -> PairRelation:
        """The same pair, for the same reason."""
        return pair

    def conclude(self, scene: Scene, relations: AnyTable) -> AnyTable:
        """Nothing follows from all pairs together."""
        return relations


def plainly(scene: Scene, deviation: float | None = None) -> PlainRule:
    """The paper's rule to the letter of Table 1.

    Args:
        scene: Any scene: the rule looks at two clouds and nothing else.
        deviation: The deviation factor δ [m]; 0.002 where None.
    """
    return PlainRule(TOLERANCES.plain_deviation if deviation is None else deviation)


def pattern(a: PlainCloud, b: PlainCloud) -> list[list[bool]]:
    """Which cells of R(A, B) have points, as far as Table 1 asks.

    Once a point lies in an interior no relation depends on the boundaries any more: they count as reached.

    Args:
        a: Cloud A.
        b: Cloud B.

    Returns:
        [[A∩B°, A∩∂B, A∩B⁻], [A°∩B, ∂A∩B, A⁻∩B]], non-empty or not.
    """
    inside = [_has_interior(a, b), _has_interior(b, a)]
    reaches = [True, True] if any(inside) else [_reaches(a, b), _reaches(b, a)]
    # A point is somewhere: a cloud that is neither in nor on the other is outside.
    outside = [not reaches[0] or _sticks_out(a, b), not reaches[1] or _sticks_out(b, a)]
    return [[inside[row], reaches[row], outside[row]] for row in (0, 1)]


def _has_interior(a: PlainCloud, b: PlainCloud) -> bool:
    """Whether a point of A lies deeper than δ below every facet of B."""
    depth = a.deviation
    if b.bracket.nowhere_deeper(a.bracket, depth):
        return False
    if b.bracket.surely_deeper(a.bracket.extremes, depth):
        return True
    near = a.within_box(b, SLACK - depth)
    if b.bracket.surely_deeper(_few(near), depth):
        return True
    near = b.bracket.maybe_deeper(near, depth)
    known = b.bracket.deeper(near, depth)
    return b.regions.holds(near) if known is None else known


def _reaches(a: PlainCloud, b: PlainCloud) -> bool:
    """Whether a point of A lies in B's hull enlarged by δ, as far as B's box enlarged by δ reaches."""
    if b.bracket.surely_deeper(a.bracket.extremes, 0.0):
        return True
    near = a.within_box(b, a.deviation)
    return b.bracket.surely_near(_few(near), a.deviation) or b.regions.meets(near)


def _sticks_out(a: PlainCloud, b: PlainCloud) -> bool:
    """Whether a point of A lies outside B's enlarged box, or beyond δ from a facet of B.

    The enlarged hull is convex: it holds all of A where it holds the corners of A's hull.
    """
    if (a.lower < b.lower - a.deviation).any() or (a.upper > b.upper + a.deviation).any():
        return True
    outermost = b.regions.hull.facet_distance(a.bracket.extremes).max()
    return bool(max(outermost, b.regions.hull.facet_distance(a.regions.hull.vertices).max()) > a.deviation)


def _few(columns: FloatArray) -> FloatArray:
    """(n, 3) some of the points (3, N)."""
    return columns[:, :: max(1, columns.shape[1] // PROBES)].T


def _counts(a: PlainCloud, b: PlainCloud) -> IntArray:
    """The matrix R(A, B)."""
    return np.stack([b.regions.counts(a.columns.T), a.regions.counts(b.columns.T)])


def _hull_gap(a: PlainCloud, b: PlainCloud) -> float:
    return hull_gap(a.regions.hull, b.regions.hull)


def hull_gap(a: Hull, b: Hull) -> float:
    """Distance of two hulls along the best facet normal of either [m], negative by the depth of overlap.

    Where an edge faces an edge the hulls are further apart than this.

    Args:
        a: One hull.
        b: The other.
    """
    gaps: list[float] = []
    for facets, other in ((a, b), (b, a)):
        step = max(1, (1 << 19) // len(other.vertices))
        for start in range(0, len(facets.normals), step):
            table = other.vertices @ facets.normals[start : start + step].T
            gaps.append(float((table.min(axis=0) + facets.offsets[start : start + step]).max()))
    return max(gaps)
