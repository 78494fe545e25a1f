"""Bent sheets, as cutlery is stamped: a grid of stations and columns, one convex part per cell."""

from collections.abc import Sequence

import numpy as np

from topple.topology.arrays import BoolArray, FloatArray
from topple.topology.scene import Mesh


def sheet(
    top: FloatArray, thickness: FloatArray, cells: BoolArray, joined: Sequence[int] = ()
) -> tuple[Mesh, list[FloatArray]]:
    """Thicken a grid of points downwards.

    Args:
        top: (M + 1, K + 1, 3) points of the upper side in [m]; x grows with the station, y with the column.
        thickness: (M + 1,) of each station in [m].
        cells: (M, K) where there is metal.
        joined: Stations whose cells are convex together and become one part.

    Returns:
        A watertight mesh, and the convex parts (V, 3).
    """
    bottom = top.copy()
    bottom[..., 2] -= thickness[:, None]
    parts: list[FloatArray] = []
    for m in range(cells.shape[0]):
        columns = np.flatnonzero(cells[m])
        spans = [(columns[0], columns[-1] + 1)] if m in joined else [(k, k + 1) for k in columns]
        for first, last in spans:
            part = [side[m : m + 2, first : last + 1].reshape(-1, 3) for side in (top, bottom)]
            parts.append(np.concatenate(part))
    return _skin(top, bottom, cells), parts


def _skin(top: FloatArray, bottom: FloatArray, cells: BoolArray) -> Mesh:
    """Upper and lower side of every cell, and walls where a cell has no neighbour."""
    count = top.shape[0] * top.shape[1]
    index = np.arange(count).reshape(top.shape[:2])
    quads: list[tuple[int, int, int, int]] = []
    padded = np.pad(cells, 1)
    for m, k in np.argwhere(cells):
        a, b, c, d = index[m, k], index[m + 1, k], index[m + 1, k + 1], index[m, k + 1]
        quads.append((a, b, c, d))
        quads.append((a + count, d + count, c + count, b + count))
        for start, end, neighbour in (
            (a, b, padded[m + 1, k]), (b, c, padded[m + 2, k + 1]),
            (c, d, padded[m + 1, k + 2]), (d, a, padded[m, k + 1]),
        ):  # fmt: skip
            if not neighbour:
                quads.append((start, start + count, end + count, end))
    corners = np.array(quads, dtype=np.int64)
    faces = np.concatenate([corners[:, [0, 1, 2]], corners[:, [0, 2, 3]]])
    used, faces = np.unique(faces, return_inverse=True)
    return Mesh(np.concatenate([top.reshape(-1, 3), bottom.reshape(-1, 3)])[used], faces.reshape(-1, 3))
