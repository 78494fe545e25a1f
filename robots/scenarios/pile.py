"""Random settled piles of household objects, leaning, nested and stacked: free the one that carries most."""

from collections.abc import Callable

import numpy as np
from scipy.spatial.transform import Rotation

from topple.robots.scenarios.scenario import Scenario, Unlucky, contacts, drop, settle, settled
from topple.robots.shapes import ball, bar, bowl, box, can, mug, plate, spoon, tray
from topple.robots.world.bodies import Body, Color
from topple.robots.world.physical_world import PhysicalWorld

Maker = Callable[[str, np.random.Generator], Body]


def _box(name: str, rng: np.random.Generator) -> Body:
    size = np.sort(rng.uniform([0.03, 0.05, 0.08], [0.06, 0.075, 0.16]))[[2, 1, 0]]
    return box(name, (float(size[0]), float(size[1]), float(size[2])), density=rng.uniform(250, 700))


def _can(name: str, rng: np.random.Generator) -> Body:
    tall = rng.random() < 0.7
    return can(name) if tall else can(name, diameter=0.075, height=0.035)


KINDS: dict[str, tuple[float, Maker]] = {
    "box": (0.30, _box),
    "can": (0.18, _can),
    "ball": (0.06, lambda name, rng: ball(name, diameter=rng.uniform(0.05, 0.07))),
    "bowl": (0.08, lambda name, rng: bowl(name, diameter=rng.uniform(0.13, 0.16))),
    "plate": (0.08, lambda name, rng: plate(name, diameter=rng.uniform(0.18, 0.22))),
    "mug": (0.08, lambda name, rng: mug(name)),
    "spoon": (0.08, lambda name, rng: spoon(name)),
    "tray": (0.04, lambda name, rng: tray(name, (0.22, 0.16, 0.03))),
    "bar": (0.10, lambda name, rng: bar(name, (rng.uniform(0.15, 0.22), 0.03, 0.03))),
}
"""Share and maker of each kind; boxes and bars lean most."""
COLORS: tuple[Color, ...] = (
    (0.78, 0.33, 0.25, 1.0), (0.30, 0.50, 0.72, 1.0), (0.42, 0.62, 0.33, 1.0), (0.88, 0.68, 0.25, 1.0),
    (0.55, 0.40, 0.65, 1.0), (0.35, 0.62, 0.62, 1.0), (0.80, 0.55, 0.60, 1.0), (0.60, 0.55, 0.45, 1.0),
)  # fmt: skip


def pile(seed: int = 0) -> Scenario:
    """Make the scene: five to eight things dropped one after the other near the middle of the table.

    Args:
        seed: Any number.

    Returns:
        The scenario: things named `KIND_N`; the target is the one that touches most of what lies higher.
    """
    return settled("pile", seed, _lay_out)


def heap(world: PhysicalWorld, rng: np.random.Generator, count: int, spread: float = 0.07) -> tuple[str, ...]:
    """Drop random things on a pile.

    Args:
        world: A world with a table.
        rng: Where the randomness comes from.
        count: How many.
        spread: Standard deviation in [m] of the places they are dropped at.

    Returns:
        Their names.

    Raises:
        Unlucky: If something does not come to rest, or falls off the table.
    """
    shares = np.array([share for share, _ in KINDS.values()])
    names: list[str] = []
    for index in range(count):
        kind = str(rng.choice(list(KINDS), p=shares / shares.sum()))
        body = KINDS[kind][1](f"{kind}_{index}", rng).colored(COLORS[index % len(COLORS)])
        tip = rng.normal(0, 0.5) if rng.random() < 0.4 else 0.0
        turn = Rotation.from_euler("zyz", [rng.uniform(0, 2 * np.pi), tip, rng.uniform(0, 2 * np.pi)])
        x, y = np.clip(rng.normal(0, spread, 2), -0.16, 0.16).tolist()
        drop(world, body, x, y, turn)
        settle(world, 3.0)
        names.append(body.name)
    return tuple(names)


def _lay_out(world: PhysicalWorld, rng: np.random.Generator) -> tuple[str, tuple[str, ...]]:
    names = heap(world, rng, int(rng.integers(5, 9)))
    settle(world)
    target = _most_buried(world, names)
    return f"free {target}", (target,)


def _most_buried(world: PhysicalWorld, names: tuple[str, ...]) -> str:
    """The object that touches most others whose centre of mass is higher."""
    height = {
        name: float((world.pose(name) @ np.append(world.body(name).centre_of_mass, 1.0))[2]) for name in names
    }
    pairs = [tuple(pair) for pair in contacts(world) if len(pair) == 2]
    above = {name: 0 for name in names}
    for a, b in pairs:
        if a in height and b in height:
            above[a if height[a] < height[b] else b] += 1
    target = max(names, key=lambda name: above[name])
    if above[target] == 0:
        raise Unlucky("nothing lies on anything")
    return target
