"""A table that answers "surely inside" for most points of a convex body, however many facets it has.

Around a centre inside, the body is the unit ball of a gauge g(x) = max_k n_k.x / -d_k, convex and positively
homogeneous. On one face of a cube around the centre, g(1, s, t) is convex in (s, t), so between the
corners of a grid cell it is at most their bilinear interpolation, and a point where that bound is
at most 1 is inside. The bound is off by the square of the cell size, so that few points stay undecided.
"""

from dataclasses import dataclass

import numpy as np

from topple.topology.arrays import BoolArray, FloatArray

CELLS = 24
"""Grid cells along an edge of the cube: 3750 corners, about 1 ms to fill per 100 facets."""
ROUNDING = 1e-12
"""Relative slack that keeps points exactly on the boundary on the chosen side."""


@dataclass(frozen=True, eq=False)
class Gauge:
    """Upper bounds of a convex body's gauge.

    Attributes:
        centre: (3,) a point inside the body [m].
        corners: Gauge at the grid corners of the cube's six faces at distance 1, (6 * (CELLS + 1)²,) [1/m].
    """

    centre: FloatArray
    corners: FloatArray

    @staticmethod
    def of(normals: FloatArray, offsets: FloatArray, centre: FloatArray) -> "Gauge | None":
        """Tabulate the gauge of { x : normals @ x + offsets <= 0 }.

        Args:
            normals: (F, 3) outward unit normals of the facets.
            offsets: (F,) plane offsets [m].
            centre: (3,) point the rays start from [m].

        Returns:
            The table, or None where the centre is not inside.
        """
        depth = -(normals @ centre + offsets)
        if depth.min() <= 0:
            return None
        scaled = normals / depth[:, None]
        ticks = np.linspace(-1.0, 1.0, CELLS + 1)
        corners = np.empty((6, CELLS + 1, CELLS + 1))
        for face in range(6):
            axis, sign = face % 3, 1.0 if face < 3 else -1.0
            first, second = scaled[:, (axis + 1) % 3], scaled[:, (axis + 2) % 3]
            base = sign * scaled[:, axis]
            across = np.multiply.outer(ticks, second)
            for row, s in enumerate(ticks):
                corners[face, row] = (across + (base + s * first)).max(axis=1)
        return Gauge(centre, corners.ravel())

    def surely_inside(self, points: FloatArray) -> BoolArray:
        """Whether the bound puts a point inside the body or on its boundary.

        Args:
            points: (N, 3) points [m].

        Returns:
            (N,) True: the point is inside, up to rounding. False: not decided.
        """
        return self._bound(points - self.centre) <= 1 + ROUNDING

    def _bound(self, local: FloatArray) -> FloatArray:
        """(N,) upper bounds of the gauge at points relative to the centre."""
        columns = [np.ascontiguousarray(local[:, axis]) for axis in range(3)]
        sizes = [np.abs(column) for column in columns]
        bound = np.empty(len(local))
        first_wins = (sizes[0] >= sizes[1]) & (sizes[0] >= sizes[2])
        second_wins = ~first_wins & (sizes[1] >= sizes[2])
        for axis, chosen in enumerate((first_wins, second_wins, ~(first_wins | second_wins))):
            index = np.flatnonzero(chosen)
            major = sizes[axis][index]
            scale = CELLS / 2 / np.where(major > 0, major, 1.0)
            corner = np.where(columns[axis][index] < 0, 3 + axis, axis)
            fractions: list[FloatArray] = []
            for other in ((axis + 1) % 3, (axis + 2) % 3):
                tick = columns[other][index] * scale + CELLS / 2
                cell = np.minimum(tick.astype(np.int64), CELLS - 1)
                fractions.append(tick - cell)
                corner = corner * (CELLS + 1) + cell
            s, t = fractions
            near = self.corners[corner] + t * (self.corners[corner + 1] - self.corners[corner])
            corner += CELLS + 1
            far = self.corners[corner] + t * (self.corners[corner + 1] - self.corners[corner])
            bound[index] = major * (near + s * (far - near))
        return bound
