"""The hand whose one finger turns, as the grasp search sees it: prisms that hold all its states.

The search knows fingers that mirror each other about the middle of the pads. The fixed finger and the turned
one are each taken for both, at several openings: more room is asked for than such a hand needs.
"""

from collections.abc import Callable

import numpy as np

from topple.planner.grasp.prisms import Prism, prisms
from topple.planner.grasp.tolerances import FINGER_SLABS, GRASP_TOLERANCES, HINGED_OPENINGS, OVER_FACE, SWUNG
from topple.robots.arm.hinged import HingedJaw
from topple.robots.arm.tolerances import BESIDE
from topple.robots.collision.convex import section
from topple.topology.base.arrays import FloatArray

Bodies = list[tuple[str, FloatArray]]


def hinged_prisms(
    bodies: Callable[[float], Bodies], jaw: HingedJaw
) -> tuple[tuple[Prism, ...], tuple[Prism, ...]]:
    """Measure a hinged hand.

    Args:
        bodies: Its convex bodies in the tool frame [m], with their links, at an opening [m].
        jaw: Its jaw.

    Returns:
        Prisms of a finger and of the palm about the middle of the pads, which are where both fingers hold at
        any opening: the fixed finger goes on beyond them.
    """
    moving, fixed = jaw.links
    finger, palm = list[Prism](), list[Prism]()
    for link, part in bodies(jaw.max_opening):
        for prism in [] if link == moving else prisms(part, FINGER_SLABS):
            low, high = prism.y
            if link == fixed and high <= OVER_FACE:
                finger.append(Prism(prism.x, (max(-high, 0.0), -low), prism.front))
            else:
                palm.append(Prism(prism.x, (low - jaw.max_opening / 2.0 - BESIDE, high), prism.front))
    return (*finger, *_swung(bodies, jaw)), tuple(palm)


def _swung(bodies: Callable[[float], Bodies], jaw: HingedJaw) -> list[Prism]:
    """Prisms of all that the moving finger fills at any opening, y from its face where that is nearest."""
    aside = GRASP_TOLERANCES.side_clearance - BESIDE  # what the hand is off the middle on the way in
    swung = list[FloatArray]()
    for opening in np.linspace(jaw.openings[0], jaw.max_opening, HINGED_OPENINGS).tolist():
        swung += [part - [0.0, opening, 0.0] for link, part in bodies(opening) if link == jaw.links[0]]
    tip = max(float(part[:, 2].max()) for part in swung)
    found = list[Prism]()
    for front in np.arange(tip, tip - SWUNG[0], -SWUNG[1]).tolist():
        cuts = [section(part, z) for part in swung for z in (front - 1e-6, front - SWUNG[1])]
        cuts += [part[(part[:, 2] <= front) & (part[:, 2] >= front - SWUNG[1])] for part in swung]
        points = np.concatenate(cuts)
        (x0, y0), (x1, y1) = points[:, :2].min(axis=0).tolist(), points[:, :2].max(axis=0).tolist()
        found.append(Prism((x0, x1), (y0, y1 + aside), front))
    return found
