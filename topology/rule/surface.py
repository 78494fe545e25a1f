"""One object's cloud prepared for the default rule, cleaned and thinned; distances between two of them."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from topple.topology.arrays import BoolArray, FloatArray, IntArray, bounds, lengths, middle_of
from topple.topology.geometry.axes import own_axes
from topple.topology.geometry.hull import Hull
from topple.topology.geometry.thin import cell_keys
from topple.topology.geometry.tolerances import BEFORE
from topple.topology.kernels.cells import Cells, cells_of, turned_bounds
from topple.topology.kernels.neighbours import PointTree
from topple.topology.kernels.pieces import pieces_of_links
from topple.topology.kernels.planes import patch_planes
from topple.topology.rule.tolerances import (
    AROUND,
    BESIDE,
    BREAK,
    CANDIDATES,
    COARSE,
    FAR,
    FEW,
    FILLED,
    FINE,
    LARGEST_CELL,
    LINKS,
    PATCH,
    PLACES,
    PROBES,
)
from topple.topology.tolerances import TOLERANCES

CROPPED = 0.5
"""Share of a surface below which a search tree of that part alone pays."""


@dataclass(frozen=True, eq=False)
class SurfaceCloud:
    """A cloud on two levels: all kept points, and one mean point per cell.

    Attributes:
        name: Name of the object.
        points: (N, 3) kept points, grouped by cell [m].
        starts: (M + 1,) rows of `points` at which the cells begin.
        coarse: (M, 3) mean point of each cell [m].
        cell: Edge of the cells [m], 0 where every point is a cell of its own.
        dropped: Number of stray points left out.
        tree: Search tree of the mean points.
        spacing: Typical distance from a mean point to its fourth neighbour [m].
    """

    name: str
    points: FloatArray
    starts: IntArray
    coarse: FloatArray
    cell: float
    dropped: int
    tree: PointTree
    spacing: float

    @staticmethod
    def of(name: str, cloud: FloatArray) -> "SurfaceCloud":
        """Thin a cloud and drop its stray pieces.

        Args:
            name: Name of the object.
            cloud: (N, 3) points [m].
        """
        cells, cell = _cells(cloud)
        points, starts, sizes, coarse = cloud[cells.order], cells.starts, cells.sizes, cells.means()
        tree = PointTree(coarse)
        kept = _well_connected(tree, sizes, cell)
        tree = tree if kept.all() else PointTree(coarse[kept])
        main, fourth = _main_pieces(tree)
        kept[kept] = main
        dropped = len(points) - int(sizes[kept].sum())
        if dropped:
            points, sizes, coarse = points[np.repeat(kept, sizes)], sizes[kept], coarse[kept]
            starts = np.concatenate([[0], np.cumsum(sizes)])
            if not main.all():
                tree = PointTree(coarse)
                fourth = tree.query(tree.data, 5)[0][:, -1]
        return SurfaceCloud(name, points, starts, coarse, cell, dropped, tree, float(np.median(fourth)))

    @cached_property
    def hull(self) -> Hull:
        """Hull of the mean points: trimmed of noise by half a cell's worth of averaging."""
        return Hull.of(self.coarse)

    @cached_property
    def places(self) -> FloatArray:
        """(N, 3) places spread over the hull, which may face other surfaces [m]."""
        return self.hull.spread(PLACES)

    @cached_property
    def _box(self) -> tuple[FloatArray, FloatArray]:
        return bounds(self.points)

    @property
    def lower(self) -> FloatArray:
        """(3,) least corner of the box of the kept points [m]."""
        return self._box[0]

    @property
    def upper(self) -> FloatArray:
        """(3,) greatest corner of the box of the kept points [m]."""
        return self._box[1]

    @property
    def size(self) -> int:
        """Number of mean points: what the matrix counts."""
        return len(self.coarse)

    def rows_of(self, cells: IntArray) -> FloatArray:
        """The kept points of some cells, (n, 3) [m]."""
        sizes = self.starts[cells + 1] - self.starts[cells]
        first = np.repeat(self.starts[cells] - (np.cumsum(sizes) - sizes), sizes)
        return self.points[first + np.arange(len(first))]


def _cells(cloud: FloatArray) -> tuple[Cells, float]:
    """The points by cell, and the edge [m] of the cells, 0 where each holds one; they lie along the cloud."""
    if len(cloud) <= COARSE:
        return Cells(cloud, np.arange(len(cloud)), np.arange(len(cloud) + 1)), 0.0
    turn = own_axes(cloud)
    lower, upper = turned_bounds(cloud, turn)
    extent = upper - lower
    cell = max(float(extent.max()), 1e-9) / 40
    # Cells of a surface go with the inverse square of their edge: one look at a part settles the edge.
    probe = (cloud[:: -(-len(cloud) // (8 * COARSE))] - cloud[0]) @ turn.T
    occupied = len(np.unique(cell_keys(probe, lower, upper, cell)))
    cell = min(float(np.clip(cell * (occupied / COARSE) ** 0.5, cell / 6, 2 * cell)), LARGEST_CELL)
    return cells_of(cloud, lower - BEFORE, upper, cell, turn), cell


def _well_connected(tree: PointTree, sizes: IntArray, cell: float) -> BoolArray:
    """Which cells are filled like a surface, or lie beside one that is.

    At a mask's edge pixels show the neighbour, or hang in the air between the two: lines of cells that hold
    few points.
    """
    kept = np.ones(len(sizes), dtype=np.bool_)
    if cell == 0:
        return kept
    around = tree.sums_around(sizes.astype(np.float64), AROUND * cell)
    core = around >= FILLED * np.median(around)
    if core.any() and not core.all():
        coarse = np.asarray(tree.data)
        kept[~core] = PointTree(coarse[core]).query(coarse[~core])[0] <= BESIDE * cell
    return kept


def _main_pieces(tree: PointTree) -> tuple[BoolArray, FloatArray]:
    """Which points belong to a piece of the cloud that is no stray: large enough a share of the whole.

    Also the distance of each to its fourth neighbour [m], of few points 0.
    """
    coarse = np.asarray(tree.data)
    if len(coarse) < 30:
        fourth = tree.query(tree.data, 5)[0][:, -1] if len(coarse) >= 5 else np.zeros(len(coarse))
        return np.ones(len(coarse), dtype=np.bool_), fourth
    distance, index = tree.query(tree.data, LINKS + 1)
    limit = BREAK * float(np.median(distance[:, 4]))
    rows = np.repeat(np.arange(len(coarse)), LINKS)
    linked = (distance[:, 1:] <= limit).ravel()
    links = np.stack([rows[linked], index[:, 1:].ravel()[linked]], axis=1)
    labels = pieces_of_links(links, len(coarse))
    sizes = np.bincount(labels)
    stray = sizes < min(TOLERANCES.stray_share * len(coarse), sizes.max())
    for label in np.flatnonzero(stray & (sizes >= FEW)):
        stray[label] = _width(coarse[labels == label]) < limit / BREAK
    return ~stray[labels], distance[:, 4]


def _width(points: FloatArray) -> float:
    """Spread (standard deviation) across the longest direction of a piece [m]."""
    centred = points - middle_of(points)
    return float(np.sqrt(max(np.linalg.eigvalsh(centred.T @ centred)[1], 0.0) / len(points)))


@dataclass(frozen=True, eq=False)
class Reaching:
    """(N,) distances of points to a surface [m], infinite beyond a limit [m]: see `distances`."""

    distances: FloatArray
    limit: float


@dataclass(frozen=True, eq=False)
class Closest:
    """The nearest regions of two surfaces.

    Attributes:
        gap: Distance of the surfaces [m], by the closest points that are no strays.
        pairs: (k, 2, 3) closest points, on the first and on the second surface [m].
        of_a: How far the mean points of the first are from those of the second.
        of_b: The other way round; None where that was not asked.
    """

    gap: float
    pairs: FloatArray
    of_a: "Reaching"
    of_b: "Reaching | None"

    @property
    def apart(self) -> float:
        """Distance of the closest samples [m], which is never less than the surfaces'."""
        return float(lengths(self.pairs[:, 0] - self.pairs[:, 1]).min())


def closest(a: SurfaceCloud, b: SurfaceCloud) -> Closest:
    """Distance of two surfaces and where they are closest.

    The distance from a point to a sampled surface is that to the plane through the nearest samples, as far
    as they reach: sparse clouds of surfaces in contact do not seem apart by their spacing.

    Args:
        a: One surface.
        b: The other.
    """
    slack = 2 * (a.cell + b.cell)
    if a.cell == 0 or b.cell == 0:  # patches of single points reach as far as their neighbours do
        slack += 3 * max(a.spacing, b.spacing)
    more = 1 + 1e-9  # a distance there and one back differ by their rounding
    bound = float(np.min(b.tree.query(_at_most(a.coarse, PROBES))[0])) * more
    near_a = distances(a.coarse, b, bound + slack)
    of_a = Reaching(near_a, bound + slack)
    apart = float(near_a.min())
    if 0 < FAR * slack < apart:
        return _far(a, b, of_a)
    limit = apart * more + slack
    near_b = distances(b.coarse, a, limit)
    fine_a, about_a = _fine(a, near_a, limit)
    fine_b, about_b = _fine(b, near_b, limit)
    tree_a, tree_b = PointTree(fine_a), PointTree(fine_b)
    fine_a = _nearest(fine_a, about_a, tree_b)
    fine_b = _nearest(fine_b, about_b, tree_a)
    rank = min(8, 1 + min(len(a.points), len(b.points)) // 60)  # so many strays may come closer
    forward, feet = _to_surface(fine_a, tree_b)
    backward, heads = _to_surface(fine_b, tree_a)
    first, second = np.argsort(forward, kind="stable")[:64], np.argsort(backward, kind="stable")[:64]
    pairs = np.concatenate(
        [np.stack([fine_a[first], feet[first]], axis=1), np.stack([heads[second], fine_b[second]], axis=1)]
    )
    gap = min(_ranked(forward, rank), _ranked(backward, rank))
    return Closest(gap, pairs, of_a, Reaching(near_b, limit))


def _far(a: SurfaceCloud, b: SurfaceCloud, of_a: Reaching) -> Closest:
    """The nearest mean points: how they lie in their cells hardly lengthens a distance of many cells."""
    chosen = np.argsort(of_a.distances, kind="stable")[:64]
    feet = b.coarse[b.tree.query(a.coarse[chosen])[1]]
    pairs = np.stack([a.coarse[chosen], feet], axis=1)
    return Closest(float(of_a.distances[chosen[0]]), pairs, of_a, None)


def distances(points: FloatArray, other: SurfaceCloud, limit: float) -> FloatArray:
    """How far points are from the nearest mean point of a surface.

    Args:
        points: (N, 3) points [m].
        other: The surface.
        limit: Beyond it [m] nothing is looked for.

    Returns:
        (N,) distances [m], infinite beyond the limit.
    """
    chosen = np.flatnonzero(within_box(points, *other.tree.box, limit))
    distance = np.full(len(points), np.inf)
    if len(chosen):
        within = np.nextafter(limit, np.inf)  # the search leaves out its bound itself
        tree = _around(other, points[chosen], limit)
        distance[chosen] = tree.query(points[chosen], distance_upper_bound=within)[0]
    return distance


def _around(surface: SurfaceCloud, points: FloatArray, limit: float) -> PointTree:
    """A search tree that has all mean points of a surface which are within a limit of points.

    From the middle of a room all of its walls are equally far, and a search tree of them goes through them
    all for every point. What is within the limit of the points' box is little of that.
    """
    near = within_box(surface.coarse, *bounds(points), limit)
    few = 0 < np.count_nonzero(near) < CROPPED * surface.size
    return PointTree(surface.coarse[near]) if few else surface.tree


def within_box(points: FloatArray, lower: FloatArray, upper: FloatArray, limit: float) -> BoolArray:
    """Which points are at most so far from a box.

    Args:
        points: (N, 3) points [m].
        lower: (3,) least corner of the box [m].
        upper: (3,) greatest corner [m].
        limit: Distance [m].

    Returns:
        (N,) True for those.
    """
    apart = np.maximum(np.maximum(lower - points, points - upper), 0.0)
    reach = limit * (1 + 1e-9)  # as rounding may have it
    return np.asarray(np.einsum("ni,ni->n", apart, apart) <= reach**2)


def _ranked(values: FloatArray, rank: int) -> float:
    """The value that `rank - 1` others fall below."""
    rank = min(rank, len(values))
    return float(np.partition(values, rank - 1)[rank - 1])


def _at_most(points: FloatArray, count: int) -> FloatArray:
    return points[:: max(1, -(-len(points) // count))]


def _fine(surface: SurfaceCloud, near: FloatArray, limit: float) -> tuple[FloatArray, FloatArray]:
    """The kept points (N, 3) of the cells within a limit [m], and (N,) how far away their cells are [m]."""
    cells = np.flatnonzero(near <= limit)
    about = np.repeat(near[cells], surface.starts[cells + 1] - surface.starts[cells])
    return _at_most(surface.rows_of(cells), FINE), _at_most(about, FINE)


def _nearest(points: FloatArray, about: FloatArray, tree: PointTree) -> FloatArray:
    """The points nearest to the samples of a surface: where the surfaces are closest, one of them is.

    Those whose cells are nearest bound how far the others may be: most are not searched for.
    """
    if len(points) <= CANDIDATES:
        return points
    likely = np.argpartition(about, CANDIDATES)[:CANDIDATES]
    bound = float(np.max(tree.query(points[likely])[0]))
    distance = tree.query(points, distance_upper_bound=np.nextafter(bound, np.inf))[0]
    return points[np.sort(np.argpartition(distance, CANDIDATES)[:CANDIDATES])]


def _to_surface(points: FloatArray, tree: PointTree) -> tuple[FloatArray, FloatArray]:
    """(N,) distances of points to the surface that samples show, and the (N, 3) nearest samples."""
    surface = np.asarray(tree.data)
    count = min(PATCH, len(surface))
    distance, index = tree.query(points, k=count)
    distance, index = distance.reshape(len(points), count), index.reshape(len(points), count)
    nearest = surface[index[:, 0]]
    if count < 3:
        return distance[:, 0], nearest
    patch = surface[index]
    middle, normal, _ = patch_planes(patch)
    height = np.abs(np.einsum("ni,ni->n", points - middle, normal))
    # Samples reach half their spacing beyond the last one.
    reach = 0.5 * np.linalg.norm(patch[:, 1:4] - nearest[:, None], axis=2).mean(axis=1)
    beside = np.sqrt(
        np.maximum(distance[:, 0] ** 2 - np.einsum("ni,ni->n", points - nearest, normal) ** 2, 0)
    )
    return np.minimum(distance[:, 0], np.hypot(height, np.maximum(beside - reach, 0.0))), nearest
