"""The paper's whole rule, to be held against its section 3: hulls, equations 1 to 4, Table 1.

Two things differ from what is printed. Algorithm 1, read literally, never answers touch or disjoint, so
Table 1 decides. And its box is enlarged by δ: as printed, a point just outside the box would be exterior.

Everything is compared with everything. `relate(scene, plain=True)` gives the same answers sooner, by
`topple.topology.sixim.fast`.
"""

from collections.abc import Mapping
from itertools import combinations

import numpy as np

from topple.topology.base.arrays import FloatArray, IntArray
from topple.topology.geometry.hull import Hull
from topple.topology.sixim.table import Relation, classify


def directed_distances(points: FloatArray, hull: Hull) -> FloatArray:
    """(N, F) distances of points (N, 3) to each facet's plane [m], positive outside (equation 2)."""
    return points @ hull.normals.T + hull.offsets


def counts(points: FloatArray, hull: Hull, deviation: float) -> IntArray:
    """How many points lie in a hull's interior, on its boundary and in its exterior (equations 3 and 4).

    Args:
        points: (N, 3) points [m].
        hull: The hull.
        deviation: The deviation factor δ [m], > 0.

    Returns:
        (3,) counts (interior, boundary, exterior).
    """
    in_box = (points >= hull.lower - deviation) & (points <= hull.upper + deviation)
    d = directed_distances(points[in_box.all(axis=1)], hull)
    interior = int((d < -deviation).all(axis=1).sum())
    boundary = int((d <= deviation).all(axis=1).sum()) - interior
    return np.array([interior, boundary, len(points) - interior - boundary])


def intersection_matrix(
    a: FloatArray, hull_a: Hull, b: FloatArray, hull_b: Hull, deviation: float
) -> IntArray:
    """R(A, B), how many points of each cloud are where in the other (equation 1).

    Args:
        a: (N, 3) points of A [m].
        hull_a: Hull of A, its boundary ∂A (Definition 1).
        b: (M, 3) points of B [m].
        hull_b: Hull of B.
        deviation: The deviation factor δ [m], > 0.

    Returns:
        (2, 3) counts [[A∩B°, A∩∂B, A∩B⁻], [A°∩B, ∂A∩B, A⁻∩B]].
    """
    return np.stack([counts(a, hull_b, deviation), counts(b, hull_a, deviation)])


def plain_relations(
    clouds: Mapping[str, FloatArray], deviation: float
) -> dict[tuple[str, str], tuple[Relation, IntArray]]:
    """The relation of every pair of clouds, and the matrix it was read from by Table 1.

    Args:
        clouds: Points (N, 3) [m] by name.
        deviation: The deviation factor δ [m], > 0.

    Returns:
        (a, b) -> "a relation b" and R(A, B), each unordered pair once.
    """
    hulls = {name: Hull.of(cloud) for name, cloud in clouds.items()}
    found: dict[tuple[str, str], tuple[Relation, IntArray]] = {}
    for a, b in combinations(clouds, 2):
        matrix = intersection_matrix(clouds[a], hulls[a], clouds[b], hulls[b], deviation)
        found[a, b] = classify(matrix), matrix
    return found
