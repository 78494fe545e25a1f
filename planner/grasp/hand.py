"""The hand as the grasp search sees it: upright prisms in the tool frame."""

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from topple.planner.grasp.hinged_hand import hinged_prisms
from topple.planner.grasp.prisms import Prism, prisms
from topple.planner.grasp.tolerances import FINGER_SLABS, HAND_REACH, PRESS
from topple.robots.arm.gripper import ParallelJaw, ToolName, ToolState
from topple.robots.arm.hinged import HingedJaw
from topple.topology.base.arrays import FloatArray
from topple.topology.base.errors import InvalidInput

if TYPE_CHECKING:
    from topple.robots.arm.arm import Arm

Opening = float | FloatArray


@dataclass(frozen=True)
class HandShape:
    """The volumes of a hand about its pads (z approach, y closing, origin between the pads).

    Attributes:
        max_opening: Largest distance of the two pads [m].
        pad_width: Extent of a pad along x [m].
        pad_length: Extent of a pad along z [m].
        tip: z of the finger tips [m].
        finger: Prisms of the finger on the +y side; the other one mirrors them.
        palm: Prisms of all that does not move with the fingers, at absolute y.
        force: Of each pad in a grip [N].
        give: Mean lever of the friction about a pad's normal [m].
    """

    max_opening: float
    pad_width: float
    pad_length: float
    tip: float
    finger: tuple[Prism, ...]
    palm: tuple[Prism, ...]
    force: float
    give: float

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
        found += [(*prism.x, *prism.y, prism.front) for prism in self.palm]
        return found


def hand_shape(arm: "Arm") -> HandShape:
    """Measure an arm's hand: the prisms its collision hulls sweep when it comes in along the approach.

    Args:
        arm: An arm with a tool named "fingers".

    Returns:
        The shape, with the fingers cut in slabs along z because they taper towards the tip.
    """
    tool = arm.tools[ToolName.FINGERS]
    jaw = tool.gripper
    if not isinstance(jaw, ParallelJaw):
        raise InvalidInput(f"robot {arm.name!r}: its tool 'fingers' is no jaw")
    if isinstance(jaw, HingedJaw):
        finger, palm = hinged_prisms(lambda opening: hand_bodies(arm, tool.name, ToolState(opening)), jaw)
        pads = jaw.pad_size
        force = PRESS * jaw.force
        return HandShape(jaw.max_opening, *pads, pads[1] / 2.0, finger, palm, force, jaw.give)
    bodies = hand_bodies(arm, ToolName.FINGERS, ToolState(opening=0.0))
    # pads that swing are farthest from the palm as they are shut, and nearest to it as they are open
    shut = tool.pads(0.0)[:3, 3]
    nearest = shut if jaw.arc is None else np.array([0.0, 0.0, float(jaw.arc.min())])
    bodies = [(link, part - (shut if link in jaw.links else nearest)) for link, part in bodies]
    finger = max(_by_link(bodies, jaw.links), key=lambda parts: float(np.vstack(parts)[:, 1].mean()))
    palm = [prism for link, part in bodies if link not in jaw.links for prism in prisms(part, ())]
    return HandShape(
        max_opening=jaw.max_opening,
        pad_width=jaw.pad_size[0],
        pad_length=jaw.pad_size[1],
        tip=max(float(part[:, 2].max()) for part in finger),
        finger=tuple(prism for part in finger for prism in prisms(part, FINGER_SLABS)),
        palm=tuple(palm),
        force=PRESS * jaw.force,
        give=jaw.give,
    )


def hand_bodies(arm: "Arm", tool: str, state: ToolState) -> list[tuple[str, FloatArray]]:
    """Convex bodies of a hand around one of its tool frames.

    Args:
        arm: The arm.
        tool: "fingers" or "suction".
        state: How the hand stands.

    Returns:
        (link name, (V, 3) vertices in the tool frame [m]) for every body that can meet what is grasped.
    """
    q = np.asarray(arm.home, dtype=np.float64)[None]
    poses = arm.forward(q, state)[0]
    to_tool = np.linalg.inv(arm.tool_pose(q, tool)[0])
    found: list[tuple[str, FloatArray]] = []
    last = len(arm.joints)  # links before the last joint are near the tool in some states only
    for link, frame, pose, parts in zip(arm.links, arm.frame_of_link, poses, arm.parts, strict=True):
        for part in parts if frame == last else ():
            vertices = part @ (to_tool @ pose)[:3, :3].T + (to_tool @ pose)[:3, 3]
            if vertices[:, 2].max() > -HAND_REACH and np.linalg.norm(vertices, axis=1).min() < HAND_REACH:
                found.append((link, vertices))
    return found


def _by_link(bodies: list[tuple[str, FloatArray]], links: tuple[str, ...]) -> list[list[FloatArray]]:
    """The parts of each of some links."""
    return [[part for link, part in bodies if link == wanted] for wanted in links]
