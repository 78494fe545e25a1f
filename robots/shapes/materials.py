"""What household things are made of: densities from material tables, friction as measured on dry surfaces.

A contact's coefficient is the product of the two: 0.5 between things and 0.6 on the table, in the middle of
what is measured for glaze, steel, card and wood.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from topple.robots.world.bodies import Body, Color
from topple.topology.base.arrays import FloatArray
from topple.topology.scene.mesh import Mesh


@dataclass(frozen=True)
class Material:
    """One material.

    Attributes:
        density: In [kg/m^3].
        friction: Coulomb coefficient of the thing; a contact multiplies two.
        rolling: Lever of the rolling resistance in [m]; what has flat sides needs none.
    """

    density: float
    friction: float = 0.7
    rolling: float = 0.0

    def body(
        self,
        name: str,
        parts: Sequence[FloatArray],
        mesh: Mesh,
        *,
        kind: str,
        color: Color,
        mass: float | None = None,
    ) -> Body:
        """A body of it: convex parts (V, 3) and surface in [m], mass in [kg] (None: that of its volume)."""
        return Body.of(
            name, parts, mesh=mesh, mass=mass, density=self.density, friction=self.friction,
            rolling=self.rolling, color=color, kind=kind,
        )  # fmt: skip


PAINTS: Mapping[str, Color] = {
    "cardboard": (0.75, 0.6, 0.4, 1.0),
    "tin": (0.6, 0.15, 0.15, 1.0),
    "beech": (0.82, 0.68, 0.47, 1.0),
    "mustard": (0.95, 0.78, 0.1, 1.0),
    "navy": (0.2, 0.25, 0.55, 1.0),
    "silver": (0.72, 0.72, 0.76, 1.0),
    "white": (0.93, 0.92, 0.88, 1.0),
    "blue": (0.35, 0.5, 0.75, 1.0),
    "red": (0.75, 0.25, 0.2, 1.0),
    "pine": (0.82, 0.74, 0.6, 1.0),
    "glass": (0.75, 0.85, 0.6, 1.0),
}
"""Red, green, blue and opacity of household things, 0..1."""

STONEWARE = Material(2300.0)  # glazed stoneware and porcelain: 2300 to 2400
STEEL = Material(7900.0)  # stainless steel 18/10
WOOD = Material(650.0)  # beech
CARD = Material(350.0)  # a full packet of sugar is 800, one of cereals 150
FOOD = Material(1000.0, rolling=5e-4)  # a full can: near water's, the tin adds what the head space lacks
FRUIT = Material(950.0, rolling=1.5e-3)  # most fruit just floats; its skin dents, so it rolls badly
