"""Plates, bowls, cups and mugs of glazed stoneware."""

import numpy as np

from topple.robots.shapes.materials import PAINTS, STONEWARE
from topple.robots.shapes.vessel import circle, closed_surface, disc, rings, sectors
from topple.robots.world.bodies import Body, Color, join_meshes
from topple.topology.base.arrays import FloatArray
from topple.topology.scene.mesh import Mesh


def plate(
    name: str = "plate", *, diameter: float = 0.25, height: float = 0.022, well: float = 0.0065
) -> Body:
    """A dinner plate with a foot ring, a flat well and a sloping flange.

    Args:
        name: Name in the scene.
        diameter: Over the rim in [m]; dinner plates have 24 to 28 cm.
        height: Of the rim in [m].
        well: Height of the well's surface in [m]: plates stack at this distance.

    Returns:
        The plate: one part for well and foot, one a sector for the flange. The parts fill the
        hollow inside the foot ring: nothing gets in there, and a disc rests steadier than a ring of pieces.
    """
    r, h = diameter / 2, height
    profile = [
        (0.51 * r, well - 0.0045), (0.52 * r, 0.0), (0.58 * r, 0.0), (0.625 * r, well - 0.0035),
        (r, h - 0.0030), (0.996 * r, h), (0.74 * r, well + 0.4 * (h - well)), (0.625 * r, well),
    ]  # fmt: skip
    stack = rings(circle(24), profile)
    parts = [disc(stack, (2, 3, 7)), *sectors(stack, (3, 4, 5, 6, 7))]
    return STONEWARE.body(name, parts, closed_surface(stack), kind="plate", color=PAINTS["white"])


def bowl(name: str = "bowl", *, diameter: float = 0.16, height: float = 0.06, sides: int = 20) -> Body:
    """A bowl with a flat base and a rounded wall 4 mm thick.

    Args:
        name: Name in the scene.
        diameter: Over the rim in [m]; cereal bowls have 14 to 17 cm, salad bowls up to 24 cm.
        height: Of the rim in [m].
        sides: Corners of the circle.

    Returns:
        The bowl: one part for the base and two a sector for the wall.
    """
    r, h, wall = diameter / 2, height, 0.004
    profile = [
        (0.50 * r, 0.0), (0.84 * r, 0.38 * h), (r, h),
        (r - wall, h), (0.84 * r - wall, 0.38 * h + 0.4 * wall), (0.50 * r - 0.5 * wall, 1.25 * wall),
    ]  # fmt: skip
    stack = rings(circle(sides), profile)
    parts = [disc(stack, (0, 5)), *sectors(stack, (0, 1, 4, 5)), *sectors(stack, (1, 2, 3, 4))]
    return STONEWARE.body(name, parts, closed_surface(stack), kind="bowl", color=PAINTS["blue"])


def cup(
    name: str = "cup",
    *,
    diameter: float = 0.08,
    height: float = 0.095,
    sides: int = 16,
    color: Color = PAINTS["red"],
) -> Body:
    """A cup without a handle, walls 3.5 mm thick, a little wider at the rim.

    Args:
        name: Name in the scene.
        diameter: Over the rim in [m].
        height: Of the rim in [m].
        sides: Corners of the circle.
        color: Red, green, blue, opacity.

    Returns:
        The cup: one part for the base and one a sector for the wall.
    """
    parts, surface = _beaker(diameter, height, sides)
    return STONEWARE.body(name, parts, surface, kind="cup", color=color)


def mug(name: str = "mug", *, diameter: float = 0.085, height: float = 0.095) -> Body:
    """A cup with a handle that stands 3 cm out along x.

    Args:
        name: Name in the scene.
        diameter: Over the rim in [m], without the handle.
        height: Of the rim in [m].

    Returns:
        The mug, centred on its cup; five more parts for the handle.
    """
    parts, surface = _beaker(diameter, height, 16)
    stack = _handle(diameter / 2 * 0.94, height)
    parts += [stack[k : k + 2].reshape(-1, 3) for k in range(len(stack) - 1)]
    skin = join_meshes([(one.vertices, one.faces) for one in (surface, closed_surface(stack))])
    return STONEWARE.body(name, parts, skin, kind="mug", color=PAINTS["red"])


def _beaker(diameter: float, height: float, sides: int) -> tuple[list[FloatArray], Mesh]:
    """Parts and surface of a cup without a handle."""
    r, wall = diameter / 2, 0.0035
    profile = [(0.88 * r, 0.0), (r, height), (r - wall, height), (0.88 * r - wall, 1.5 * wall)]
    stack = rings(circle(sides), profile)
    return [disc(stack, (0, 3)), *sectors(stack, (0, 1, 2, 3))], closed_surface(stack)


def _handle(radius: float, height: float) -> FloatArray:
    """(6, 4, 3) sections of a handle, 9 mm high and 12 mm wide, from the wall's top out and back."""
    path = np.array(
        [[-0.004, 0.82], [0.018, 0.84], [0.032, 0.66], [0.032, 0.40], [0.018, 0.22], [-0.002, 0.24]]
    )
    path = np.stack([radius + path[:, 0], path[:, 1] * height], axis=1)
    along = np.gradient(path, axis=0)
    normal = np.stack([along[:, 1], -along[:, 0]], axis=1) / np.linalg.norm(along, axis=1)[:, None]
    stack = np.empty((len(path), 4, 3))
    for corner, (across, side) in enumerate([(-1, -1), (1, -1), (1, 1), (-1, 1)]):
        stack[:, corner, 0] = path[:, 0] + across * 0.0045 * normal[:, 0]
        stack[:, corner, 2] = path[:, 1] + across * 0.0045 * normal[:, 1]
        stack[:, corner, 1] = side * 0.006
    return stack
