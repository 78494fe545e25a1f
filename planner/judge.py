"""What an action did to everything it was not about, measured on the simulation's true poses."""

from collections.abc import Collection, Mapping
from dataclasses import dataclass

import numpy as np

from topple.robots.poses import angle_between
from topple.robots.simulated_arm import Touch
from topple.topology.arrays import FloatArray


@dataclass(frozen=True)
class Limits:
    """From where on an object counts as disturbed.

    Attributes:
        distance: Displacement in [m]; 1 cm is more than depth noise and less than what topples a neighbour.
        angle: Turn in [rad].
        hit: Contact force of the robot in [N] on something it does not handle: a brush below the
            weight of a can moves nothing.
        fall: Drop in [m] from which a displaced object counts as fallen.
    """

    distance: float = 0.01
    angle: float = float(np.radians(10.0))
    hit: float = 5.0
    fall: float = 0.03


LIMITS = Limits()


def displacements(
    before: Mapping[str, FloatArray], after: Mapping[str, FloatArray], handled: Collection[str]
) -> dict[str, tuple[float, float]]:
    """How far everything but the handled objects moved and turned.

    Args:
        before: Poses (4, 4) by name.
        after: Poses (4, 4) by name, the same names.
        handled: Names to leave out.

    Returns:
        Distance in [m] and angle in [rad] by name.
    """
    return {
        name: (
            float(np.linalg.norm(after[name][:3, 3] - pose[:3, 3])),
            angle_between(pose, after[name]),
        )
        for name, pose in before.items()
        if name not in handled and name in after
    }


def violations(
    before: Mapping[str, FloatArray],
    after: Mapping[str, FloatArray],
    touched: Mapping[str, Touch],
    handled: Collection[str],
    limits: Limits = LIMITS,
) -> list[str]:
    """One sentence for each object that moved, turned, fell or was hit though nobody meant to handle it.

    Args:
        before: Poses (4, 4) by name.
        after: Poses (4, 4) by name.
        touched: What the robot touched in between, by name.
        handled: Names that the action was about.
        limits: From where on it counts.
    """
    found: list[str] = []
    for name, (distance, angle) in displacements(before, after, handled).items():
        drop = float(before[name][2, 3] - after[name][2, 3])
        if distance > limits.distance and drop > limits.fall:
            found.append(f"{name} fell by {drop * 100:.0f} cm")
        elif distance > limits.distance or angle > limits.angle:
            found.append(f"{name} moved {distance * 1000:.0f} mm and turned {np.degrees(angle):.0f} degrees")
    for name, touch in touched.items():
        if name not in handled and touch.force > limits.hit:
            links = ", ".join(sorted(touch.links))
            found.append(f"{name} was hit by {links} with {touch.force:.0f} N")
    return found
