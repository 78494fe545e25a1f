"""The paper's rule written down in plain numpy, to compare with.

Qhull once for every cloud; then for every pair, both ways, every point in the enlarged box against every
facet, repeated planes of triangulated facets included, and all three cells of the row counted. No pair,
point or facet is left out by anything cleverer than the box, and nothing asked for once is done twice.
"""

from collections.abc import Mapping
from itertools import combinations

import numpy as np
from scipy.spatial import ConvexHull

from topple.topology.base.arrays import FloatArray, IntArray

BLOCK = 20_000
"""Points whose facet distances are computed at once, so that the table fits into memory."""


def plain_numpy(clouds: Mapping[str, FloatArray], deviation: float) -> dict[tuple[str, str], IntArray]:
    """Count every matrix the straight way: Qhull, then every point in the enlarged box x every facet.

    Args:
        clouds: (N, 3) points per object, none of them flat [m].
        deviation: The deviation factor δ [m].

    Returns:
        (a, b) -> (2, 3) counts R(a, b), for every unordered pair.
    """
    hulls = {name: ConvexHull(cloud) for name, cloud in clouds.items()}
    return {
        (a, b): np.stack([_row(clouds[a], hulls[b], deviation), _row(clouds[b], hulls[a], deviation)])
        for a, b in combinations(clouds, 2)
    }


def _row(points: FloatArray, hull: ConvexHull, deviation: float) -> IntArray:
    """(3,) counts of points in the interior, on the boundary and in the exterior of a hull."""
    inside_box = ((points >= hull.min_bound - deviation) & (points <= hull.max_bound + deviation)).all(axis=1)
    near = points[inside_box]
    counts = np.array([0, 0, len(points) - len(near)])
    for start in range(0, len(near), BLOCK):
        distance = near[start : start + BLOCK] @ hull.equations[:, :3].T + hull.equations[:, 3]
        furthest = distance.max(axis=1)
        counts += [
            (furthest < -deviation).sum(),
            (np.abs(furthest) <= deviation).sum(),
            (furthest > deviation).sum(),
        ]
    return counts
