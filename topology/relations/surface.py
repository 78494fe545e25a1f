"""One object's cloud prepared for the default rule, cleaned and thinned; distances between two of them."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from topple.topology.base.arrays import BoolArray, FloatArray, IntArray, median_of, middle_of
from topple.topology.base.tolerances import TOLERANCES
from topple.topology.geometry.axes import own_axes
from topple.topology.geometry.hull import Hull
from topple.topology.geometry.tolerances import BEFORE
from topple.topology.kernels.cells import Cells, cells_of, turned_bounds
from topple.topology.kernels.closest import closest_places
from topple.topology.kernels.neighbours import PointTree
from topple.topology.kernels.pieces import pieces_of_links
from topple.topology.relations.tolerances import (
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


@dataclass(frozen=True, eq=False)
class SurfaceCloud:
    """A cloud on two levels: all kept points, and one mean point per cell.

    Attributes:
        name: Name of the object.
        cloud: (K, 3) points as they were given [m].
        order: (N,) rows of the kept ones, cell after cell.
        starts: (M + 1,) places in `order` at which the cells begin.
        coarse: (M, 3) mean point of each cell [m].
        cell: Edge of the cells [m], 0 where every point is a cell of its own.
        dropped: Number of stray points left out.
        tree: Search tree of the mean points.
        spacing: Typical distance from a mean point to its fourth neighbour [m].
    """

    name: str
    cloud: FloatArray
    order: IntArray
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
        order, starts, sizes, coarse = cells.order, cells.starts, cells.sizes, cells.means()
        tree = PointTree(coarse)
        around, distance, index = tree.around(sizes.astype(np.float64), AROUND * cell, LINKS + 1)
        kept = _main_pieces(coarse, _well_connected(coarse, around, cell), distance, index)
        spacing = median_of(distance[kept, 4]) if len(coarse) >= 5 else 0.0
        dropped = len(order) - int(sizes[kept].sum())
        if dropped:
            order, sizes, coarse = order[np.repeat(kept, sizes)], sizes[kept], coarse[kept]
            starts, tree = np.concatenate([[0], np.cumsum(sizes)]), PointTree(coarse)
        return SurfaceCloud(name, cloud, order, starts, coarse, cell, dropped, tree, spacing)

    @cached_property
    def hull(self) -> Hull:
        """Hull of the mean points: trimmed of noise by half a cell's worth of averaging."""
        return Hull.of(self.coarse)

    @cached_property
    def places(self) -> FloatArray:
        """(N, 3) places spread over the hull, which may face other surfaces [m]."""
        return self.hull.spread(PLACES)

    @cached_property
    def points(self) -> FloatArray:
        """(N, 3) kept points, grouped by cell [m]."""
        found = self.cloud.take(self.order, axis=0)  # a quarter of what indexing takes
        found.setflags(write=False)
        return found

    @cached_property
    def _box(self) -> tuple[FloatArray, FloatArray]:
        return turned_bounds(self.points if self.dropped else self.cloud)

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

    def some_of(self, cells: IntArray, most: int) -> tuple[FloatArray, IntArray]:
        """At most so many kept points (n, 3) [m] of some cells, evenly, and (n,) the cell of each."""
        ends = np.cumsum(self.starts[cells + 1] - self.starts[cells])
        count = int(ends[-1]) if len(ends) else 0
        chosen = np.arange(0, count, max(1, -(-count // most)))
        cell = np.searchsorted(ends, chosen, side="right")
        place = chosen + (self.starts[cells + 1] - ends)[cell]
        return self.cloud.take(self.order[place], axis=0), cells[cell]


def _cells(cloud: FloatArray) -> tuple[Cells, float]:
    """The points by cell, and the edge [m] of the cells, 0 where each holds one; they lie along the cloud."""
    if len(cloud) <= COARSE:
        return Cells(cloud, np.arange(len(cloud)), np.arange(len(cloud) + 1)), 0.0
    turn = own_axes(cloud)
    lower, upper = turned_bounds(cloud, turn)
    extent = upper - lower
    cell = max(float(extent.max()), 1e-9) / 40
    # Cells of a surface go with the inverse square of their edge: one look at a part settles the edge.
    probe = cloud[:: -(-len(cloud) // (8 * COARSE))]  # from the first point on, as the grid
    occupied = len(cells_of(probe, lower - BEFORE, upper, cell, turn).sizes)
    cell = min(float(np.clip(cell * (occupied / COARSE) ** 0.5, cell / 6, 2 * cell)), LARGEST_CELL)
    return cells_of(cloud, lower - BEFORE, upper, cell, turn), cell


def _well_connected(coarse: FloatArray, around: FloatArray, cell: float) -> BoolArray:
    """Which cells are filled like a surface, by the points around each, or lie beside one that is.

    At a mask's edge pixels show the neighbour, or hang in the air between the two: lines of cells that hold
    few points.
    """
    kept = np.ones(len(coarse), dtype=np.bool_)
    if cell == 0:
        return kept
    core = around >= FILLED * median_of(around)
    if core.any() and not core.all():
        kept[~core] = PointTree(coarse[core]).query(coarse[~core])[0] <= BESIDE * cell
    return kept


def _main_pieces(coarse: FloatArray, kept: BoolArray, distance: FloatArray, index: IntArray) -> BoolArray:
    """Which of the kept points belong to a piece of the cloud that is no stray: large enough a share of it.

    They hang together by their nearest neighbours, given by distance [m] and row as far as there are any.
    """
    count = np.count_nonzero(kept)
    if count < 30:
        return kept
    limit = BREAK * median_of(distance[kept, 4])
    links = np.empty((*index.shape, 2), dtype=np.int64)
    links[:] = np.arange(len(kept))[:, None, None]
    np.copyto(links[:, :, 1], index, where=(distance <= limit) & kept.take(index) & kept[:, None])
    labels = pieces_of_links(links.reshape(-1, 2), len(kept))
    sizes = np.bincount(labels, weights=kept)
    stray = sizes < min(TOLERANCES.stray_share * count, sizes.max())
    for label in np.flatnonzero(stray & (sizes >= FEW)):
        stray[label] = _width(coarse[labels == label]) < limit / BREAK
    return kept & ~stray[labels]


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
        apart: Distance of the closest samples [m], which is never less than the surfaces'.
        of_a: How far the mean points of the first are from those of the second.
        of_b: The other way round; None where that was not asked.
    """

    gap: float
    apart: float
    of_a: "Reaching"
    of_b: "Reaching | None"


def closest(a: SurfaceCloud, b: SurfaceCloud) -> Closest:
    """Measure the distance of two surfaces.

    Args:
        a: One surface.
        b: The other.
    """
    slack = a.cell + b.cell
    if a.cell == 0 or b.cell == 0:  # patches of single points reach as far as their neighbours do
        slack += 3 * max(a.spacing, b.spacing)
    more = 1 + 1e-9  # a distance there and one back differ by their rounding
    bound = float(np.min(b.tree.query(_at_most(a.coarse, PROBES))[0])) * more
    near_a = distances(a.coarse, b, bound + slack)
    of_a = Reaching(near_a, bound + slack)
    apart = float(near_a.min())
    if 0 < FAR * slack < apart:
        return Closest(apart, apart, of_a, None)  # how points lie in their cells hardly lengthens that
    limit = apart * more + slack
    near_b = distances(b.coarse, a, limit)
    found = closest_places(_fine(a, near_a, limit), _fine(b, near_b, limit), CANDIDATES, PATCH)
    rank = min(8, 1 + min(len(a.order), len(b.order)) // 60)  # so many strays may come closer
    gap = min(_rank_value(surface, rank) for surface, _ in found)
    sample = min(float(samples.min()) for _, samples in found)
    return Closest(gap, sample, of_a, Reaching(near_b, limit))


def distances(points: FloatArray, other: SurfaceCloud, limit: float) -> FloatArray:
    """How far points are from the nearest mean point of a surface.

    Args:
        points: (N, 3) points [m].
        other: The surface.
        limit: Beyond it [m] nothing is looked for.

    Returns:
        (N,) distances [m], infinite beyond the limit.
    """
    within = np.nextafter(limit, np.inf)  # the search leaves out its bound itself
    return other.tree.query(points, distance_upper_bound=within)[0]


def _rank_value(values: FloatArray, rank: int) -> float:
    """The value that `rank - 1` others fall below."""
    rank = min(rank, len(values))
    return float(np.partition(values, rank - 1)[rank - 1])


def _at_most(points: FloatArray, count: int) -> FloatArray:
    return points[:: max(1, -(-len(points) // count))]


def _fine(surface: SurfaceCloud, near: FloatArray, limit: float) -> tuple[FloatArray, FloatArray]:
    """Kept points (n, 3) of the cells within a limit [m], and (n,) how far away their cells are [m]."""
    points, cells = surface.some_of(np.flatnonzero(near <= limit), FINE)
    return points, near[cells]
