"""What a robot touches in a world, and how hard: for a judge to see."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from topple.robots.engine import pybullet
from topple.robots.world.world import World


@dataclass
class Touch:
    """How hard the robot touched one thing: the largest force in [N] and the impulse in [N s]."""

    force: float = 0.0
    impulse: float = 0.0
    links: set[str] = field(default_factory=set[str])


def note_touches(touched: dict[str, Touch], world: World, robot: int, links: Mapping[int, str]) -> None:
    """Add what a robot touched in the last step.

    Args:
        touched: By name of the thing; added to.
        world: The world.
        robot: PyBullet's number of the robot.
        links: Names of its links by PyBullet's number.
    """
    points: Any = pybullet.getContactPoints(bodyA=robot, physicsClientId=world.client)
    for point in points:
        name = world.name_of(point[2])
        if name is None or point[9] <= 0.0:
            continue
        touch = touched.setdefault(name, Touch())
        touch.force = max(touch.force, float(point[9]))
        touch.impulse += float(point[9]) * world.time_step
        touch.links.add(links[point[3]])
