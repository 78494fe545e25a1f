"""One object's points: spacing, noise, the deviation they amount to, and strays."""

from collections.abc import Mapping

import numpy as np

from topple.topology.base.arrays import FloatArray, lengths, median_of, middle_of
from topple.topology.base.tolerances import (
    MOST_STRAYS,
    NEIGHBOURS,
    PROBES,
    REGION,
    STRAY,
    TOLERANCES,
    USUAL,
    USUAL_SIZES,
)
from topple.topology.kernels.cells import within_reach
from topple.topology.kernels.neighbours import PointTree
from topple.topology.kernels.planes import patch_planes
from topple.topology.scene.scene import Scene


def noise_and_spacing(points: FloatArray) -> tuple[float, float]:
    """Typical distance of a point from the plane through its neighbours, and from its fourth neighbour.

    Args:
        points: (N, 3) points [m] of a surface.

    Returns:
        The medians over probes of the RMS residual of the local plane and of the distance [m]; zeros for
        fewer than 6 points.
    """
    if len(points) < 6:
        return 0.0, 0.0
    if len(points) > REGION:
        place = points[len(points) // 2]
        some = np.sort(lengths(points[:: -(-len(points) // (2 * REGION))] - place))
        reach = some[len(some) * REGION // len(points)] * (1 + 1e-9)  # within it, too, as it may round
        near = within_reach(points, place, reach)
        points = points.take(np.flatnonzero(near), axis=0)
    probes = points[:: -(-len(points) // PROBES)]
    tree = PointTree(points)
    distance, index = tree.query(probes, k=min(NEIGHBOURS, len(points)))
    least = patch_planes(points[index])[2][:, 0]
    # A plane through k points takes three degrees of freedom from their residuals.
    noise = float(np.sqrt(median_of(least) / max(index.shape[1] - 3, 1)))
    return noise, median_of(distance[:, 4])


def estimate_deviation(scene: Scene | Mapping[str, FloatArray]) -> float:
    """Deviation factor δ of a scene, from the noise and the spacing of its clouds.

    Args:
        scene: A scene, or clouds (N, 3) [m] by name.

    Returns:
        The medians over the clouds of `noise_factor` times the noise and of the spacing, added as
        independent errors, within the least and greatest deviation [m]; for large things that is greater.
    """
    clouds = scene.clouds if isinstance(scene, Scene) else scene
    measured = np.array([noise_and_spacing(cloud) for cloud in clouds.values()]).reshape(-1, 2)
    noise, spacing = np.median(measured, axis=0) if len(measured) else (0.0, 0.0)
    estimate = float(np.hypot(TOLERANCES.noise_factor * noise, spacing))
    greatest = TOLERANCES.greatest_deviation
    if estimate > greatest:
        greatest *= max(unit_of(scene), 1.0)
    return float(np.clip(estimate, TOLERANCES.least_deviation, greatest))


def unit_of(scene: Scene | Mapping[str, FloatArray]) -> float:
    """Scale of a scene [m]: as long in it as a metre is among objects that hands take.

    Args:
        scene: A scene, or clouds (N, 3) [m] by name, those that can move.

    Returns:
        The size of half of its things over the usual one; 1 where they are not unusual, or have none.
    """
    clouds = [scene.clouds[name] for name in scene.movable] if isinstance(scene, Scene) else scene.values()
    # twice how far nearly all points are from their middle: a few may be astray
    some = [cloud[:: -(-len(cloud) // REGION)] for cloud in clouds]
    reach = [np.quantile(lengths(cloud - middle_of(cloud)), 0.95) for cloud in some]
    size = 2.0 * float(np.median(reach)) if reach else USUAL
    return 1.0 if size == 0.0 or USUAL_SIZES[0] <= size <= USUAL_SIZES[1] else size / USUAL


def clean(points: FloatArray) -> FloatArray:
    """Drop stray points, such as pixels that fly between an object's edge and what is behind it.

    Args:
        points: (N, 3) points [m].

    Returns:
        (M, 3) points, M <= N: those whose fifth neighbour is not much farther than is usual in the cloud.
        Small clouds come back as they are, and those of which much would go: points that lie dense in
        some places and thin in others are no strays.
    """
    if len(points) < 30:
        return points
    distance = PointTree(points).query(points, k=6)[0][:, -1]
    usual = max(float(np.median(distance)), 2 * TOLERANCES.least_deviation)
    near = distance <= STRAY * usual
    return points[near] if np.count_nonzero(~near) <= MOST_STRAYS * len(points) else points
