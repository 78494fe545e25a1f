"""What a robot touches in a world, and how hard: for a judge to see."""

from dataclasses import dataclass, field


@dataclass
class Touch:
    """How hard the robot touched one thing: the largest force in [N] and the impulse in [N s]."""

    force: float = 0.0
    impulse: float = 0.0
    links: set[str] = field(default_factory=set[str])


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
