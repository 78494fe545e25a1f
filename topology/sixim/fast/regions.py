"""Interior, boundary and exterior of a hull, counted without trying every facet for every point."""

import numpy as np

from topple.topology.base.arrays import BoolArray, FloatArray, IntArray
from topple.topology.geometry.gauge import Gauge
from topple.topology.geometry.hull import BLOCK, Hull

PROBES = 24
"""Points whose furthest facets are tried first: a handful of facets bars the way to most points."""
WORTH_A_TABLE = 2_000_000
"""Facet distances above which a gauge table (about 1 ms per 100 facets) pays for itself."""


class Regions:
    """Interior, boundary and exterior of one hull at one deviation, prepared for many points.

    Exact like `topple.topology.sixim.plain.counts`. Most points are settled by a few facets that bar their
    way or by a table of the hull enlarged and shrunk by δ; only the rest is tested against every facet.
    """

    def __init__(self, hull: Hull, deviation: float) -> None:
        """Prepare a hull; the tables are made when first needed.

        Args:
            hull: The hull.
            deviation: The deviation factor δ [m], > 0.
        """
        self.hull = hull
        self.deviation = deviation
        self._tables: tuple[Gauge | None, Gauge | None] | None = None

    def counts(self, points: FloatArray) -> IntArray:
        """Count points in the interior, on the boundary and in the exterior.

        Args:
            points: (N, 3) points [m].

        Returns:
            (3,) counts (interior, boundary, exterior).
        """
        columns = points.T
        near = np.flatnonzero(
            in_box(columns, self.hull.lower - self.deviation, self.hull.upper + self.deviation)
        )
        interior, boundary = self._inner_counts(columns[:, near]) if len(near) else (0, 0)
        return np.array([interior, boundary, len(points) - interior - boundary], dtype=np.int64)

    def holds(self, near: FloatArray) -> bool:
        """Whether a point lies in the interior.

        Args:
            near: (3, N) points in the box of the hull [m].
        """
        return near.shape[1] > 0 and bool((self._not_barred(near, -self.deviation) < -self.deviation).any())

    def meets(self, near: FloatArray) -> bool:
        """Whether a point lies in the interior or on the boundary.

        Args:
            near: (3, N) points in the box of the hull, enlarged by δ [m].
        """
        return near.shape[1] > 0 and bool((self._not_barred(near, self.deviation) <= self.deviation).any())

    def _not_barred(self, near: FloatArray, limit: float) -> FloatArray:
        """Facet distances of the points (3, N) that the barring facets leave within a limit."""
        kept = np.flatnonzero(self._beyond_barring(near) <= limit)
        return self.hull.facet_distance(near[:, kept].T)

    def _beyond_barring(self, near: FloatArray) -> FloatArray:
        """(N,) largest directed distance of points (3, N) to a few facets that bar the way to most."""
        hull, first = self.hull, self._barring_facets(near)
        furthest = np.empty(near.shape[1])
        step = max(256, BLOCK // len(first))
        for start in range(0, len(furthest), step):
            table = hull.normals[first] @ near[:, start : start + step]
            table += hull.offsets[first][:, None]
            table.max(axis=0, out=furthest[start : start + step])
        return furthest

    def _inner_counts(self, near: FloatArray) -> tuple[int, int]:
        """(interior, boundary) counts of points (3, N) in the enlarged box."""
        hull, deviation = self.hull, self.deviation
        furthest = self._beyond_barring(near)
        kept = np.flatnonzero(furthest <= deviation)
        left, on_boundary = near[:, kept], furthest[kept] >= -deviation
        interior = boundary = 0
        if left.shape[1] * len(hull.normals) > WORTH_A_TABLE:
            enlarged, shrunk = self._gauges()
            # A point that reaches a facet's layer is on the boundary if no other facet shuts it out.
            inside = self._surely(enlarged, left) & on_boundary
            boundary = int(np.count_nonzero(inside))
            left, on_boundary = left[:, ~inside], on_boundary[~inside]
            deep = self._surely(shrunk, left) & ~on_boundary
            interior = int(np.count_nonzero(deep))
            left = left[:, ~deep]
        distance = hull.facet_distance(left.T)
        found = int(np.count_nonzero(distance < -deviation))
        return interior + found, boundary + int(np.count_nonzero(distance <= deviation)) - found

    def _barring_facets(self, near: FloatArray) -> IntArray:
        """The facets that a spread of the points is furthest out of."""
        probes = near[:, :: -(-near.shape[1] // PROBES)]
        table = self.hull.normals @ probes
        table += self.hull.offsets[:, None]
        return np.unique(table.argmax(axis=0))

    def _gauges(self) -> tuple[Gauge | None, Gauge | None]:
        """Tables of the hull enlarged and shrunk by δ."""
        if self._tables is None:
            normals, offsets = self.hull.normals, self.hull.offsets
            centre = self.hull.vertices.mean(axis=0)
            self._tables = (
                Gauge.of(normals, offsets - self.deviation, centre),
                Gauge.of(normals, offsets + self.deviation, centre),
            )
        return self._tables

    @staticmethod
    def _surely(gauge: Gauge | None, columns: FloatArray) -> BoolArray:
        return np.zeros(columns.shape[1], dtype=np.bool_) if gauge is None else gauge.surely_inside(columns)


def in_box(columns: FloatArray, lower: FloatArray, upper: FloatArray) -> BoolArray:
    """Which points lie in a box or on its boundary.

    Args:
        columns: (3, N) points [m], each axis contiguous.
        lower: (3,) least corner [m].
        upper: (3,) greatest corner [m].

    Returns:
        (N,) truth values.
    """
    inside = np.ones(columns.shape[1], dtype=np.bool_)
    for axis in range(3):
        inside &= columns[axis] >= lower[axis]
        inside &= columns[axis] <= upper[axis]
    return inside
