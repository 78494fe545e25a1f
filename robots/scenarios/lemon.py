"""A bowl full of fruit and a can, a lemon beside it: the lemon belongs in the bowl."""

from collections.abc import Callable

import numpy as np
from scipy.spatial.transform import Rotation

from topple.robots.scenarios.scenario import Scenario, Unlucky, drop, pose_at, settle, settled
from topple.robots.shapes import apple, bowl, can, lemon, orange, pear, plum, strawberry
from topple.robots.world.bodies import Body
from topple.robots.world.physical_world import PhysicalWorld

CONTENTS: dict[str, Callable[[str], Body]] = {
    "apple": lambda name: apple(name, diameter=0.068),
    "orange": lambda name: orange(name, diameter=0.068),
    "can": lambda name: can(name, diameter=0.053, height=0.075, color=(0.2, 0.45, 0.3, 1.0)),
    "pear": lambda name: pear(name, diameter=0.06, length=0.085),
    "plum": plum,
    "strawberry": strawberry,
}
"""A small can of tomato paste and fruit that a hand of 8 cm can take."""


def lemon_in_bowl(seed: int = 0) -> Scenario:
    """Make the scene: four to six things in a salad bowl, so that nothing more stays in it.

    Args:
        seed: Any number.

    Returns:
        The scenario: `bowl`, `lemon`, and what is in the bowl.
    """
    return settled("lemon", seed, _lay_out, robot="panda")


def _lay_out(world: PhysicalWorld, rng: np.random.Generator) -> tuple[str, tuple[str, ...]]:
    middle = np.array([rng.uniform(-0.04, 0.06), rng.uniform(-0.08, 0.08)])
    diameter = 0.19
    world.add(bowl(diameter=diameter, height=0.07, sides=24), pose_at(middle[0], middle[1], 0.0))
    away = rng.uniform(0, 2 * np.pi)
    beside = middle + rng.uniform(0.19, 0.23) * np.array([np.cos(away), np.sin(away)])
    world.add(lemon(), pose_at(beside[0], beside[1], 0.001, Rotation.from_euler("z", rng.uniform(0, np.pi))))
    kinds = [str(kind) for kind in rng.permutation(list(CONTENTS))[: rng.integers(4, 7)]]
    for slot, kind in enumerate(kinds):
        angle = slot * 2 * np.pi / 3 + rng.uniform(-0.3, 0.3)
        reach = 0.045 if slot < 3 else 0.015
        place = middle + reach * np.array([np.cos(angle), np.sin(angle)])
        turn = Rotation.from_euler("z", rng.uniform(0, 2 * np.pi))
        drop(world, CONTENTS[kind](kind), float(place[0]), float(place[1]), turn)
        settle(world, 2.5)
    settle(world)
    for kind in kinds:
        centre = world.pose(kind) @ np.append(world.body(kind).centre_of_mass, 1.0)
        if np.linalg.norm(centre[:2] - world.pose("bowl")[:2, 3]) > diameter / 2 - 0.01:
            raise Unlucky(f"{kind} fell out of the bowl")
    if np.linalg.norm(world.pose("lemon")[:2, 3] - world.pose("bowl")[:2, 3]) < diameter / 2 + 0.06:
        raise Unlucky("the lemon lies at the bowl")
    return "lemon within bowl", ("lemon", "bowl")
