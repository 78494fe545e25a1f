"""A table that answers "surely inside" for most points of a convex body, however many facets it has.

Around a centre inside, the body is the unit ball of a gauge g(x) = max_k n_k.x / -d_k, convex and positively
homogeneous. On one face of a cube around the centre, g(1, s, t) is convex in (s, t), so between the
corners of a grid cell it is at most their bilinear interpolation, and a point where that bound is
at most 1 is inside. The bound is off by the square of the cell size, so that few points stay undecided.
"""

from dataclasses import dataclass

import numpy as np

from topple.topology.base.arrays import BoolArray, FloatArray

CELLS = 16
"""Grid cells along an edge of the cube: 1734 corners; on a ball of 4 cm the bound is off by 0.1 mm."""
BLOCK = 1 << 18
"""Numbers a table may hold at once (2 MB)."""
POINTS = 1 << 13
"""Points bounded at once: a dozen rows of so many numbers stay in a core's own cache."""
ROUNDING = 1e-12
"""Relative slack that keeps points exactly on the boundary on the chosen side."""


def _grid_directions() -> FloatArray:
    """(6 * (CELLS + 1)², 3) corners of the grid on the cube's six faces at distance 1."""
    ticks = np.linspace(-1.0, 1.0, CELLS + 1)
    s, t = np.meshgrid(ticks, ticks, indexing="ij")
    directions = np.empty((6, CELLS + 1, CELLS + 1, 3))
    for face in range(6):
        axis = face % 3
        directions[face, ..., axis] = 1.0 if face < 3 else -1.0
        directions[face, ..., (axis + 1) % 3] = s
        directions[face, ..., (axis + 2) % 3] = t
    return directions.reshape(-1, 3)


_DIRECTIONS = _grid_directions()


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
        corners = np.empty(len(_DIRECTIONS))
        step = max(64, BLOCK // len(scaled))
        for start in range(0, len(corners), step):
            # Facets along the first axis: the maximum then runs over whole rows at once.
            table = scaled @ _DIRECTIONS[start : start + step].T
            table.max(axis=0, out=corners[start : start + step])
        return Gauge(centre, corners)

    def surely_inside(self, columns: FloatArray) -> BoolArray:
        """Whether the bound puts a point inside the body or on its boundary.

        Args:
            columns: (3, N) coordinates of points [m], each axis contiguous.

        Returns:
            (N,) True: the point is inside, up to rounding. False: not decided.
        """
        return self.bound(columns) <= 1 + ROUNDING

    def bound(self, columns: FloatArray) -> FloatArray:
        """Upper bounds of the gauge.

        Args:
            columns: (3, N) coordinates of points [m], each axis contiguous.

        Returns:
            (N,) bounds: at most 1 only inside, and 1 on the boundary where the body is flat or at a corner.
        """
        bound = np.empty(columns.shape[1])
        for start in range(0, len(bound), POINTS):
            local = columns[:, start : start + POINTS] - self.centre[:, None]
            bound[start : start + POINTS] = self._bound(local)
        return bound

    def _bound(self, local: FloatArray) -> FloatArray:
        """(N,) upper bounds of the gauge at points (3, N) relative to the centre."""
        columns = local
        sizes = np.abs(local)
        bound = np.empty(local.shape[1])
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
