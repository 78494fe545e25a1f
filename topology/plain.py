"""The paper's rule to the letter: hulls, facet-plane distances, any point counts (section 3.2)."""

from dataclasses import dataclass

import numpy as np

from topple.topology.arrays import FloatArray
from topple.topology.hull import Hull
from topple.topology.intersection import Regions
from topple.topology.pairs import PairRelation, Relations
from topple.topology.relation import classify, kind_of
from topple.topology.scene import Scene


@dataclass(frozen=True, eq=False)
class PlainCloud:
    """One object's cloud with the regions of its hull.

    Attributes:
        name: Name of the object.
        cloud: (N, 3) points [m].
        regions: Interior, boundary and exterior of the cloud's hull.
    """

    name: str
    cloud: FloatArray
    regions: Regions

    @property
    def lower(self) -> FloatArray:
        """(3,) least corner of the box [m]."""
        return self.regions.hull.lower

    @property
    def upper(self) -> FloatArray:
        """(3,) greatest corner of the box [m]."""
        return self.regions.hull.upper

    @property
    def size(self) -> int:
        """Number of points."""
        return len(self.cloud)


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
        """Build the hull of a cloud (N, 3)."""
        by_axis = np.asfortranarray(cloud)  # each coordinate contiguous: box tests read one at a time
        return PlainCloud(name, by_axis, Regions(Hull.of(by_axis), self.deviation))

    def relate(self, a: PlainCloud, b: PlainCloud) -> PairRelation:
        """Relate two clouds; the gap is that of the hulls' corners and facets."""
        matrix = np.stack([b.regions.counts(a.cloud), a.regions.counts(b.cloud)])
        return PairRelation(
            a=a.name,
            b=b.name,
            relation=classify(matrix),
            matrix=matrix,
            gap=hull_gap(a.regions.hull, b.regions.hull),
            kind=kind_of(matrix),
        )

    def after(self, name: str, cloud: FloatArray) -> "PlainRule":
        """The same rule: it looks at two clouds and nothing else."""
        return self

    def conclude(self, scene: Scene, relations: Relations) -> Relations:
        """Nothing follows from all pairs together."""
        return relations


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
