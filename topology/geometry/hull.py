"""The convex hull of a cloud, the paper's boundary ∂A (Definition 1), for every cloud there is."""

from dataclasses import dataclass

import numpy as np
from scipy.spatial import ConvexHull, QhullError

from topple.topology.base.arrays import FloatArray, IntArray, bounds, freeze, frozen_int
from topple.topology.base.errors import InvalidInput
from topple.topology.base.tolerances import TOLERANCES
from topple.topology.base.values import ByValue
from topple.topology.geometry.axes import cross, own_axes
from topple.topology.geometry.extremes import without_inner_points

BLOCK = 1 << 16
"""Numbers a distance table may hold at once (0.5 MB): it stays in a core's own cache for any cloud."""


@dataclass(frozen=True, eq=False)
class Hull(ByValue):
    """The smallest convex set that contains a cloud; flat, collinear and single-point clouds have one too.

    The hull is the set of x with `normals @ x + offsets <= 0`. A hull without extent along some axes is
    bounded there by pairs of opposite half-spaces, so that the same facet test holds for every hull.

    Attributes:
        vertices: (V, 3) corners [m], read-only.
        faces: (T, 3) indices into `vertices` of triangles that cover the boundary, empty below
            dimension 2; one-sided for a flat hull.
        normals: (F, 3) outward unit normals of the distinct facet planes.
        offsets: (F,) plane offsets [m].
        lower: (3,) least corner of the axis-aligned box [m].
        upper: (3,) greatest corner of the axis-aligned box [m].
        dimension: 3 for a solid hull, 2 flat, 1 a segment, 0 a point.
        volume: Enclosed volume [m³], 0 below dimension 3.

    Examples:
        >>> hull = Hull.of(scene.clouds["cup"])
        >>> round(1e6 * hull.volume)  # ml
        288
        >>> hull.signed_distance(np.array([[0.5, 0, 0.08]])).round(3)
        array([-0.03])
    """

    vertices: FloatArray
    faces: IntArray
    normals: FloatArray
    offsets: FloatArray
    lower: FloatArray
    upper: FloatArray
    dimension: int
    volume: float

    @staticmethod
    def of(points: FloatArray) -> "Hull":
        """Build the hull of a cloud.

        Args:
            points: (N, 3) points [m], N >= 1, finite; duplicates are allowed.

        Returns:
            The hull, exact up to float64 rounding.

        Raises:
            InvalidInput: The array is no (N, 3) array of finite numbers with N >= 1.
        """
        points = np.asarray(points, dtype=np.float64)
        if points.ndim != 2 or points.shape[1] != 3 or len(points) == 0:
            raise InvalidInput(f"a hull needs finite points (N, 3), N >= 1, got an array {points.shape}")
        columns = np.array(points.T, order="C")  # a copy, axis by axis: many times faster than row by row
        lower, upper = columns.min(axis=1), columns.max(axis=1)
        if not (np.isfinite(lower).all() and np.isfinite(upper).all()):  # both pass NaN on
            raise InvalidInput(f"a hull needs finite points, got NaN or infinity among {len(points)}")
        centre = (lower + upper) / 2
        columns -= centre[:, None]
        axes, dimension = _extent_axes(columns.T)
        if dimension == 3:
            try:
                return _solid(without_inner_points(columns), centre, lower, upper)
            except QhullError:  # thinner than Qhull can tell apart at this scale: treat it as flat
                dimension = 2
        return _degenerate(columns.T, centre, axes, dimension, lower, upper)

    def facet_distance(self, points: FloatArray) -> FloatArray:
        """Largest directed distance to a facet plane, the paper's d of equation (2) maximised over k.

        Args:
            points: (N, 3) points [m].

        Returns:
            (N,) metres, negative inside. Outside it never exceeds the Euclidean distance, and near a
            sharp edge it is much smaller.
        """
        distance = np.empty(len(points))
        step = max(1, BLOCK // len(self.normals))
        offsets = self.offsets[:, None]
        for start in range(0, len(points), step):
            table = self.normals @ points[start : start + step].T  # facets first: see Gauge.of
            table += offsets
            table.max(axis=0, out=distance[start : start + step])
        return distance

    def signed_distance(self, points: FloatArray) -> FloatArray:
        """Euclidean distance to the hull, negative by the depth below the nearest facet inside.

        Args:
            points: (N, 3) points [m].

        Returns:
            (N,) metres.
        """
        distance = np.empty(len(points))
        step = max(1, BLOCK // len(self.normals))
        triangles = self.vertices[self.faces]
        for start in range(0, len(points), step):
            block = points[start : start + step]
            nearest = self.facet_distance(block)
            outside = np.flatnonzero(nearest > 0)
            if len(outside):
                nearest[outside] = self._distance_outside(block[outside], triangles)
            distance[start : start + step] = nearest
        return distance

    def spread(self, count: int) -> FloatArray:
        """Places spread evenly over the boundary, the same ones in whatever frame the hull is.

        Args:
            count: How many places.

        Returns:
            (count, 3) places [m]; the corners of a hull without faces.
        """
        if len(self.faces) == 0:
            return self.vertices
        axes = own_axes(self.vertices)
        first = (self.vertices @ axes[0])[self.faces].argmin(axis=1)[:, None]
        corners = self.vertices[np.take_along_axis(self.faces, (first + np.arange(3)) % 3, axis=1)]
        across = cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        area = np.linalg.norm(across, axis=1)
        # Plane after plane: of four corners in one plane Qhull may join either two.
        order = np.argsort(across @ axes[0] / np.maximum(area, 1e-300), kind="stable")
        corners, area = corners[order], area[order]
        number = np.arange(count)
        face = np.searchsorted(np.cumsum(area) / area.sum(), (number + 0.5) / count).clip(max=len(area) - 1)
        # A low-discrepancy sequence, folded from the unit square into the triangle by the square root.
        u, v = np.sqrt((number * 0.7548776662466927) % 1), (number * 0.5698402909980532) % 1
        weights = np.stack([1 - u, u * (1 - v), u * v], axis=1)
        return np.einsum("sk,skj->sj", weights, corners[face])

    def _distance_outside(self, points: FloatArray, triangles: FloatArray) -> FloatArray:
        """Euclidean distance of points outside: to the point, the segment or the triangles."""
        if self.dimension == 0:
            return np.linalg.norm(points - self.vertices[0], axis=1)
        if self.dimension == 1:
            return _segment_distance(points, self.vertices[0], self.vertices[1])
        distance = np.empty(len(points))
        step = max(1, BLOCK // (8 * len(triangles)))
        for start in range(0, len(points), step):
            block = points[start : start + step]
            distance[start : start + step] = _triangle_distance(block, triangles).min(axis=1)
        return distance


def _extent_axes(local: FloatArray) -> tuple[FloatArray, int]:
    """Principal axes (rows, widest first) of a centred cloud and the number with any extent."""
    few = local[:: max(1, len(local) // 500)]
    axes, extent = _principal(few)
    if extent[2] <= 1e3 * TOLERANCES.flat:  # a few points settle most clouds, but not a thin one
        axes, extent = _principal(local)
    flat = max(TOLERANCES.flat, 1e-9 * float(extent[0]))
    return axes, int(np.count_nonzero(extent > flat))


def _principal(local: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Principal axes (rows, widest first) and the extent along each."""
    spread = local - local.mean(axis=0)
    _, vectors = np.linalg.eigh(spread.T @ spread)
    axes = vectors.T[::-1]
    lower, upper = bounds(local @ axes.T)
    return axes, upper - lower


def _solid(local: FloatArray, centre: FloatArray, lower: FloatArray, upper: FloatArray) -> Hull:
    qhull = ConvexHull(local)
    # Qhull splits a facet into triangles and repeats its plane: keep one of each set of neighbours.
    same = (qhull.equations[qhull.neighbors] == qhull.equations[:, None]).all(axis=2)
    repeated = (same & (qhull.neighbors < np.arange(len(same))[:, None])).any(axis=1)
    equations = qhull.equations[~repeated]
    index = np.empty(len(local), dtype=np.int64)
    index[qhull.vertices] = np.arange(len(qhull.vertices))
    faces = index[qhull.simplices]
    vertices = local[qhull.vertices]
    corner, second, third = (vertices[faces[:, i]] for i in range(3))
    turned = np.einsum("ij,ij->i", cross(second - corner, third - corner), qhull.equations[:, :3]) < 0
    faces[turned] = faces[turned][:, [0, 2, 1]]
    return Hull(
        vertices=freeze(vertices + centre),
        faces=frozen_int(faces),
        normals=freeze(equations[:, :3]),
        offsets=freeze(equations[:, 3] - equations[:, :3] @ centre),
        lower=freeze(lower),
        upper=freeze(upper),
        dimension=3,
        volume=float(qhull.volume),
    )


def _degenerate(
    local: FloatArray,
    centre: FloatArray,
    axes: FloatArray,
    dimension: int,
    lower: FloatArray,
    upper: FloatArray,
) -> Hull:
    """Hull of a cloud without extent along `axes[dimension:]`."""
    along = local @ axes.T
    faces = np.zeros((0, 3), dtype=np.int64)
    normals, offsets = [np.zeros((0, 3))], [np.zeros(0)]
    if dimension == 2:
        flat = ConvexHull(along[:, :2])
        chosen = flat.vertices  # counter-clockwise, so a fan covers the polygon
        fan = np.arange(1, len(chosen) - 1)
        faces = np.stack([np.zeros_like(fan), fan, fan + 1], axis=1)
        normals.append(flat.equations[:, :2] @ axes[:2])
        offsets.append(flat.equations[:, 2])
    elif dimension == 1:
        chosen = np.array([along[:, 0].argmin(), along[:, 0].argmax()])
    else:
        chosen = np.array([0])
    # Opposite planes close the hull along the remaining axes, and along a segment's own.
    for axis in range(0 if dimension < 2 else 2, 3):
        normals.append(np.stack([axes[axis], -axes[axis]]))
        offsets.append(np.array([-along[:, axis].max(), along[:, axis].min()]))
    all_normals = np.concatenate(normals)
    return Hull(
        vertices=freeze(local[chosen] + centre),
        faces=frozen_int(faces),
        normals=freeze(all_normals),
        offsets=freeze(np.concatenate(offsets) - all_normals @ centre),
        lower=freeze(lower),
        upper=freeze(upper),
        dimension=dimension,
        volume=0.0,
    )


def _segment_distance(points: FloatArray, start: FloatArray, end: FloatArray) -> FloatArray:
    """Distance of (N, 3) points to the segment between two points."""
    direction = end - start
    along = np.clip((points - start) @ direction / (direction @ direction), 0.0, 1.0)
    return np.linalg.norm(points - start - along[:, None] * direction, axis=1)


def _triangle_distance(points: FloatArray, triangles: FloatArray) -> FloatArray:
    """Distance of (N, 3) points to (T, 3, 3) triangles, (N, T)."""
    origin = triangles[:, 0]
    edges = np.roll(triangles, -1, axis=1) - triangles
    normal = cross(edges[:, 0], edges[:, 1])
    length = np.linalg.norm(normal, axis=1)
    normal = normal / np.where(length > 0, length, 1.0)[:, None]
    squared = np.full((len(points), len(triangles)), np.inf)
    inside = np.broadcast_to(length > 0, squared.shape).copy()
    for side in range(3):
        edge = edges[:, side]
        offset = points[:, None] - triangles[:, side]
        inward = cross(normal, edge)
        inside &= np.einsum("ntj,tj->nt", offset, inward) >= 0
        norm = np.einsum("tj,tj->t", edge, edge)
        along = np.einsum("ntj,tj->nt", offset, edge) / np.where(norm > 0, norm, 1.0)
        offset -= np.clip(along, 0.0, 1.0)[..., None] * edge
        np.minimum(squared, np.einsum("ntj,ntj->nt", offset, offset), out=squared)
    height = np.abs(points @ normal.T - np.einsum("tj,tj->t", origin, normal))
    return np.where(inside, height, np.sqrt(squared))
