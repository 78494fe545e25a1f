"""Bottles and tins of the supermarket: closed convex sections stacked on one another."""

from collections.abc import Sequence

import numpy as np

from topple.robots.shapes.materials import FOOD, PAINTS
from topple.robots.shapes.vessel import circle, closed_surface, rings
from topple.robots.world.bodies import Body, Color
from topple.topology.base.arrays import FloatArray


def bottle(
    name: str = "bottle",
    *,
    width: float = 0.085,
    depth: float = 0.05,
    height: float = 0.175,
    mass: float | None = None,
    color: Color = PAINTS["mustard"],
) -> Body:
    """A squeeze bottle with an oval body, sloping shoulders and a pointed cap; a mustard bottle by default.

    Args:
        name: Name in the scene.
        width: Of the oval, along x in [m].
        depth: Of the oval, along y in [m].
        height: With the cap in [m].
        mass: In [kg]; None: that of its volume of food, 0.5 kg.
        color: Red, green, blue, opacity.

    Returns:
        The bottle: one part each for body, shoulders, cap and its tip.
    """
    body = _oval(width, depth, [(0.94, 0.0), (1.0, 0.02), (1.0, 0.55)])
    shoulders = _oval(width, depth, [(1.0, 0.55), (0.85, 0.68), (0.42, 0.76)])
    cap = _oval(0.42 * width, 0.6 * depth, [(1.0, 0.76), (0.95, 0.85)])
    tip = _oval(0.42 * width, 0.6 * depth, [(0.5, 0.85), (0.2, 1.0)])
    stack = np.concatenate([body, shoulders[1:], cap, tip]) * [1.0, 1.0, height]
    parts = [part * [1.0, 1.0, height] for part in (body, shoulders, cap, tip)]
    corners = [part.reshape(-1, 3) for part in parts]
    return FOOD.body(name, corners, closed_surface(stack), kind="bottle", color=color, mass=mass)


def tin(
    name: str = "tin",
    size: tuple[float, float, float] = (0.097, 0.05, 0.082),
    *,
    mass: float | None = None,
    color: Color = PAINTS["navy"],
) -> Body:
    """A tin with a rectangular base and well rounded corners; one of potted meat by default.

    Args:
        name: Name in the scene.
        size: Extents in x, y, z in [m].
        mass: In [kg]; None: that of its volume of food, 0.37 kg.
        color: Red, green, blue, opacity.

    Returns:
        The tin: one part.
    """
    outline = circle(40)
    # A superellipse of exponent 4: straight sides, corners rounded by about a quarter of the width.
    rounded = np.sign(outline) * np.sqrt(np.abs(outline)) / 2
    stack = rings(rounded * [size[0], size[1]], [(1.0, 0.0), (1.0, size[2])])
    corners = [stack.reshape(-1, 3)]
    return FOOD.body(name, corners, closed_surface(stack), kind="tin", color=color, mass=mass)


def _oval(width: float, depth: float, profile: Sequence[tuple[float, float]]) -> FloatArray:
    return rings(circle(24) * [width / 2, depth / 2], profile)
