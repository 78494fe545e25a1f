"""Blocks scattered and partly stacked in the wrong order: build red on green on blue."""

import numpy as np
from scipy.spatial.transform import Rotation

from topple.robots.scenarios.scenario import Scenario, Unlucky, pose_at, settle, settled
from topple.robots.scenarios.tolerances import HAND_BETWEEN
from topple.robots.shapes import block
from topple.robots.world.bodies import Color
from topple.robots.world.physical_world import PhysicalWorld

SIDE = 0.05  # [m] a toy block; a Panda's hand opens 8 cm
COLORS: dict[str, Color] = {
    "red": (0.8, 0.15, 0.12, 1.0),
    "green": (0.15, 0.6, 0.2, 1.0),
    "blue": (0.15, 0.3, 0.75, 1.0),
    "yellow": (0.9, 0.8, 0.2, 1.0),
}
TOWER = ("red", "green", "blue")


def tower(seed: int = 0) -> Scenario:
    """Make the scene: four blocks in two or three stacks, never already the tower.

    Args:
        seed: Any number.

    Returns:
        The scenario: `red`, `green`, `blue`, `yellow`.
    """
    return settled("tower", seed, _lay_out, robot="panda")


def _lay_out(world: PhysicalWorld, rng: np.random.Generator) -> tuple[str, tuple[str, ...]]:
    order = [str(name) for name in rng.permutation(list(COLORS))]
    stacks = [order[:2], order[2:]] if rng.random() < 0.5 else [order[:2], [order[2]], [order[3]]]
    if any(stack[k : k + 2] == ["green", "red"] or stack[k : k + 2] == ["blue", "green"]
           for stack in stacks for k in range(len(stack) - 1)):  # fmt: skip
        raise Unlucky("a part of the tower stands already")
    places: list[np.ndarray] = []
    for stack in stacks:
        place = _free_place(places, rng)
        for level, name in enumerate(stack):
            aside = rng.uniform(-0.006, 0.006, 2) if level else np.zeros(2)
            turn = Rotation.from_euler(
                "z", rng.uniform(0, np.pi / 2) if level == 0 else rng.uniform(-0.3, 0.3)
            )
            height = level * (SIDE + 2e-4)
            world.add(
                block(name, SIDE, color=COLORS[name]),
                pose_at(place[0] + aside[0], place[1] + aside[1], height, turn),
            )
    settle(world)
    return "red on green on blue", TOWER


def _free_place(taken: list[np.ndarray], rng: np.random.Generator) -> np.ndarray:
    """(2,) a place on the table away from the others; it is noted in `taken`."""
    for _ in range(200):
        place = rng.uniform([-0.12, -0.22], [0.15, 0.22])
        if all(np.linalg.norm(place - other) > HAND_BETWEEN for other in taken):
            taken.append(place)
            return place
    raise Unlucky("no room for another stack")
