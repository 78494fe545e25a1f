"""Which points of a scene lie in boxes of many hands at once, cell by cell where that settles it.

A hand that is held against every point of a frame costs milliseconds. Points are gathered in small cells: one
that lies wholly within a box or wholly beside it is counted or passed over as a whole, and only the points of
those that a box cuts through are looked at one by one. The counts are those of all points, looked at singly.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from topple.planner.grasp.tolerances import ASIDE, CELLS_EDGE, GRASP_TOLERANCES, GROUP
from topple.topology.base.arrays import BoolArray, FloatArray, IntArray

MOST = 64  # grasps of a group worked on at once: their tables stay within the processor's cache
ROUNDING = 1e-9  # [m] by which a cell has to be within or beside a box to count as a whole


@dataclass(frozen=True, eq=False)
class Region:
    """A box in the frame of each of P hands, or what of it is within a cylinder around z.

    Attributes:
        lower: (P, 3) bounds [m], not part of it.
        upper: (P, 3) bounds [m], not part of it.
        radius: Of the cylinder [m]; infinite for the box alone.
    """

    lower: FloatArray
    upper: FloatArray
    radius: float = np.inf


def swept(
    count: int,
    x_low: float,
    x_high: float,
    y_low: float | FloatArray,
    y_high: float | FloatArray,
    front: float,
) -> Region:
    """A prism of `count` hands with everything behind it, as far as it is cleared of what lies below."""
    lower, upper = np.empty((count, 3)), np.empty((count, 3))
    for axis, (low, high) in enumerate(((x_low, x_high), (y_low, y_high))):
        lower[:, axis], upper[:, axis] = np.maximum(low, -ASIDE), np.minimum(high, ASIDE)
    lower[:, 2], upper[:, 2] = -GRASP_TOLERANCES.reach, front - GRASP_TOLERANCES.under_clearance
    return Region(lower, upper)


@dataclass(frozen=True, eq=False)
class Cells:
    """Points of several clouds, gathered in cells of one cloud each.

    Attributes:
        clouds: How many clouds.
        points: (N, 3) the points, cell after cell [m].
        first: (C,) where each cell begins in `points`.
        size: (C,) how many points each has.
        owner: (C,) which cloud each is of.
        centre: (C, 3) middle of its points' bounds [m].
        half: (C, 3) half their extent [m].
    """

    clouds: int
    points: FloatArray
    first: IntArray
    size: IntArray
    owner: IntArray
    centre: FloatArray
    half: FloatArray

    @classmethod
    def of(cls, clouds: Sequence[FloatArray], edge: float = CELLS_EDGE) -> "Cells":
        """Gather points.

        Args:
            clouds: (N, 3) points each [m].
            edge: Of a cell [m].

        Returns:
            The cells.
        """
        points = np.vstack([np.empty((0, 3)), *clouds])
        owners = np.repeat(np.arange(len(clouds)), [len(cloud) for cloud in clouds])
        place = np.floor(points / edge).astype(np.int64)
        order = np.lexsort((*place.T, owners))
        points, place, owners = points[order], place[order], owners[order]
        new = np.ones(len(points), dtype=np.bool_)
        new[1:] = (place[1:] != place[:-1]).any(axis=1) | (owners[1:] != owners[:-1])
        first = np.flatnonzero(new)
        size = np.diff([*first.tolist(), len(points)]).astype(np.int64)
        if len(first) == 0:
            empty = np.empty((0, 3))
            return cls(len(clouds), empty, first, size, owners, empty, empty)
        lower, upper = np.minimum.reduceat(points, first), np.maximum.reduceat(points, first)
        return cls(
            len(clouds), points, first, size, owners[first], (lower + upper) / 2.0, (upper - lower) / 2.0
        )

    def counts(self, poses: FloatArray, region: Region) -> IntArray:
        """Count points.

        Args:
            poses: (P, 4, 4) of the hands in the frame of the points.
            region: Where.

        Returns:
            (P, K) points of each of the K clouds in it.
        """
        found = np.zeros((len(poses), self.clouds), dtype=np.int64)
        for rows, near in self._near(poses, [region]):
            found[rows] = near.count(region, rows, None)
        return found

    def more_than(self, stray: int, poses: FloatArray, regions: Sequence[Region]) -> BoolArray:
        """Ask which clouds have more than some stray points in any one of several regions.

        Args:
            stray: So many are none.
            poses: (P, 4, 4) of the hands in the frame of the points.
            regions: Where.

        Returns:
            (P, K) whether they have.
        """
        found = np.zeros((len(poses), self.clouds), dtype=np.bool_)
        for rows, near in self._near(poses, regions):
            for region in regions:
                found[rows] |= near.count(region, rows, stray) > stray
                near.forget(found[rows])
        return found

    def _near(self, poses: FloatArray, regions: Sequence[Region]) -> Iterator[tuple[IntArray, "_Near"]]:
        """Hands that are close together, each time with the cells that are near their regions."""
        if len(poses) == 0 or len(regions) == 0 or len(self.first) == 0:
            return
        lower = np.min([region.lower for region in regions], axis=0)
        upper = np.max([region.upper for region in regions], axis=0)
        middle, extent = (lower + upper) / 2.0, (upper - lower) / 2.0
        centres = poses[:, :3, 3] + np.einsum("pij,pj->pi", poses[:, :3, :3], middle)
        reach, radius = np.linalg.norm(extent, axis=1), np.linalg.norm(self.half, axis=1)
        cubes = np.unique(np.floor(centres / GROUP).astype(np.int64), axis=0, return_inverse=True)[1]
        order = np.argsort(cubes.reshape(-1), kind="stable")
        for group in np.split(order, np.flatnonzero(np.diff(cubes.reshape(-1)[order])) + 1):
            low, high = centres[group].min(axis=0), centres[group].max(axis=0)
            away = np.maximum(np.abs(self.centre - (low + high) / 2.0) - (high - low) / 2.0, 0.0)
            cells = np.flatnonzero(np.linalg.norm(away, axis=1) < reach[group].max() + radius)
            for start in range(0, len(group), MOST):
                rows = group[start : start + MOST]
                yield rows, _Near.of(self, cells, poses[rows], centres[rows], middle[rows], extent[rows])


class _Near:
    """Pairs of hands and cells that may meet: `hand` and `cell` say which, `centre` and `half` where.

    `centre` (3, n) is the cell's middle in the hand's frame and `half` (3, n) how far it reaches along the
    hand's axes.
    """

    def __init__(
        self,
        cells: Cells,
        poses: FloatArray,
        hand: IntArray,
        cell: IntArray,
        centre: FloatArray,
        half: FloatArray,
    ) -> None:
        self.cells, self.poses = cells, poses
        self.hand, self.cell, self.centre, self.half = hand, cell, centre, half

    @staticmethod
    def of(
        cells: Cells,
        some: IntArray,
        poses: FloatArray,
        centres: FloatArray,
        middle: FloatArray,
        extent: FloatArray,
    ) -> "_Near":
        """Those cells, of some, that come near boxes: (P, 3) centres in the world, middles and extents."""
        radius = float(np.linalg.norm(cells.half[some], axis=1).max(initial=0.0))
        origin = centres.mean(axis=0)
        places, offset = np.ascontiguousarray((cells.centre[some] - origin).T), centres - origin
        close, local = np.ones((len(poses), len(some)), dtype=np.bool_), []
        for axis in range(3):
            direction = poses[:, :3, axis]
            aside = direction @ places
            aside -= np.sum(direction * offset, axis=1)[:, None]
            local.append(aside)
            close &= np.abs(aside) < (extent[:, axis] + radius)[:, None]
        hand, column = np.nonzero(close)
        turns, sizes, cell = np.abs(poses[:, :3, :3]), cells.half[some[column]], some[column]
        half = np.stack([np.einsum("ij,ij->i", sizes, turns[hand, :, axis]) for axis in range(3)])
        centre = np.stack([values[hand, column] for values in local]) + middle[hand].T
        return _Near(cells, poses, hand, cell, centre, half)

    def forget(self, met: BoolArray) -> None:
        """Leave out what is settled: hands (P) that meet clouds (K)."""
        keep = ~met[self.hand, self.cells.owner[self.cell]]
        self.hand, self.cell = self.hand[keep], self.cell[keep]
        self.centre, self.half = self.centre[:, keep], self.half[:, keep]

    def count(self, region: Region, rows: IntArray, stray: int | None) -> IntArray:
        """Points (P, K) of each cloud in a region of the hands `rows`; beyond a stray few some may lack."""
        middle = (region.lower[rows] + region.upper[rows]) / 2.0
        extent = (region.upper[rows] - region.lower[rows]) / 2.0
        cut, inside = np.arange(len(self.hand)), np.full(len(self.hand), np.isinf(region.radius))
        for axis in range(3):
            hand = self.hand[cut]
            away = np.abs(self.centre[axis, cut] - middle[hand, axis]) - extent[hand, axis]
            half = self.half[axis, cut] + ROUNDING
            close = away < half
            inside = (inside & (away < -half))[close]
            cut = cut[close]
        key = self.hand[cut] * self.cells.clouds + self.cells.owner[self.cell[cut]]
        shape = len(self.poses), self.cells.clouds
        total = np.zeros(shape[0] * shape[1], dtype=np.int64)
        np.add.at(total, key[inside], self.cells.size[self.cell[cut[inside]]])
        left = ~inside if stray is None else ~inside & (total[key] <= stray)
        sizes = self.cells.size[self.cell[cut[left]]]
        begin = self.cells.first[self.cell[cut[left]]] - np.cumsum(sizes) + sizes
        points = self.cells.points[np.repeat(begin, sizes) + np.arange(sizes.sum())]
        hand, key = np.repeat(self.hand[cut[left]], sizes), np.repeat(key[left], sizes)
        aside = np.zeros(len(points))
        for axis in range(3):
            direction, origin = self.poses[:, :3, axis], self.poses[:, :3, 3]
            offset = np.einsum("ij,ij->i", points - origin[hand], direction[hand])
            within = (offset > region.lower[rows, axis][hand]) & (offset < region.upper[rows, axis][hand])
            aside = aside[within] + offset[within] ** 2 * (axis < 2)
            points, hand, key = points[within], hand[within], key[within]
        key = key[aside < region.radius**2]
        return (total + np.bincount(key, minlength=len(total))).reshape(shape)
