"""A book flat on a table, wider than a hand opens, among a few other things: put it on a carton."""

from functools import partial

import numpy as np
from scipy.spatial.transform import Rotation

from topple.robots.scenarios.scenario import TABLE, Scenario, Unlucky, drop, pose_at, settle, settled
from topple.robots.scenarios.tolerances import ASIDE, CARTON, HAND_BETWEEN, PLACES
from topple.robots.shapes import block, book, box, can, mug
from topple.robots.world.physical_world import PhysicalWorld
from topple.topology.arrays import FloatArray

THINGS = (can, mug, lambda: block("block"))


def edge(seed: int = 0) -> Scenario:
    """Make the scene: the robot stands beside a long edge of the table, on its left or on its right.

    Args:
        seed: Any number; odd ones have the edge on the left.

    Returns:
        The scenario: `book`, which no jaw takes where it lies, the `carton` that it shall lie on, one of
        `can`, `mug` and `block` beside it, and on every third seed another one on it.
    """
    left = 1.0 if seed % 2 else -1.0
    table = TABLE, (-0.05, left * (ASIDE - TABLE[1] / 2))
    return settled("edge", seed, partial(_layout, left=left, on=seed % 3 == 0), robot="panda", table=table)


def _layout(
    world: PhysicalWorld, rng: np.random.Generator, *, left: float, on: bool
) -> tuple[str, tuple[str, ...]]:
    long, short, thick = rng.uniform([0.17, 0.12, 0.022], [0.20, 0.14, 0.036]).tolist()
    turn = float(rng.choice([0.0, np.pi / 2]) + rng.uniform(-0.25, 0.25))
    deep = abs(long * np.sin(turn)) + abs(short * np.cos(turn))  # square to the table's edge
    middle = np.array([rng.uniform(-0.20, -0.07), left * (ASIDE - deep / 2 - rng.uniform(0.01, 0.08))])
    world.add(
        book("book", (long, short, thick)),
        pose_at(float(middle[0]), float(middle[1]), 0.0, Rotation.from_euler("z", turn)),
    )
    taken = [middle]
    bodies = [box("carton", CARTON), *(THINGS[k]() for k in rng.permutation(len(THINGS))[: 1 + on])]
    for number, body in enumerate(bodies):
        if number == 2:
            place = middle + rng.uniform(-0.02, 0.02, 2)
        else:
            place = _beside(taken, left, *PLACES[number], rng)
            taken.append(place)
        heading = Rotation.from_euler("z", rng.uniform(0, 2 * np.pi))
        drop(world, body, float(place[0]), float(place[1]), heading)
    settle(world)
    return "book on carton", ("book",)


def _beside(
    taken: list[FloatArray],
    left: float,
    low: tuple[float, float],
    high: tuple[float, float],
    clear: float,
    rng: np.random.Generator,
) -> FloatArray:
    """(2,) a place in a part of the table, clear of the book, whose middle is first, and of the others."""
    for _ in range(200):
        place = rng.uniform(low, high) * [1.0, left]
        far = [np.linalg.norm(place - other) for other in taken]
        if far[0] > clear and all(each > 1.5 * HAND_BETWEEN for each in far[1:]):
            return place
    raise Unlucky("no room for another thing")
