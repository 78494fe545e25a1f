"""A book flat on a table near its edge, wider than a jaw opens either way, for tests without a camera."""

import numpy as np
from on_table import on_table, table

from topple.robots.shapes import book, box, can
from topple.topology.arrays import FloatArray
from topple.topology.scene import Scene

END = 0.17  # [m] where the table ends, along y


def ending_table(side: bool = True) -> FloatArray:
    """Points (N, 3) of a top at height 0 that ends at `END`, with its side below that or without it [m]."""
    top = table()
    top = top[top[:, 1] < END]
    x, z = np.meshgrid(np.arange(-0.45, 0.45, 0.008), np.arange(-0.04, -0.009, 0.008))
    return np.vstack([top, np.column_stack([x.ravel(), np.full(x.size, END), z.ravel()])]) if side else top


def by_the_edge(
    side: bool = True, barred: bool = False, size: tuple[float, float, float] = (0.19, 0.13, 0.03)
) -> Scene:
    """The book, 4 cm before the edge, a carton, and where it is barred a can between them and the edge."""
    bars = ((can("can"), (-0.1, END - 0.033, 0.0)),) if barred else ()
    middle = END - size[1] / 2 - (0.08 if barred else 0.04)
    scene = on_table(
        (book("book", size), (-0.1, middle, 0.0)),
        (box("carton", (0.11, 0.09, 0.15)), (0.08, -0.25, 0.0)),
        *bars,
    )
    return scene.with_cloud("table", ending_table(side))
