"""A shelf of two bays, open at the front: free what stands behind the others."""

from dataclasses import replace

import numpy as np
from scipy.spatial.transform import Rotation

from topple.robots.scenarios.scenario import Scenario, Unlucky, lay, pose_at, settled
from topple.robots.shapes import box, can, mug, tin
from topple.robots.shapes.materials import PAINTS, WOOD
from topple.robots.world.bodies import Body
from topple.robots.world.camera import Camera
from topple.robots.world.physical_world import PhysicalWorld
from topple.topology.base.arrays import FloatArray

INNER = (0.25, 0.56, 0.25)  # [m] of a bay: depth, width and height
BOARD = 0.016  # [m] thick, and the walls too
FRONT, FEET = 0.04, 0.06  # [m] x of the open side, and height of the lower board's underside
COLUMNS = (-0.16, 0.0, 0.16)  # [m] along the boards: a hand closes between two of them
ROWS = (0.055, 0.125, 0.195)  # [m] behind the front
JITTER = 0.008  # [m]
EYES = ((-0.70, 0.58, 0.42), (-0.70, -0.58, 0.42), (-0.45, 0.45, 1.0))  # [m]
LOOK_AT = (0.05, 0.0, 0.22)  # [m]


def shelf(seed: int = 0) -> Scenario:
    """Make the scene: five to nine things in the bays, up to two of them before the target.

    Args:
        seed: Any number; its remainder by three is how many stand before the target.

    Returns:
        The scenario: boxes, cans, jars, mugs and tins, in a `shelf` that stands on the table.
    """
    made = settled("shelf", seed, lambda world, rng: _lay_out(world, rng, seed % len(ROWS)), robot="panda")
    return replace(made, cameras=tuple(Camera.looking_at(eye, LOOK_AT) for eye in EYES))


def _lay_out(world: PhysicalWorld, rng: np.random.Generator, before: int) -> tuple[str, tuple[str, ...]]:
    world.add(_furniture(), pose_at(FRONT + INNER[0] / 2, 0.0, FEET), fixed=True)
    spots = [(bay, column, row) for bay in range(2) for column in COLUMNS for row in range(len(ROWS))]
    bay, column = int(rng.integers(2)), COLUMNS[int(rng.integers(len(COLUMNS)))]
    chosen = [(bay, column, row) for row in range(before, -1, -1)]
    behind = [(bay, column, row) for row in range(before + 1, len(ROWS))]
    others = [spot for spot in spots if spot not in (*chosen, *behind)]
    picked = rng.permutation(len(others))[: int(rng.integers(5, 10)) - len(chosen)].tolist()
    chosen += [others[k] for k in picked]
    places = {_make_body(number, rng): _pose(spot, rng) for number, spot in enumerate(chosen)}
    lay(world, places)
    upright = (world.pose(body.name)[2, 2] for body in places)
    if min(upright) < 0.99:
        raise Unlucky("something lies down")
    target = next(iter(places)).name
    return f"free {target}", (target,)


def _furniture() -> Body:
    """Two boards, a top, a back and side walls; the middle of the lower board's underside is the origin."""
    deep, wide, high = INNER
    tall = 2 * high + 3 * BOARD
    slabs = [((deep, wide, BOARD), (0.0, 0.0, level * (high + BOARD))) for level in range(3)]
    slabs += [((deep, BOARD, tall + FEET), (0.0, side * (wide + BOARD) / 2, -FEET)) for side in (-1.0, 1.0)]
    slabs += [((BOARD, wide + 2 * BOARD, tall), ((deep + BOARD) / 2, 0.0, 0.0))]
    parts = [box("slab", size).parts[0] + np.array(place) for size, place in slabs]
    return Body.of("shelf", parts, density=WOOD.density, rolling=0.0, color=PAINTS["pine"], kind="shelf")


def _make_body(number: int, rng: np.random.Generator) -> Body:
    kind = int(rng.integers(5))
    shade = (*rng.uniform(0.25, 0.85, 3).tolist(), 1.0)
    high = float(rng.uniform(0.09, 0.14))
    if kind == 0:
        return box(f"box_{number}", (0.045, 0.055, high), color=shade)
    if kind == 1:
        return can(f"can_{number}", diameter=0.062, height=high, color=shade)
    if kind == 2:
        return can(f"jar_{number}", diameter=0.054, height=high, color=PAINTS["glass"])
    if kind == 3:
        return mug(f"mug_{number}", diameter=0.064, height=0.09)
    return tin(f"tin_{number}", (0.05, 0.06, high), color=shade)


def _pose(spot: tuple[int, float, int], rng: np.random.Generator) -> FloatArray:
    bay, column, row = spot
    aside = rng.uniform(-JITTER, JITTER, 2)
    height = FEET + BOARD + bay * (INNER[2] + BOARD)
    turn = Rotation.from_euler("z", rng.uniform(-0.3, 0.3))
    return pose_at(FRONT + ROWS[row] + aside[0], column + aside[1], height, turn)
