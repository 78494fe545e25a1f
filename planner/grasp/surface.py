"""An object's cloud as a surface to take hold of: thinned points, outward normals, centre of mass."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from topple.planner.grasp.surroundings import Surroundings
from topple.planner.grasp.tolerances import GRASP_TOLERANCES
from topple.topology.base.arrays import BoolArray, FloatArray
from topple.topology.geometry.samples import sampled_with_normals, volume_and_centre
from topple.topology.geometry.thin import voxel_means
from topple.topology.kernels.neighbours import PointTree
from topple.topology.situation.situation import Situation
from topple.topology.views.image import DepthImage


@dataclass(frozen=True, eq=False)
class Surface:
    """What is seen of an object, and after it what is inferred of its hidden sides.

    Attributes:
        points: (N, 3) points in the world, about one per `spacing` cube [m].
        normals: (N, 3) unit normals turned towards the cameras (or up).
        centre: (3,) estimate of the centre of mass [m].
        seen: The first so many points were seen.
        volume: What its convex parts fill [m3]; 0 where there are none.
        mass: In [kg] where it was weighed.
    """

    points: FloatArray
    normals: FloatArray
    centre: FloatArray
    seen: int
    volume: float = 0.0
    mass: float | None = None


def fitted_normals(
    points: FloatArray, radius: float, toward: FloatArray, least: int = 6, most: int = 48
) -> FloatArray:
    """Fit a plane to every point's neighbourhood.

    Args:
        points: (N, 3) points [m].
        radius: Neighbourhood [m].
        toward: (N, 3) or (3,) directions into the free half space, which the normals are turned to.
        least: Points a neighbourhood has at least, taken from beyond the radius where it has fewer.
        most: Points it has at most.

    Returns:
        (N, 3) unit normals.
    """
    count = min(most, len(points))
    if count < 3:
        return np.tile(np.broadcast_to(toward, (len(points), 3)), 1)
    distances, index = PointTree(points).query(points, k=count)
    weights = (distances <= radius).astype(np.float64)
    weights[:, : min(least, count)] = 1.0
    near = points[index]
    total = weights.sum(axis=1)
    centred = near - ((weights[:, :, None] * near).sum(axis=1) / total[:, None])[:, None, :]
    covariance = np.einsum("nk,nki,nkj->nij", weights, centred, centred) / total[:, None, None]
    normals = np.linalg.eigh(covariance)[1][:, :, 0]
    flip = np.einsum("ni,ni->n", normals, np.broadcast_to(toward, normals.shape)) < 0
    normals[flip] *= -1.0
    return normals


def surface_of(
    points: FloatArray,
    up: FloatArray,
    viewpoints: FloatArray | None = None,
    solid: Sequence[FloatArray] = (),
    others: FloatArray | None = None,
    images: Sequence[DepthImage] = (),
) -> Surface:
    """Prepare an object's cloud for the grasp search.

    Args:
        points: (N, 3) the object's cloud in the world [m].
        up: (3,) unit vector against gravity.
        viewpoints: (k, 3) camera centres; normals then face the nearest of them, else away from the cloud's
            middle.
        solid: Convex parts of the object: for its volume, its centre of mass, and the sides no camera could
            see.
        others: (M, 3) points of what else may hide a side from the cameras [m].
        images: What the cameras took: a side out of their view was not seen, either.

    Returns:
        The surface. Deterministic.
    """
    thin = voxel_means(points, GRASP_TOLERANCES.spacing, ahead=0.0)
    middle = thin.mean(axis=0) - 0.02 * up  # a little below what is seen: undersides are not
    toward = thin - middle
    if viewpoints is not None and len(viewpoints) > 0:
        rays = viewpoints[None, :, :] - thin[:, None, :]
        nearest = np.argmin(np.linalg.norm(rays, axis=2), axis=1)
        toward = rays[np.arange(len(thin)), nearest]
    normals = fitted_normals(thin, GRASP_TOLERANCES.normal_radius, toward)
    hidden, hidden_normals = _hidden_points(thin, solid, viewpoints, others, images)
    volume, centre = volume_and_centre(thin, solid)
    return Surface(
        np.vstack([thin, hidden]),
        np.vstack([normals, hidden_normals]),
        centre,
        len(thin),
        volume,
    )


def surface_in(name: str, situation: Situation, around: Surroundings) -> Surface:
    """Prepare an object of a situation, among its surroundings, for the grasp search."""
    scene = situation.scene
    viewpoints = None if name in scene.whole else scene.viewpoints
    solid, cloud = situation.completed[name], scene.clouds[name]
    return surface_of(cloud, situation.up, viewpoints, solid, around.points, scene.images)


def _hidden_points(
    seen: FloatArray,
    solid: Sequence[FloatArray],
    viewpoints: FloatArray | None,
    others: FloatArray | None,
    images: Sequence[DepthImage],
) -> tuple[FloatArray, FloatArray]:
    """Points and normals of the hidden sides: of the convex parts, where no camera looked through."""
    if viewpoints is None or len(viewpoints) == 0:
        return np.empty((0, 3)), np.empty((0, 3))  # a scanned or modelled object: all of it is seen
    points, normals = sampled_with_normals(solid, GRASP_TOLERANCES.hidden_spacing)
    if len(points) == 0:
        return points, normals
    distance, _ = PointTree(seen).query(points, distance_upper_bound=GRASP_TOLERANCES.hidden_gap)
    unseen = np.isinf(distance)
    occluders = seen if others is None else np.vstack([seen, others])
    pictures = images if len(images) == len(viewpoints) else [None] * len(viewpoints)
    for viewpoint, picture in zip(viewpoints, pictures, strict=True):
        in_view = True if picture is None else picture.in_view(points)
        unseen &= _in_shadow(points, occluders, viewpoint, GRASP_TOLERANCES.hidden_gap) | ~np.bool_(in_view)
    return points[unseen], normals[unseen]


def _in_shadow(points: FloatArray, occluders: FloatArray, viewpoint: FloatArray, gap: float) -> BoolArray:
    """Which points a camera cannot see because an occluder stands within `gap` of the ray, nearer to it."""
    rays, seen = points - viewpoint, occluders - viewpoint
    far, near = np.linalg.norm(rays, axis=1), np.linalg.norm(seen, axis=1)
    tree = PointTree(seen / near[:, None])
    angle = gap / float(np.median(far))
    _, index = tree.query(rays / far[:, None], k=min(8, len(occluders)), distance_upper_bound=angle)
    index = index.reshape(len(points), -1)
    padded = np.append(near, np.inf)
    return padded[index].min(axis=1) < far - 0.5 * gap
