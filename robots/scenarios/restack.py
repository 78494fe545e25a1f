"""Blocks in two towers, to be rebuilt as two other towers: which goes where, and what has to wait aside."""

import numpy as np
from scipy.spatial.transform import Rotation

from topple.robots.scenarios.scenario import Scenario, Unlucky, lay, pose_at, to_copy
from topple.robots.scenarios.tower import COLORS, SIDE
from topple.robots.shapes import block
from topple.robots.world.bodies import Color
from topple.robots.world.physical_world import PhysicalWorld
from topple.topology.base.arrays import FloatArray

BLOCKS: dict[str, Color] = {**COLORS, "white": (0.9, 0.9, 0.88, 1.0)}
APART = (0.16, 0.22)  # [m] between the towers: a hand goes between them


def restack(seed: int = 0) -> Scenario:
    """Make the scene: five blocks in towers of three and two, to be towers of three and two others there.

    Args:
        seed: Any number.

    Returns:
        The scenario: `red`, `green`, `blue`, `yellow`, `white`.
    """
    return to_copy("restack", seed, _lay_out)


def _lay_out(
    world: PhysicalWorld, finished: PhysicalWorld, rng: np.random.Generator
) -> tuple[str, tuple[str, ...]]:
    names = list(BLOCKS)
    first, then = ([str(name) for name in rng.permutation(names)] for _ in range(2))
    towers, wanted = (first[:3], first[3:]), (then[:3], then[3:])
    if all(a[0] == b[0] for a, b in zip(towers, wanted, strict=True)):
        raise Unlucky("both towers keep their foot")
    middle, turn = rng.uniform([-0.05, -0.06], [0.04, 0.06]), rng.uniform(np.pi / 3, 2 * np.pi / 3)
    out = rng.uniform(*APART) / 2 * np.array([np.cos(turn), np.sin(turn)])
    places = (middle + out, middle - out)
    for here, stacks in ((world, towers), (finished, wanted)):
        poses = {}
        for place, stack in zip(places, stacks, strict=True):
            heading = rng.uniform(0, np.pi / 2)
            for level, name in enumerate(stack):
                body = block(name, SIDE, color=BLOCKS[name])
                poses[body] = _pose(place, level, heading + rng.uniform(-0.2, 0.2), rng)
        lay(here, poses)
    said = [" on ".join([*reversed(stack), "table"]) for stack in wanted]
    return ", ".join(said), tuple(names)


def _pose(place: FloatArray, level: int, heading: float, rng: np.random.Generator) -> FloatArray:
    """(4, 4) pose of a block on a level of a tower, not quite over the one below."""
    x, y = place + (rng.uniform(-0.004, 0.004, 2) if level else 0.0)
    return pose_at(float(x), float(y), level * (SIDE + 2e-4), Rotation.from_euler("z", heading))
