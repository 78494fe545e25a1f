"""An object's cloud as a surface to take hold of: thinned points, outward normals, centre of mass."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.spatial import ConvexHull, KDTree, QhullError

from topple.planner.grasp.tolerances import GRASP_TOLERANCES, GraspTolerances
from topple.topology.arrays import BoolArray, FloatArray


@dataclass(frozen=True, eq=False)
class Surface:
    """What is seen of an object, and after it what is inferred of its hidden sides.

    Attributes:
        points: (N, 3) points in the world, about one per `spacing` cube [m].
        normals: (N, 3) unit normals turned towards the cameras (or up).
        evenness: (N,) standard deviation of the points around the fitted plane [m].
        centre: (3,) estimate of the centre of mass [m].
        seen: The first so many points were seen.
    """

    points: FloatArray
    normals: FloatArray
    evenness: FloatArray
    centre: FloatArray
    seen: int


def voxel_means(points: FloatArray, spacing: float) -> FloatArray:
    """Replace the points of each cube of a grid by their mean, which also averages their noise.

    Args:
        points: (N, 3) points [m].
        spacing: Edge of the cubes [m].

    Returns:
        (M, 3) means, M <= N, in the order of the grid.
    """
    if len(points) == 0:
        return np.empty((0, 3))
    keys = np.floor((points - points.min(axis=0)) / spacing).astype(np.int64)
    span = keys.max(axis=0) + 1
    flat = (keys[:, 0] * span[1] + keys[:, 1]) * span[2] + keys[:, 2]
    _, inverse, counts = np.unique(flat, return_inverse=True, return_counts=True)
    inverse = inverse.reshape(-1)
    sums = np.stack([np.bincount(inverse, points[:, k], len(counts)) for k in range(3)], axis=1)
    return sums / counts[:, None]


def fitted_normals(
    points: FloatArray, radius: float, toward: FloatArray, least: int = 6, most: int = 48
) -> tuple[FloatArray, FloatArray]:
    """Fit a plane to every point's neighbourhood.

    Args:
        points: (N, 3) points [m].
        radius: Neighbourhood [m].
        toward: (N, 3) or (3,) directions into the free half space, which the normals are turned to.
        least: Points a neighbourhood has at least, taken from beyond the radius where it has fewer.
        most: Points it has at most.

    Returns:
        (N, 3) unit normals and (N,) standard deviations around the planes [m].
    """
    count = min(most, len(points))
    if count < 3:
        return np.tile(np.broadcast_to(toward, (len(points), 3)), 1), np.zeros(len(points))
    distances, index = KDTree(points).query(points, k=count)
    weights = (distances <= radius).astype(np.float64)
    weights[:, : min(least, count)] = 1.0
    near = points[index]
    total = weights.sum(axis=1)
    centred = near - ((weights[:, :, None] * near).sum(axis=1) / total[:, None])[:, None, :]
    covariance = np.einsum("nk,nki,nkj->nij", weights, centred, centred) / total[:, None, None]
    values, vectors = np.linalg.eigh(covariance)
    normals = vectors[:, :, 0]
    flip = np.einsum("ni,ni->n", normals, np.broadcast_to(toward, normals.shape)) < 0
    normals[flip] *= -1.0
    return normals, np.sqrt(np.maximum(values[:, 0], 0.0))


def surface_of(
    points: FloatArray,
    up: FloatArray,
    viewpoints: FloatArray | None = None,
    solid: Sequence[FloatArray] = (),
    others: FloatArray | None = None,
    tolerances: GraspTolerances = GRASP_TOLERANCES,
) -> Surface:
    """Prepare an object's cloud for the grasp search.

    Args:
        points: (N, 3) the object's cloud in the world [m].
        up: (3,) unit vector against gravity.
        viewpoints: (k, 3) camera centres; normals then face the nearest of them, else away from the cloud's
            middle.
        solid: Convex parts of the object: for its centre of mass, and for the sides no camera could see.
        others: (M, 3) points of what else may hide a side from the cameras [m].
        tolerances: Spacing and neighbourhood.

    Returns:
        The surface. Deterministic.
    """
    thin = voxel_means(points, tolerances.spacing)
    middle = thin.mean(axis=0) - 0.02 * up  # a little below what is seen: undersides are not
    toward = thin - middle
    if viewpoints is not None and len(viewpoints) > 0:
        rays = viewpoints[None, :, :] - thin[:, None, :]
        nearest = np.argmin(np.linalg.norm(rays, axis=2), axis=1)
        toward = rays[np.arange(len(thin)), nearest]
    normals, evenness = fitted_normals(thin, tolerances.normal_radius, toward)
    hidden, hidden_normals = _hidden(thin, solid, viewpoints, others, tolerances)
    return Surface(
        np.vstack([thin, hidden]),
        np.vstack([normals, hidden_normals]),
        np.concatenate([evenness, np.zeros(len(hidden))]),
        centre_of_mass(thin, solid),
        len(thin),
    )


def _hidden(
    seen: FloatArray,
    solid: Sequence[FloatArray],
    viewpoints: FloatArray | None,
    others: FloatArray | None,
    tolerances: GraspTolerances,
) -> tuple[FloatArray, FloatArray]:
    """Points and normals of the sides nobody saw: of the convex parts, where no camera looked through."""
    if viewpoints is None or len(viewpoints) == 0:
        return np.empty((0, 3)), np.empty((0, 3))  # a scanned or modelled object: all of it is seen
    points, normals = sampled_with_normals(solid, tolerances.hidden_spacing)
    if len(points) == 0:
        return points, normals
    distance, _ = KDTree(seen).query(points, distance_upper_bound=tolerances.hidden_gap)
    unseen = np.isinf(distance)
    occluders = seen if others is None else np.vstack([seen, others])
    for viewpoint in viewpoints:
        unseen &= _shadowed(points, occluders, viewpoint, tolerances.hidden_gap)
    return points[unseen], normals[unseen]


def sampled(solid: Sequence[FloatArray], spacing: float) -> FloatArray:
    """Points (N, 3) spread over the surfaces of convex parts, about `spacing` [m] apart."""
    return sampled_with_normals(solid, spacing)[0]


def sampled_with_normals(solid: Sequence[FloatArray], spacing: float) -> tuple[FloatArray, FloatArray]:
    """Points spread over the surfaces of convex parts.

    Args:
        solid: (V, 3) vertices of each part [m].
        spacing: About how far apart [m].

    Returns:
        (N, 3) points and their (N, 3) outward unit normals; none of parts without volume.
    """
    points, normals = [np.empty((0, 3))], [np.empty((0, 3))]
    for part in solid:
        try:
            hull = ConvexHull(part, qhull_options="QJ Pp")
        except (QhullError, ValueError):
            continue
        for corners, equation in zip(part[hull.simplices], hull.equations, strict=True):
            samples = _triangle_grid(corners, spacing)
            points.append(samples)
            normals.append(np.tile(equation[:3], (len(samples), 1)))
    return np.vstack(points), np.vstack(normals)


def _shadowed(points: FloatArray, occluders: FloatArray, viewpoint: FloatArray, gap: float) -> BoolArray:
    """Which points a camera cannot see because an occluder stands within `gap` of the ray, nearer to it."""
    rays, seen = points - viewpoint, occluders - viewpoint
    far, near = np.linalg.norm(rays, axis=1), np.linalg.norm(seen, axis=1)
    tree = KDTree(seen / near[:, None])
    angle = gap / float(np.median(far))
    _, index = tree.query(rays / far[:, None], k=min(8, len(occluders)), distance_upper_bound=angle)
    index = index.reshape(len(points), -1)
    padded = np.append(near, np.inf)
    return padded[index].min(axis=1) < far - 0.5 * gap


def _triangle_grid(corners: FloatArray, spacing: float) -> FloatArray:
    """Points spread evenly over a (3, 3) triangle, its corners' neighbourhood included."""
    longest = float(np.linalg.norm(corners - np.roll(corners, 1, axis=0), axis=1).max())
    steps = max(1, int(np.ceil(longest / spacing)))
    i, j = np.meshgrid(np.arange(steps), np.arange(steps), indexing="ij")
    u, v = (i + 1.0 / 3.0) / steps, (j + 1.0 / 3.0) / steps
    inside = u + v < 1.0
    return (
        corners[0]
        + np.outer(u[inside], corners[1] - corners[0])
        + np.outer(v[inside], corners[2] - corners[0])
    )


def centre_of_mass(points: FloatArray, solid: Sequence[FloatArray] = ()) -> FloatArray:
    """Estimate where an object's mass is, its density taken as even.

    Args:
        points: (N, 3) points of its surface [m].
        solid: Its convex parts, weighed by their volume; empty for none.

    Returns:
        (3,) the parts' common centre of volume, or the mean of the points where there is no volume.
    """
    volumes, centres = [], []
    for part in solid:
        try:
            hull = ConvexHull(part, qhull_options="QJ Pp")
        except (QhullError, ValueError):
            continue
        inner = part.mean(axis=0)
        corners = part[hull.simplices]
        pieces = np.abs(np.linalg.det(corners - inner)) / 6.0
        if pieces.sum() > 0:
            volumes.append(float(pieces.sum()))
            centres.append((pieces[:, None] * (corners.sum(axis=1) + inner) / 4.0).sum(axis=0) / pieces.sum())
    if not volumes:
        return points.mean(axis=0)
    return np.average(np.array(centres), axis=0, weights=volumes)
