"""Spoons, forks and knives of stainless steel, along x, the handle towards +x."""

from collections.abc import Sequence

import numpy as np

from topple.robots.shapes.materials import PAINTS, STEEL
from topple.robots.world.bodies import Body
from topple.topology.base.arrays import BoolArray, FloatArray
from topple.topology.scene.mesh import Mesh


def spoon(name: str = "spoon", *, length: float = 0.195) -> Body:
    """A table spoon: a bowl 4 cm wide and 8 mm deep, a handle that arches 15 mm above the table.

    Args:
        name: Name in the scene.
        length: In [m]; table spoons have 19 to 21 cm.

    Returns:
        The spoon: eleven parts for the bowl, three for the handle.
    """
    x = np.array([0.0, 0.07, 0.16, 0.25, 0.33, 0.40, 0.66, 1.0]) * length
    half = np.array([0.008, 0.017, 0.0205, 0.016, 0.006, 0.0032, 0.005, 0.010])
    middle = np.array(
        [0.0075, 0.0030, 0.0018, 0.0040, 0.0100, 0.0155, 0.0175, 0.0040]
    )  # along the deepest line
    edge = np.array([0.0085, 0.0095, 0.0100, 0.0105, 0.0110, 0.0155, 0.0175, 0.0020])
    across = np.array([-1.0, -0.5, 0.5, 1.0])
    top = np.empty((len(x), 4, 3))
    top[..., 0] = x[:, None]
    top[..., 1] = half[:, None] * across
    top[..., 2] = np.where(np.abs(across) < 1, middle[:, None], edge[:, None])
    thickness = np.array([0.0015, 0.0018, 0.0018, 0.0018, 0.0028, 0.0034, 0.0026, 0.0020])
    cells = np.ones((len(x) - 1, 3), dtype=bool)
    return _steel(name, top, thickness, cells, (5, 6), "spoon")


def fork(name: str = "fork", *, length: float = 0.195) -> Body:
    """A table fork with four tines 3.5 mm wide, 25 mm over all.

    Args:
        name: Name in the scene.
        length: In [m]; table forks have 18 to 21 cm.

    Returns:
        The fork: eight parts for the tines, five for root, neck and handle.
    """
    x = np.array([0.0, 0.13, 0.25, 0.30, 0.36, 0.42, 0.66, 1.0]) * length
    half = np.array([0.0118, 0.0125, 0.0125, 0.0120, 0.0050, 0.0032, 0.0048, 0.0100])
    height = np.array([0.0120, 0.0040, 0.0022, 0.0045, 0.0105, 0.0150, 0.0170, 0.0020])
    tine, gap = 0.0035, 0.0037
    edges = np.cumsum([0, tine, gap, tine, gap, tine, gap, tine])
    across = edges / edges[-1] * 2 - 1
    top = np.empty((len(x), len(across), 3))
    top[..., 0] = x[:, None]
    top[..., 1] = half[:, None] * across
    top[..., 2] = height[:, None]
    thickness = np.array([0.0014, 0.0020, 0.0022, 0.0024, 0.0030, 0.0034, 0.0026, 0.0020])
    cells = np.ones((len(x) - 1, len(across) - 1), dtype=bool)
    cells[:2, 1::2] = False
    return _steel(name, top, thickness, cells, (2, 3, 4, 5, 6), "fork")


def _steel(
    name: str, top: FloatArray, thickness: FloatArray, cells: BoolArray, joined: tuple[int, ...], kind: str
) -> Body:
    """Centre a sheet over its box, set it on z = 0 and make it a body."""
    top = top.copy()
    top[..., 0] -= top[..., 0].max() / 2
    top[..., 2] -= (top[..., 2] - thickness[:, None]).min()
    surface, parts = _sheet(top, thickness, cells, joined)
    return STEEL.body(name, parts, surface, kind=kind, color=PAINTS["silver"])


def _sheet(
    top: FloatArray, thickness: FloatArray, cells: BoolArray, joined: Sequence[int] = ()
) -> tuple[Mesh, list[FloatArray]]:
    """Thicken a grid of points downwards, as cutlery is stamped: one convex part per cell.

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
