"""Pictures of triangles: what lies nearest on the ray through the middle of each pixel."""

from typing import TYPE_CHECKING

import numpy as np

from topple.topology.kernels.compiled import address, kernels

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from topple.topology.base.arrays import FloatArray, IntArray


def draw_triangles(
    corners: "FloatArray",
    paints: "FloatArray",
    K: "FloatArray",
    size: tuple[int, int],
    nearest: float,
    farthest: float,
) -> "tuple[FloatArray, IntArray, NDArray[np.uint8]]":
    """Draw triangles as a pinhole camera sees them, both of their sides.

    Args:
        corners: (F, 3, 3) in the camera's frame, z forward [m]; behind the camera is allowed.
        paints: (F, 3, 3) red, green, blue of the corners, 0..255.
        K: (3, 3) intrinsics, pixels' middles at integers.
        size: Width and height [px].
        nearest: Depth from which on something is seen [m], > 0.
        farthest: Likewise up to which.

    Returns:
        Depth (H, W) [m], 0 where nothing is seen; numbers (H, W) of the triangles, -1 there; colours
        (H, W, 3), white there. Kernel and twin give the same up to rounding.
    """
    width, height = size
    inverse, owner = np.full((height, width), 1.0 / farthest), np.full((height, width), -1, dtype=np.int64)
    lens = np.array([K[0, 0], K[1, 1], K[0, 2], K[1, 2]])
    compiled, colours = kernels(), np.full((height, width, 3), 255, dtype=np.uint8)
    if compiled is None:
        _draw(corners, lens, nearest, inverse, owner)
        rows, columns = np.nonzero(owner >= 0)
        weights = np.einsum("fik,fk->fi", _edges(corners, lens)[owner[rows, columns]], _places(columns, rows))
        mixed = np.einsum("fi,fic->fc", weights, paints[owner[rows, columns]])
        colours[rows, columns] = (mixed / weights.sum(axis=1, keepdims=True)).clip(0, 255)
    else:
        given, mixed = (np.ascontiguousarray(each, dtype=np.float64) for each in (corners, paints))
        compiled.triangles_drawn(
            address(given), len(given), address(lens), width, height, nearest, address(inverse),
            address(owner), address(mixed), address(colours),
        )  # fmt: skip
    depth = 1.0 / inverse
    depth[owner < 0] = 0.0
    return depth, owner, colours


def _places(columns: "IntArray", rows: "IntArray") -> "FloatArray":
    return np.stack([columns, rows, np.ones_like(rows)], axis=-1).astype(np.float64)


def _edges(corners: "FloatArray", lens: "FloatArray") -> "FloatArray":
    """(F, 3, 3) by which the place (u, v, 1) of a pixel gives the weight of each corner, up to a factor."""
    edges = np.cross(np.roll(corners, -1, axis=1), np.roll(corners, -2, axis=1))
    edges[..., :2] /= lens[:2]
    edges[..., 2] -= edges[..., :2] @ lens[2:]
    return edges


def _draw(
    corners: "FloatArray", lens: "FloatArray", nearest: float, inverse: "FloatArray", owner: "IntArray"
) -> None:
    """Draw triangle by triangle, each over the rows and columns of its box."""
    height, width = inverse.shape
    edges = _edges(corners, lens)
    volumes = np.einsum("fi,fi->f", corners[:, 0], np.cross(corners[:, 1], corners[:, 2]))
    for t in np.flatnonzero((volumes != 0.0) & (corners[..., 2].max(axis=1) >= nearest)):
        low, high = np.zeros(2), np.array([width - 1.0, height - 1.0])
        if corners[t, :, 2].min() >= nearest:
            spots = corners[t, :, :2] / corners[t, :, 2:] * lens[:2] + lens[2:]
            low, high = (
                np.maximum(low, np.floor(spots.min(axis=0))),
                np.minimum(high, np.ceil(spots.max(axis=0))),
            )
        if (low > high).any():
            continue
        box = tuple(slice(int(a), int(b) + 1) for a, b in zip(low[::-1], high[::-1], strict=True))
        rows, columns = np.mgrid[box]
        weights = _places(columns, rows) @ (edges[t].T / volumes[t])
        near = weights.sum(axis=-1)
        won = (weights >= 0.0).all(axis=-1) & (near > inverse[box]) & (near <= 1.0 / nearest)
        inverse[box][won], owner[box][won] = near[won], t
