"""The default rule: relations that withstand noise, hidden surfaces and hollow objects.

Where the paper asks whether any point lies in a hull (equation 4), this rule asks how many, and of the
surface instead of its hull: a point is interior to an object that surrounds it, on its boundary near it,
else exterior. The relation follows from Table 1 as before, but for counts that noise alone explains and for
contacts, which the distance of the surfaces decides: it is finer than counts of mean points. Where the
answer then differs from what Table 1 reads in the matrix, the pair says why.
"""

from collections.abc import Collection
from dataclasses import dataclass, field, replace
from functools import cache

import numpy as np

from topple.topology.base.arrays import BoolArray, FloatArray, IntArray, median_of, middle_of, within_corners
from topple.topology.base.tolerances import TOLERANCES
from topple.topology.kernels.neighbours import PointTree
from topple.topology.relations.cavity import is_roofed, is_surrounded
from topple.topology.relations.facing import facing_seen
from topple.topology.relations.inferred import infer_contacts
from topple.topology.relations.surface import Closest, Reaching, SurfaceCloud, closest, distances
from topple.topology.relations.tolerances import CONTENT, WALL
from topple.topology.scene.cloud import estimate_deviation
from topple.topology.scene.scene import Scene
from topple.topology.scene.sight import seen_in, seen_points
from topple.topology.sixim.confidence import Evidence, confidence, is_best
from topple.topology.sixim.pair import PairRelation
from topple.topology.sixim.relation_table import AnyTable, box_distance
from topple.topology.sixim.table import Relation, classify, kind_of
from topple.topology.views.free_space import FreeSpace

CLOSE = "surfaces within the deviation"
"""Why two touch although no mean point of either is near the other: the contact lies between them."""
APART = "surfaces further apart than the deviation"
"""Why two are disjoint although mean points of either are near the other: they speak for whole cells."""
FEW = "too few points inside to count"
"""Why one is not in the other although points are: noise explains them."""
HOLLOW = "held in its hollow"
"""Why one is within the other although points seem outside: none but a few lie beyond the hull."""

_HELD = frozenset({Relation.WITHIN, Relation.CONTAIN})


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
    sight: FreeSpace | None = field(default=None, repr=False)
    reach: float = TOLERANCES.reach

    def prepare(self, name: str, cloud: FloatArray) -> SurfaceCloud:
        """Clean and thin a cloud (N, 3)."""
        return SurfaceCloud.of(name, cloud)

    def relate(self, a: SurfaceCloud, b: SurfaceCloud) -> PairRelation:
        """Relate two prepared clouds."""
        least = box_distance(a, b)
        if least > self._reach(a, b) + max(a.spacing, b.spacing):  # no patch of either reaches the other
            nowhere = np.array([[0, 0, a.size], [0, 0, b.size]], dtype=np.int64)
            out = cache(lambda: self._gap_between(closest(a, b), least))
            pair = PairRelation(a.name, b.name, Relation.DISJOINT, nowhere, out, least_gap=least)
            return self._weigh(pair, a, b)
        near = closest(a, b)
        touching = near.gap <= self.deviation
        one, other = self._count_points(a, b, near.of_a), self._count_points(b, a, near.of_b)
        matrix = np.stack([one.counts, other.counts])
        relation = self._relation(one, other, touching)
        depth = max(one.depth(b), other.depth(a)) if relation is Relation.CROSS else 0.0
        reason = _reason(matrix, relation)
        gap = near.gap if touching else self._gap_between(near, least)
        pair = PairRelation(
            a=a.name,
            b=b.name,
            relation=relation,
            counts=matrix,
            distance=-depth if depth > 0 else gap,
            kind=kind_of(matrix) if reason is None else None,
            reason=reason,
        )
        return self._weigh(pair, a, b)

    def _gap_between(self, near: Closest, least: float) -> float:
        """The gap [m] of two that do not touch, whose boxes are at least so far apart [m].

        A patch reaches half its spacing beyond the last sample; what is apart is not that close. Whether it
        is out of reach its samples say, in any frame: boxes along the axes hold only what they leave.
        """
        return near.apart if near.apart > self.reach else max(near.gap, least)

    def _reach(self, a: SurfaceCloud, b: SurfaceCloud) -> float:
        """How far the mean points [m] of either are on the boundary of the other."""
        return self.deviation + max(a.cell, b.cell)

    def _weigh(self, pair: PairRelation, a: SurfaceCloud, b: SurfaceCloud) -> PairRelation:
        """The pair with how sure it is. What is in something, or on it, was seen there."""
        observed = pair.relation is not Relation.DISJOINT or self._seen_apart(pair, a, b)
        return replace(pair, observed=observed, confidence=self._confidence(pair, observed))

    def _seen_apart(self, pair: PairRelation, a: SurfaceCloud, b: SurfaceCloud) -> bool:
        """Whether two disjoint objects were seen not to meet, or are too far apart to meet unseen."""
        return self.sight is None or facing_seen(a, b, self.sight) or not pair.within(self.reach)

    def after(self, scene: Scene, changed: Collection[str], looked_again: bool) -> "RobustRule":
        """The rule that knows what the cameras see now."""
        if self.sight is None and not looked_again:
            return self
        if self.sight is None or looked_again:
            return replace(self, sight=seen_in(scene))
        clouds = {name: seen_points(scene, name) for name in changed}
        return replace(self, sight=self.sight.with_clouds(clouds))

    def look_again(self, pair: PairRelation, a: SurfaceCloud, b: SurfaceCloud) -> PairRelation:
        """Whether a gap between two that stayed is still in sight."""
        if pair.relation is not Relation.DISJOINT or self.sight is None:
            return pair
        return self._weigh(pair, a, b)

    def conclude(self, scene: Scene, relations: AnyTable) -> AnyTable:
        """Add the hidden contacts that gravity demands of the objects without their stray points."""
        kept = {one.name: one for one in relations.prepared if isinstance(one, SurfaceCloud)}
        for one in kept.values():
            if one.dropped and one.name not in scene.whole:
                scene = scene.with_cloud(one.name, one.points)
        if self.sight is None:
            return infer_contacts(scene, relations)
        return infer_contacts(scene, relations, lambda pair: pair.observed)

    def _interior(self, a: SurfaceCloud, b: SurfaceCloud) -> BoolArray:
        """Which mean points of A lie in B's solid or hollow: in its hull, with B standing higher around."""
        inside = np.zeros(a.size, dtype=np.bool_)
        lower, upper = b.tree.box[0] + self.deviation, b.tree.box[1] - self.deviation
        if np.any(a.tree.box[0] > upper) or np.any(a.tree.box[1] < lower):
            return inside
        candidates = np.flatnonzero(within_corners(a.coarse, lower, upper))
        if len(candidates) > CONTENT:
            candidates = candidates[b.hull.facet_distance(a.coarse[candidates]) < -self.deviation]
        if len(candidates) == 0:
            return inside
        step = -(-len(candidates) // CONTENT)
        chosen = candidates[::step]
        wall = b.coarse[:: -(-len(b.coarse) // WALL)]
        held = np.zeros(len(chosen), dtype=np.bool_)
        for up in self._ups(b):
            walled = is_surrounded(a.coarse[chosen], wall, up, self.deviation)
            walled[walled] = ~self._under(a.coarse[chosen[walled]], b, up)
            held |= walled
        if not held.any() or b.hull.dimension < 3:  # mostly the hull is not asked for
            return inside
        held[held] = b.hull.facet_distance(a.coarse[chosen[held]]) < -self.deviation
        inside[chosen[held]] = True
        if step > 1:  # the points between follow the nearest one that was looked at
            nearest = PointTree(a.coarse[chosen]).query(a.coarse[candidates])[1]
            inside[candidates] = held[nearest]
        return inside

    def _under(self, places: FloatArray, b: SurfaceCloud, up: FloatArray) -> BoolArray:
        """Which places have B above them and none of it below: they are under it, not in it."""
        under = is_roofed(places, b.coarse, up, self.deviation, b.spacing)
        under[under] = ~is_roofed(places[under], b.coarse, -up, self.deviation, b.spacing)
        return under

    def _ups(self, b: SurfaceCloud) -> list[FloatArray]:
        """Directions in which an object may be open: up, or its own axes where up is not known."""
        if self.up is not None:
            return [self.up]
        centred = b.coarse - middle_of(b.coarse)
        _, axes = np.linalg.eigh(centred.T @ centred)
        return [sign * axis for axis in axes.T for sign in (1.0, -1.0)]

    def _count_points(self, a: SurfaceCloud, b: SurfaceCloud, known: Reaching | None) -> "_Counted":
        """Where the mean points of A lie in B; how far they are from B's is known as far as that reaches."""
        interior = self._interior(a, b)
        rest = np.flatnonzero(~interior)
        reach = self._reach(a, b)
        if known is not None and known.limit >= reach:
            away = known.distances[rest]
        else:
            away = distances(a.coarse[rest], b, reach)
        exterior = rest[~(away <= reach)]
        counts = np.array([a.size - len(rest), len(rest) - len(exterior), len(exterior)], dtype=np.int64)
        if counts[0] < _least(a.size):
            return _Counted(counts, False, True, a.coarse[:0])
        # What is in B is outside only beyond the hull: no wall stands higher than the rim.
        beyond = int(np.count_nonzero(b.hull.facet_distance(a.coarse[exterior]) > 0))
        return _Counted(counts, True, beyond > TOLERANCES.exterior_share * a.size, a.coarse[interior])

    @staticmethod
    def _relation(one: "_Counted", other: "_Counted", touching: bool) -> Relation:
        """Look up in Table 1 the counts that noise does not explain, and the surfaces' distance."""
        if one.held and other.held:
            return Relation.CROSS
        if one.held:
            return Relation.PARTIAL_WITHIN if one.stands_out else Relation.WITHIN
        if other.held:
            return Relation.PARTIAL_CONTAIN if other.stands_out else Relation.CONTAIN
        return Relation.TOUCH if touching else Relation.DISJOINT

    def _confidence(self, pair: PairRelation, observed: bool) -> float:
        """How often relations with such evidence are true."""
        cameras = 0 if self.sight is None else len(self.sight.viewpoints)
        if pair.relation is Relation.DISJOINT:
            kind, unit = (Evidence.APART, self.deviation) if observed else (Evidence.APART_UNSEEN, 1.0)
            gap = pair.least_gap if is_best(kind, cameras, pair.least_gap / unit) else pair.gap
            return confidence(kind, cameras, gap / unit)
        if pair.relation is Relation.TOUCH:
            return confidence(Evidence.TOUCH, cameras, pair.gap / self.deviation)
        return confidence(Evidence.INSIDE, cameras, inner_share(pair.matrix))


def robust(scene: Scene, deviation: float | None = None) -> RobustRule:
    """The rule that withstands noise, hidden surfaces and hollow objects, for a scene.

    Args:
        scene: The scene.
        deviation: The deviation factor δ [m]; estimated where None.
    """
    estimated = estimate_deviation(scene) if deviation is None else deviation
    return RobustRule(deviation=estimated, up=scene.up, sight=seen_in(scene))


def inner_share(matrix: IntArray) -> float:
    """Share of the cloud that lies deeper in the other one, of a matrix (2, 3) of counts."""
    return float((matrix[:, 0] / matrix.sum(axis=1)).max())


@dataclass(frozen=True, eq=False)
class _Counted:
    """Where the mean points of one cloud lie in another.

    Attributes:
        counts: (3,) (interior, boundary, exterior): in its solid or hollow, near its surface, else.
        held: Whether more lie in the interior than noise puts there.
        stands_out: Whether more lie beyond its hull than noise puts there.
        inside: (k, 3) those in the interior [m].
    """

    counts: IntArray
    held: bool
    stands_out: bool
    inside: FloatArray

    def depth(self, surface: SurfaceCloud) -> float:
        """How deep those in the interior lie under the surface of what they lie in [m]."""
        return median_of(surface.tree.query(self.inside)[0])


def _least(size: int) -> int:
    """Fewest interior points of so many that count."""
    return max(1 if size < 30 else 3, int(np.ceil(TOLERANCES.interior_share * size)))


def _reason(matrix: IntArray, relation: Relation) -> str | None:
    """Why the relation is another than Table 1 reads in the matrix, None where it is the same."""
    if classify(matrix) is relation:
        return None
    interior = matrix[:, 0] > 0
    if relation in _HELD and interior.sum() == 1:
        return HOLLOW
    if interior.any():
        return FEW
    return CLOSE if relation is Relation.TOUCH else APART
