"""What never moves and is no table, as plates: the floor and the walls of a bin, the boards of a shelf."""

import numpy as np
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components
from scipy.spatial import KDTree

from topple.topology.arrays import BoolArray, FloatArray, IntArray
from topple.topology.bodies.parts import convex_parts
from topple.topology.bodies.tolerances import (
    AROUND,
    LINKED,
    PLATES_FEWEST,
    PLATES_LEAST,
    RIM_FEWEST,
    SKY,
    THICK,
    TRIES,
)


def plates_of(cloud: FloatArray, tolerance: float, up: FloatArray, seed: int = 0) -> tuple[FloatArray, ...]:
    """Cut the cloud of a bin or a shelf into flat plates, and what is not flat into convex parts.

    Hulls of pieces cut anywhere fill the room between wall and floor, where hands and objects have to go.

    Args:
        cloud: (N, 3) points [m].
        tolerance: How far points of what is not flat may lie below the hull of their part [m].
        up: (3,) unit vector.
        seed: Of the places where plates are looked for.

    Returns:
        (V, 3) corners of each part.
    """
    rng = np.random.default_rng(seed)
    above = (cloud.mean(axis=0) + SKY * up)[None]  # a hull of a rim is bare from there: it is no lid
    found: list[FloatArray] = []
    rest = cloud
    while len(rest) > max(PLATES_FEWEST, PLATES_LEAST * len(cloud)):
        flat = _largest_plane(rest, rng)
        if flat.sum() < max(PLATES_FEWEST, PLATES_LEAST * len(cloud)):
            break
        for piece in pieces_of(rest[flat]):
            found += convex_parts(piece, THICK, above, fewest=RIM_FEWEST)
        rest = rest[~flat]
    for piece in pieces_of(rest):
        found += convex_parts(piece, tolerance, above, fewest=RIM_FEWEST)
    return tuple(found)


def _largest_plane(points: FloatArray, rng: np.random.Generator) -> BoolArray:
    """Which points lie in the plane with most points, looked for at some of them."""
    tree = KDTree(points)
    best = np.zeros(len(points), dtype=np.bool_)
    for index in rng.permutation(len(points))[:TRIES]:
        near = points[tree.query_ball_point(points[index], AROUND)]
        if len(near) < PLATES_FEWEST:
            continue
        flat = _beside(points, near)
        if flat.sum() > best.sum():
            best = flat
    return _beside(points, points[best]) if best.any() else best


def _beside(points: FloatArray, some: FloatArray) -> BoolArray:
    """Which points lie beside the plane through some of them."""
    middle = some.mean(axis=0)
    normal = np.linalg.eigh((some - middle).T @ (some - middle))[1][:, 0]
    return np.abs((points - middle) @ normal) < THICK


def pieces_of(points: FloatArray) -> list[FloatArray]:
    """Points that hang together; what is too small to be a thing is left out."""
    return [piece for piece in _connected(points) if len(piece) >= PLATES_FEWEST]


def _connected(points: FloatArray) -> list[FloatArray]:
    """(N, 3) points [m] as those that hang together."""
    if len(points) == 0:
        return []
    pairs = KDTree(points).query_pairs(LINKED, output_type="ndarray")
    links = coo_matrix((np.ones(len(pairs)), (pairs[:, 0], pairs[:, 1])), shape=(len(points),) * 2)
    count, which = connected_components(links, directed=False)
    number: IntArray = np.asarray(which)
    return [points[number == k] for k in range(count)]
