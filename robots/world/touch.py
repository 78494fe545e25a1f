"""What a robot touches in a world, and how hard: for a judge to see; and what two surfaces do that touch."""

from collections.abc import Iterable
from dataclasses import dataclass, field

import numpy as np

from topple.robots.world.tolerances import BRUSH, CHATTER
from topple.topology.base.arrays import FloatArray


@dataclass
class Touch:
    """How hard the robot touched one thing.

    Attributes:
        force: The largest of a step, of all its contacts [N].
        impulse: Of all of it [N s].
        links: The robot's links that touched it.
        hit: The largest impulse of one touch, from when it began until it ended, of what pressed by more than
            a brush does [N s]. An engine of hard contacts has any force for a step where something is
            pinned; what that sets in motion, or would, is its impulse.
    """

    force: float = 0.0
    impulse: float = 0.0
    links: set[str] = field(default_factory=set[str])
    hit: float = 0.0
    _going: float = 0.0
    _apart: float = 0.0

    def press(self, force: float, time_step: float) -> None:
        """Go on by a time step [s] in which a force [N] presses, or none."""
        self.force = max(self.force, force)
        self.impulse += force * time_step
        self._apart = 0.0 if force > 0.0 else self._apart + time_step
        if self._apart > CHATTER:
            self._going = 0.0
        self._going += max(0.0, force - BRUSH) * time_step
        self.hit = max(self.hit, self._going)


def combined_friction(a: FloatArray, b: FloatArray) -> FloatArray:
    """Combine the friction of two surfaces against sliding, spinning and rolling, on every engine alike.

    It is Bullet's rule, which cannot be changed. A lever is what a surface has on one of coefficient 1: the
    moment about the normal is that of the friction across the dent, and what both give way adds.

    Args:
        a: (3, ...) Coulomb coefficient, levers of the moments about the normal and against rolling [m].
        b: (3, ...) of the other.

    Returns:
        (3, ...) of the pair: a moment is its lever times the normal force.
    """
    return np.stack([a[0] * b[0], *(a[1:] * b[0] + b[1:] * a[0])])


def note_touches(
    touched: dict[str, Touch], contacts: Iterable[tuple[str, str, float]], time_step: float
) -> None:
    """Add the contacts of the last step.

    Args:
        touched: By name of the thing; added to.
        contacts: What was touched, the robot's link that touched it, the force [N].
        time_step: For how long in [s].
    """
    pressed: dict[str, float] = {}
    for name, link, force in contacts:
        touched.setdefault(name, Touch()).links.add(link)
        pressed[name] = pressed.get(name, 0.0) + force
    for name, touch in touched.items():
        touch.press(pressed.get(name, 0.0), time_step)
