"""What never moves and is no table, as plates: the floor and the walls of a bin, the boards of a shelf."""

from collections.abc import Sequence

import numpy as np

from topple.topology.base.arrays import BoolArray, FloatArray
from topple.topology.bodies.parts import convex_parts
from topple.topology.bodies.tolerances import (
    AROUND,
    PATCH_FEWEST,
    PLATES_LEAST,
    RIM_FEWEST,
    SKIN,
    SKY,
    THICK,
    TRIES,
)
from topple.topology.geometry.pieces import pieces_of, surface_spacing
from topple.topology.geometry.sides import beyond, joggled_sides
from topple.topology.geometry.tolerances import LINKED, PIECE_FEWEST
from topple.topology.kernels.neighbours import PointTree


def plates_of(
    cloud: FloatArray, tolerance: float, up: FloatArray, seed: int = 0, spacing: float = 0.0
) -> tuple[FloatArray, ...]:
    """Cut the cloud of a bin or a shelf into flat plates, and what is not flat into convex parts.

    Hulls of pieces cut anywhere fill the room between wall and floor, where hands and objects have to go.

    Args:
        cloud: (N, 3) points [m].
        tolerance: How far points of what is not flat may lie below the hull of their part [m].
        up: (3,) unit vector.
        seed: Of the places where plates are looked for.
        spacing: Typical distance of neighbours on all of what never moves [m]; counts where that is sparse.

    Returns:
        (V, 3) corners of each part.
    """
    spacing = surface_spacing(cloud, spacing)
    rng = np.random.default_rng(seed)
    above = (cloud.mean(axis=0) + SKY * up)[None]  # a hull of a rim is bare from there: it is no lid
    found: list[FloatArray] = []
    cloud = rest = np.concatenate([np.empty((0, 3)), *pieces_of(cloud, spacing)])
    while len(rest) > max(PIECE_FEWEST, PLATES_LEAST * len(cloud)):
        flat = _largest_plane(rest, rng, max(AROUND, 2.0 * spacing))
        if flat.sum() < max(PIECE_FEWEST, PLATES_LEAST * len(cloud)):
            break
        for piece in pieces_of(rest[flat], spacing):
            found += convex_parts(piece, THICK, above, fewest=RIM_FEWEST)
        rest = rest[~flat]
    for piece in pieces_of(rest, spacing, RIM_FEWEST):
        found += convex_parts(piece, tolerance, above, fewest=RIM_FEWEST)
    return (*found, *_patches(cloud, found, max(LINKED, 2.0 * spacing)))


def _patches(cloud: FloatArray, parts: Sequence[FloatArray], reach: float) -> list[FloatArray]:
    """Parts around points (N, 3) that some parts leave out, as between two where points are sparse."""
    out = np.min([beyond(joggled_sides(part), cloud) for part in parts], axis=0, initial=np.inf)
    left, found = cloud[out > SKIN], list[FloatArray]()
    while len(left):
        patch = cloud[np.linalg.norm(cloud - left[0], axis=1) <= reach]
        left = left[1:]
        if len(patch) >= PATCH_FEWEST:
            found.append(patch)
            left = left[beyond(joggled_sides(patch), left) > SKIN]
    return found


def _largest_plane(points: FloatArray, rng: np.random.Generator, around: float) -> BoolArray:
    """Which points lie in the plane with most points, looked for at some and what is around them [m]."""
    tree = PointTree(points)
    best = np.zeros(len(points), dtype=np.bool_)
    for index in rng.permutation(len(points))[:TRIES]:
        near = points[tree.query_ball_point(points[index : index + 1], around)[0]]
        if len(near) < PIECE_FEWEST:
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
