"""What a robot touches in a world, and how hard: for a judge to see; and what two surfaces do that touch."""

from dataclasses import dataclass, field

import numpy as np

from topple.topology.base.arrays import FloatArray


@dataclass
class Touch:
    """How hard the robot touched one thing: the largest force in [N] and the impulse in [N s]."""

    force: float = 0.0
    impulse: float = 0.0
    links: set[str] = field(default_factory=set[str])


def rubbing(a: FloatArray, b: FloatArray) -> FloatArray:
    """What two surfaces that touch do against sliding, spinning and rolling, on every engine alike.

    It is Bullet's rule, which cannot be changed. A lever is what a surface has on one of coefficient 1: the
    moment about the normal is that of the friction across the dent, and what both give way adds.

    Args:
        a: (3, ...) Coulomb coefficient, levers of the moments about the normal and against rolling [m].
        b: (3, ...) of the other.

    Returns:
        (3, ...) of the pair: a moment is its lever times the normal force.
    """
    return np.stack([a[0] * b[0], *(a[1:] * b[0] + b[1:] * a[0])])


def note_touch(touched: dict[str, Touch], name: str, link: str, force: float, time_step: float) -> None:
    """Add one contact of the last step.

    Args:
        touched: By name of the thing; added to.
        name: What was touched.
        link: The robot's link that touched it.
        force: In [N].
        time_step: For how long in [s].
    """
    touch = touched.setdefault(name, Touch())
    touch.force = max(touch.force, force)
    touch.impulse += force * time_step
    touch.links.add(link)
