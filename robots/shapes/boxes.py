"""Boxes, blocks, bars, trays and cans."""

import itertools

import numpy as np

from topple.robots.shapes.materials import CARD, FOOD, PAINTS, WOOD
from topple.robots.shapes.vessel import circle, closed_surface, disc, rings, sectors
from topple.robots.world.bodies import Body, Color
from topple.topology.base.arrays import FloatArray

_SQUARE = np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])


def box(
    name: str = "box",
    size: tuple[float, float, float] = (0.09, 0.17, 0.05),
    *,
    mass: float | None = None,
    density: float = CARD.density,
    color: Color = PAINTS["cardboard"],
    kind: str = "box",
) -> Body:
    """A full packet.

    Args:
        name: Name in the scene.
        size: Extents in x, y, z in [m].
        mass: In [kg]; None: volume times density.
        density: In [kg/m^3].
        color: Red, green, blue, opacity.
        kind: What it is.

    Returns:
        The box: one part.
    """
    half = np.array(size) / 2
    corners = np.array(list(itertools.product((-1, 1), repeat=3))) * half + [0, 0, half[2]]
    return Body.of(name, [corners], mass=mass, density=density, rolling=CARD.rolling, color=color, kind=kind)


def block(name: str = "block", side: float = 0.05, *, color: Color = PAINTS["beech"]) -> Body:
    """A wooden toy block of the given side in [m], 5 cm and 80 g by default."""
    return box(name, (side, side, side), density=WOOD.density, color=color, kind="block")


def bar(
    name: str = "bar",
    size: tuple[float, float, float] = (0.22, 0.025, 0.02),
    *,
    color: Color = PAINTS["beech"],
) -> Body:
    """A wooden bar of extents in [m], along x; 70 g by default."""
    return box(name, size, density=WOOD.density, color=color, kind="bar")


def can(
    name: str = "can",
    *,
    diameter: float = 0.066,
    height: float = 0.101,
    sides: int = 32,
    mass: float | None = None,
    color: Color = PAINTS["tin"],
) -> Body:
    """A full can.

    Args:
        name: Name in the scene.
        diameter: In [m]; a soup can has 6.6 cm, a tuna can 8.5 cm.
        height: In [m]; 10.1 cm and 3.4 cm.
        sides: Corners of the circle: with 32 it is round within 0.2 mm.
        mass: In [kg]; None: that of its volume of food, 0.34 kg for soup.
        color: Red, green, blue, opacity.

    Returns:
        The can: one part.
    """
    stack = rings(circle(sides), [(diameter / 2, 0.0), (diameter / 2, height)])
    return FOOD.body(name, [disc(stack, (0, 1))], closed_surface(stack), kind="can", color=color, mass=mass)


def tray(
    name: str = "tray",
    size: tuple[float, float, float] = (0.30, 0.20, 0.035),
    *,
    wall: float = 0.005,
    mass: float | None = None,
    color: Color = PAINTS["beech"],
) -> Body:
    """A wooden tray with four upright walls.

    Args:
        name: Name in the scene.
        size: Outer extents in x, y, z in [m].
        wall: Thickness of floor and walls in [m].
        mass: In [kg]; None: that of wood, 0.3 kg.
        color: Red, green, blue, opacity.

    Returns:
        The tray: one part for the floor, four for the walls.
    """
    outer, inner = _rectangle(size[0], size[1]), _rectangle(size[0] - 2 * wall, size[1] - 2 * wall)
    heights = (0.0, size[2], size[2], wall)
    stack = np.empty((4, 4, 3))
    for ring, outline, height in zip(stack, (outer, outer, inner, inner), heights, strict=True):
        ring[:, :2], ring[:, 2] = outline, height
    floor = np.concatenate([np.c_[inner, np.zeros(4)], np.c_[inner, np.full(4, wall)]])
    rim = stack.copy()
    rim[3, :, 2] = 0.0  # the walls reach down beside the floor: nothing overlaps
    parts = [floor, *sectors(rim, (0, 1, 2, 3))]
    return WOOD.body(name, parts, closed_surface(stack), kind="tray", color=color, mass=mass)


def _rectangle(x: float, y: float) -> FloatArray:
    """(4, 2) corners of a rectangle about the origin, counterclockwise."""
    return _SQUARE * [x / 2, y / 2]
