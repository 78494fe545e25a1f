"""Objects that stand only together, for two arms: packets, a plank on a trestle, a can in a leaning bowl."""

from dataclasses import replace

import numpy as np
from scipy.spatial.transform import Rotation

from topple.robots.poses import angle_between
from topple.robots.scenarios.scenario import Scenario, Unlucky, pose_at, settle, settled
from topple.robots.scenarios.tolerances import CLEARLY, COMES_BACK, LEANING, LEANS, SECOND_ARM, SLID
from topple.robots.shapes import bowl, box, can
from topple.robots.shapes.materials import CARD, WOOD
from topple.robots.world.bodies import Color
from topple.robots.world.physical_world import PhysicalWorld
from topple.topology.base.arrays import FloatArray

PAINT: dict[str, Color] = {
    "left": (0.8, 0.35, 0.2, 1.0),
    "right": (0.2, 0.45, 0.7, 1.0),
    "plank": (0.82, 0.68, 0.47, 1.0),
    "trestle": (0.45, 0.35, 0.28, 1.0),
    "load": (0.8, 0.15, 0.12, 1.0),
    "weight": (0.15, 0.6, 0.2, 1.0),
    "board": (0.82, 0.68, 0.47, 1.0),
}


def hold(seed: int = 0) -> Scenario:
    """Make the scene: of even seeds two flat packets that lean on each other, of odd ones a loaded plank.

    Of every tenth seed, 9, 19 and so on, it is a can in a bowl that leans.

    The packets overlap along a part of their upper edges, so that each has an edge of its own for a hand.
    The plank lies across a narrow trestle with a box near either end and tips as soon as one is gone.
    The bowl stands over the edge of a board, and the weight of the can leans it down to the table: as the can
    is lifted out it comes back.

    Args:
        seed: Any number.

    Returns:
        The scenario: `left`, `right`; `trestle`, `plank`, `load`, `weight`; or `board`, `bowl`, `can`.
    """
    layout = _bowl if seed % 10 == LEANING else _plank if seed % 2 else _packets
    made = settled("hold", seed, layout, robot="panda")
    around = pose_at(0.0, 0.0, 0.0, Rotation.from_euler("z", SECOND_ARM))
    return replace(made, pose_second_to_world=around @ made.pose_base_to_world)


def _packets(world: PhysicalWorld, rng: np.random.Generator) -> tuple[str, tuple[str, ...]]:
    tilt, aside = rng.uniform(0.50, 0.58), rng.choice([-1, 1]) * rng.uniform(0.06, 0.072)
    thick, wide, high = rng.uniform([0.028, 0.17, 0.18], [0.034, 0.20, 0.21]).tolist()
    about = _somewhere(rng)
    foot = high * np.sin(tilt) + thick / 2 * np.cos(tilt)  # the upper edges meet above the middle
    low = thick / 2 * np.sin(tilt)
    for name, side in (("left", -1), ("right", 1)):
        lean = pose_at(side * foot, side * aside, low, Rotation.from_euler("y", -side * tilt))
        body = box(name, (thick, wide, high), density=rng.uniform(150, 350), color=PAINT[name])
        world.add(body, about @ lean)
    return _stand_up(world, "free left" if rng.random() < 0.5 else "free right")


def _plank(world: PhysicalWorld, rng: np.random.Generator) -> tuple[str, tuple[str, ...]]:
    long, wide, thick = rng.uniform([0.34, 0.045, 0.012], [0.40, 0.06, 0.018])
    narrow, high = rng.uniform([0.025, 0.08], [0.035, 0.10])
    about = _somewhere(rng)
    beam = {"trestle": (narrow, 0.12, high), "plank": (long, wide, thick)}
    for (name, size), z in zip(beam.items(), (0.0, high + 2e-4), strict=True):
        world.add(box(name, size, density=WOOD.density, color=PAINT[name]), about @ pose_at(0.0, 0.0, z))
    heights = rng.uniform(0.07, 0.09, 2)
    levers = (long / 2 - 0.04) * heights.min() / heights  # as heavy as they are tall, they balance
    for name, side, lever, tall in zip(("load", "weight"), (-1, 1), levers, heights, strict=True):
        body = box(name, (0.05, 0.05, tall), density=2 * CARD.density, color=PAINT[name])
        world.add(body, about @ pose_at(side * lever, 0.0, high + thick + 4e-4))
    return _stand_up(world, "free plank")


def _bowl(world: PhysicalWorld, rng: np.random.Generator) -> tuple[str, tuple[str, ...]]:
    wide, high, thick = rng.uniform([0.18, 0.05, 0.009], [0.21, 0.06, 0.013]).tolist()
    about, inside = _somewhere(rng), rng.uniform(0.020, 0.026)  # [m] of its middle, before the board's edge
    world.add(box("board", (0.12, 0.14, thick), density=WOOD.density, color=PAINT["board"]), about)
    edge = about @ pose_at(0.06, 0.0, thick + 1e-3)
    lean = edge @ pose_at(0.0, 0.0, 0.0, Rotation.from_euler("y", rng.uniform(0.45, 0.64)))
    hollow = bowl("bowl", diameter=wide, height=high)
    world.add(hollow, lean @ pose_at(-inside, 0.0, 0.0))
    across, tall, mass = rng.uniform([0.058, 0.085, 0.40], [0.068, 0.105, 0.50]).tolist()
    low = wide / 4 - across / 2 + rng.uniform(0.005, 0.017)  # towards the lower side of its base
    heavy = can("can", diameter=across, height=tall, mass=mass)
    world.add(heavy, lean @ pose_at(low - inside, 0.0, 0.009))
    settle(world)
    before = world.poses()
    if before["bowl"][2, 2] > np.cos(LEANS) or before["can"][2, 2] < np.cos(2 * LEANS):
        raise Unlucky("the can does not lean the bowl over, or lies in it")
    middle = np.linalg.solve(edge, before["bowl"] @ [*hollow.centre_of_mass, 1.0])
    if middle[0] > -CLEARLY:
        raise Unlucky("the bowl leans by itself, or nearly")
    away = before["can"].copy()
    away[0, 3] += 2.0  # beside the table
    world.place("can", away)
    world.step(round(COMES_BACK / world.time_step))
    alone = angle_between(before["bowl"], world.pose("bowl"))
    for name, pose in before.items():
        world.place(name, pose)
    if alone < LEANS:
        raise Unlucky("the bowl leans without the can")
    return "free bowl", ("bowl",)


def _somewhere(rng: np.random.Generator) -> FloatArray:
    """(4, 4) where it is put together, and which way round."""
    x, y, yaw = rng.uniform([-0.03, -0.03, -0.3], [0.03, 0.03, 0.3]).tolist()
    return pose_at(x, y, 0.0, Rotation.from_euler("z", yaw))


def _stand_up(world: PhysicalWorld, goal: str) -> tuple[str, tuple[str, ...]]:
    """Goal and target, once everything stands as it was put together.

    Raises:
        Unlucky: If something does not.
    """
    before = world.poses()
    settle(world)
    for name, pose in world.poses().items():
        if np.linalg.norm((pose - before[name])[:3, 3]) > SLID:
            raise Unlucky(f"{name} does not stay where it was put")
    return goal, (goal.partition(" ")[2],)
