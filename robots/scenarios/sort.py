"""Cans and fruit in a pile between two bins: each kind belongs in its own."""

from collections.abc import Callable

import numpy as np
from scipy.spatial.transform import Rotation

from topple.robots.scenarios.scenario import Scenario, Unlucky, drop, pose_at, settle, settled
from topple.robots.shapes import apple, can, lemon, orange, plum, tray
from topple.robots.world.bodies import Body
from topple.robots.world.physical_world import PhysicalWorld

BIN = (0.26, 0.18, 0.05)  # [m]
ASIDE = 0.30  # [m] of the bins from the middle
CANS: tuple[Callable[[str], Body], ...] = (
    lambda name: can(name, diameter=0.06, height=0.09),
    lambda name: can(name, diameter=0.053, height=0.075, color=(0.2, 0.45, 0.3, 1.0)),
    lambda name: can(name, diameter=0.072, height=0.035, color=(0.25, 0.35, 0.6, 1.0)),
)
FRUIT: tuple[Callable[[str], Body], ...] = (
    lambda name: apple(name, diameter=0.068),
    lambda name: orange(name, diameter=0.066),
    plum,
    lemon,
)


def sort(seed: int = 0) -> Scenario:
    """Make the scene: two or three cans, as many fruits, and bins that are bolted to the table.

    Args:
        seed: Any number.

    Returns:
        The scenario: things named `can_N` and `fruit_N`, `bin_can` and `bin_fruit`.
    """
    return settled("sort", seed, _lay_out, robot="panda")


def _lay_out(world: PhysicalWorld, rng: np.random.Generator) -> tuple[str, tuple[str, ...]]:
    left, right = rng.permutation(["bin_can", "bin_fruit"])
    for name, y in ((str(left), ASIDE), (str(right), -ASIDE)):
        color = (0.55, 0.35, 0.35, 1.0) if name == "bin_can" else (0.45, 0.6, 0.35, 1.0)
        world.add(tray(name, BIN, color=color), pose_at(0.02, y, 0.0), fixed=True)
    names: list[str] = []
    kinds = [("can", CANS)] * int(rng.integers(2, 4)) + [("fruit", FRUIT)] * int(rng.integers(2, 4))
    for index in rng.permutation(len(kinds)).tolist():
        kind, makers = kinds[index]
        body = makers[int(rng.integers(len(makers)))](f"{kind}_{len(names)}")
        turn = Rotation.from_euler("z", rng.uniform(0, 2 * np.pi))
        if kind == "can" and rng.random() < 0.4:
            turn = turn * Rotation.from_euler("y", np.pi / 2)
        x, y = rng.uniform(-0.08, 0.08, 2).tolist()
        drop(world, body, x, y, turn)
        settle(world, 3.0)
        names.append(body.name)
    for name in names:
        if np.abs(world.pose(name)[:2, 3]).max() > ASIDE - BIN[1] / 2 - 0.05:
            raise Unlucky(f"{name} rolled to the bins")
    return "sort", tuple(names)
