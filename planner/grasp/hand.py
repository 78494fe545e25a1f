"""The hand with fingers as a search for grasps sees it: upright prisms about its pads."""

from dataclasses import dataclass

from topple.planner.grasp.shape import Shape
from topple.robots.arm.gripper import ToolState
from topple.robots.collision.prisms import Prism
from topple.topology.base.arrays import FloatArray

Opening = float | FloatArray


@dataclass(frozen=True, eq=False)
class HandShape(Shape):
    """The volumes of a hand about its pads (z approach, y closing, origin between the pads).

    Attributes:
        body: Prisms of all that does not move with the fingers, at absolute y.
        max_opening: Largest distance of the two pads [m].
        pad_width: Extent of a pad along x [m].
        pad_length: Extent of a pad along z [m].
        tip: z of the finger tips [m].
        finger: Prisms of the finger on the +y side; the other one mirrors them.
        force: Of each pad in a grip [N].
        give: Mean lever of the friction about a pad's normal [m].
        hand: How the hand stands when it is open.
    """

    max_opening: float
    pad_width: float
    pad_length: float
    tip: float
    finger: tuple[Prism, ...]
    force: float
    give: float
    hand: ToolState

    def footprints(self, opening: Opening) -> list[tuple[float, float, Opening, Opening, float]]:
        """Rectangles swept by the open hand.

        Args:
            opening: Distance of the pads [m], or an array (P,) of distances.

        Returns:
            For each prism (x low, x high, y low, y high, z of its front) [m], those of the fingers first.
        """
        half = opening / 2.0
        found: list[tuple[float, float, Opening, Opening, float]] = []
        for prism in self.finger:
            low, high = half + prism.y[0], half + prism.y[1]
            found.append((*prism.x, low, high, prism.front))
            found.append((*prism.x, -high, -low, prism.front))
        found += [(*prism.x, *prism.y, prism.front) for prism in self.body]
        return found
