"""The default rule: relations that withstand noise, hidden surfaces and hollow objects.

Where the paper asks whether any point lies in a hull (equation 4), this rule asks how many, and of the
surface
instead of its hull: a point is interior to an object that surrounds it, on its boundary near it, else
exterior. Shares that noise alone explains count as none. The relation then follows from Table 1 as before.
"""

from dataclasses import dataclass, field, replace

import numpy as np
from scipy.spatial import KDTree

from topple.topology.arrays import BoolArray, FloatArray, IntArray
from topple.topology.relations import PairRelation, Relations, box_distance
from topple.topology.rule.cavity import roofed, surrounded
from topple.topology.rule.facing import facing_seen
from topple.topology.rule.inferred import infer_contacts
from topple.topology.rule.surface import SurfaceCloud, closest
from topple.topology.scene import Scene
from topple.topology.sixim.table import Relation, classify, kind_of
from topple.topology.tolerances import TOLERANCES
from topple.topology.views.visibility import Visibility

WALL = 600
"""Points that stand for a container's wall: 24 directions, some 25 each."""
CONTENT = 400
"""Points of the content that are looked at: one in a hundred still shows."""


@dataclass(frozen=True, eq=False)
class RobustRule:
    """Relations by counts and trimmed extents of surfaces.

    Attributes:
        deviation: The deviation factor δ [m].
        up: (3,) unit vector against gravity, along which containers are open; None tries the axes of each.
        sight: What the cameras saw, or None where no camera is known: the clouds are then complete.
        reach: Pairs whose boxes are further apart than this are disjoint [m].
    """

    deviation: float
    up: FloatArray | None = None
    sight: Visibility | None = field(default=None, repr=False)
    reach: float = TOLERANCES.reach

    def prepare(self, name: str, cloud: FloatArray) -> SurfaceCloud:
        """Clean and thin a cloud (N, 3)."""
        return SurfaceCloud.of(name, cloud)

    def relate(self, a: SurfaceCloud, b: SurfaceCloud) -> PairRelation:
        """Relate two prepared clouds."""
        near = closest(a, b)
        inner_a, inner_b = self._interior(a, b), self._interior(b, a)
        touching = near.gap <= self.deviation
        matrix = np.stack(
            [self._row(a, b, inner_a, touching), self._row(b, a, inner_b, touching)],
        )
        relation = classify(matrix)
        depth = self._overlap(a, b, inner_a, inner_b) if relation is Relation.CROSS else 0.0
        # What is in something, or on it, was seen there; what seems apart may meet where nobody looked.
        observed = relation is not Relation.DISJOINT or self.sight is None or facing_seen(a, b, self.sight)
        return PairRelation(
            a=a.name,
            b=b.name,
            relation=relation,
            counts=matrix,
            # A patch reaches half its spacing beyond the last sample; what is apart is not that close.
            distance=-depth if depth > 0 else near.gap if touching else max(near.gap, box_distance(a, b)),
            confidence=self._confidence(relation, near.gap, matrix, observed),
            observed=observed,
            kind=kind_of(matrix),
        )

    def after(self, name: str, cloud: FloatArray) -> "RobustRule":
        """The rule that knows what the cameras see once one object's cloud is another."""
        return self if self.sight is None else replace(self, sight=self.sight.after(name, cloud))

    def conclude(self, scene: Scene, relations: Relations) -> Relations:
        """Add the hidden contacts that gravity demands of the objects without their stray points."""
        kept = {one.name: one for one in relations.prepared if isinstance(one, SurfaceCloud)}
        for one in kept.values():
            if one.dropped:
                scene = scene.with_cloud(one.name, one.points)
        if self.sight is None:
            return infer_contacts(scene, relations)
        return infer_contacts(scene, relations, lambda pair: pair.observed)

    def _interior(self, a: SurfaceCloud, b: SurfaceCloud) -> BoolArray:
        """Which mean points of A lie in B's solid or hollow: in its hull, with B standing higher around."""
        inside = np.zeros(a.size, dtype=np.bool_)
        if (a.lower > b.hull.upper).any() or (a.upper < b.hull.lower).any() or b.hull.dimension < 3:
            return inside
        candidates = np.flatnonzero(_in_box(a.coarse, b.hull.lower, b.hull.upper))
        candidates = candidates[b.hull.facet_distance(a.coarse[candidates]) < -self.deviation]
        if len(candidates) < self._least(a.size):
            return inside
        step = -(-len(candidates) // CONTENT)
        chosen = candidates[::step]
        wall = b.coarse[:: -(-len(b.coarse) // WALL)]
        held = np.zeros(len(chosen), dtype=np.bool_)
        for up in self._ups(b):
            walled = surrounded(a.coarse[chosen], wall, up, self.deviation)
            walled[walled] = ~self._under(a.coarse[chosen[walled]], b, up)
            held |= walled
        inside[chosen[held]] = True
        if step > 1:  # the points between follow the nearest one that was looked at
            nearest = KDTree(a.coarse[chosen]).query(a.coarse[candidates])[1]
            inside[candidates] = held[nearest]
        if np.count_nonzero(inside) < self._least(a.size):
            inside[:] = False
        return inside

    def _under(self, places: FloatArray, b: SurfaceCloud, up: FloatArray) -> BoolArray:
        """Which places have B above them and none of it below: they are under it, not in it."""
        under = roofed(places, b.coarse, up, self.deviation, b.spacing)
        under[under] = ~roofed(places[under], b.coarse, -up, self.deviation, b.spacing)
        return under

    def _ups(self, b: SurfaceCloud) -> list[FloatArray]:
        """Directions in which an object may be open: up, or its own axes where up is not known."""
        if self.up is not None:
            return [self.up]
        centred = b.coarse - b.coarse.mean(axis=0)
        _, axes = np.linalg.eigh(centred.T @ centred)
        return [sign * axis for axis in axes.T for sign in (1.0, -1.0)]

    @staticmethod
    def _least(size: int) -> int:
        """Fewest interior points that count."""
        return max(1 if size < 30 else 3, int(np.ceil(TOLERANCES.interior_share * size)))

    def _row(self, a: SurfaceCloud, b: SurfaceCloud, interior: BoolArray, touching: bool) -> IntArray:
        """(interior, boundary, exterior) counts of A's mean points, without what noise explains."""
        rest = np.flatnonzero(~interior)
        reach = self.deviation + max(a.cell, b.cell)
        distance = np.asarray(b.tree.query(a.coarse[rest], distance_upper_bound=reach)[0])
        boundary = int(np.count_nonzero(distance <= reach)) if touching else 0
        inner = int(np.count_nonzero(interior))
        if touching and boundary == 0 and inner == 0:
            boundary = 1  # the contact itself lies on both boundaries, between the mean points
        outer = a.size - inner - boundary
        if inner:  # who is in B is outside only beyond the hull: no wall stands higher than the rim
            free = rest[~(distance <= reach)] if touching else rest
            outer = int(np.count_nonzero(b.hull.facet_distance(a.coarse[free]) > 0))
            boundary = a.size - inner - outer
        if inner and outer <= TOLERANCES.exterior_share * a.size:
            boundary, outer = boundary + outer, 0
        return np.array([inner, boundary, outer], dtype=np.int64)

    def _overlap(self, a: SurfaceCloud, b: SurfaceCloud, inner_a: BoolArray, inner_b: BoolArray) -> float:
        """How deep two crossing objects lie in each other [m]."""
        depths = [
            float(np.median(other.tree.query(one.coarse[inner])[0]))
            for one, other, inner in ((a, b, inner_a), (b, a, inner_b))
        ]
        return max(depths)

    def _confidence(self, relation: Relation, gap: float, matrix: IntArray, observed: bool) -> float:
        """How far the evidence is from where the relation would change, as a number from 0.5 to 1."""
        if relation is Relation.DISJOINT:
            margin = (gap - self.deviation) / self.deviation
            return (
                float(1 - 0.5 * np.exp(-margin / 2)) if observed else 0.5 + 0.4 * min(1.0, gap / self.reach)
            )
        if relation is Relation.TOUCH:
            return float(0.6 + 0.39 * (1 - gap / self.deviation))
        share = max(float(matrix[0, 0]) / matrix[0].sum(), float(matrix[1, 0]) / matrix[1].sum())
        return float(1 - 0.5 * np.exp(-share / (4 * TOLERANCES.interior_share)))


def _in_box(points: FloatArray, lower: FloatArray, upper: FloatArray) -> BoolArray:
    return np.asarray(((points >= lower) & (points <= upper)).all(axis=1))
