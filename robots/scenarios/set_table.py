"""A plate with cutlery on it, a bowl and a mug, in a heap: lay the table for one."""

import numpy as np
from scipy.spatial.transform import Rotation

from topple.robots.scenarios.scenario import Scenario, Unlucky, contacts, lay, pose_at, to_copy
from topple.robots.scenarios.tolerances import RIM
from topple.robots.shapes import bowl, fork, mug, plate, spoon
from topple.robots.world.physical_world import PhysicalWorld
from topple.topology.base.arrays import FloatArray

WELL = 0.0065  # [m] height of what lies in the plate
BESIDE = 0.045  # [m] from the plate's edge to the cutlery: a hand gets down between them


def set_table(seed: int = 0) -> Scenario:
    """Make the scene: fork and spoon across a plate, a bowl and a mug where the table shall be laid.

    Args:
        seed: Any number.

    Returns:
        The scenario: `plate`, `bowl`, `fork`, `spoon`, `mug`. The plate shall lie elsewhere with the bowl on
        it, the fork to its left, the spoon to its right and the mug behind.
    """
    return to_copy("set-table", seed, _lay_out, robot="panda-suction")


def _lay_out(
    world: PhysicalWorld, finished: PhysicalWorld, rng: np.random.Generator
) -> tuple[str, tuple[str, ...]]:
    diameter = rng.uniform(0.21, 0.23)
    bodies = {
        body.name: body
        for body in (
            plate(diameter=diameter, height=RIM),
            bowl(diameter=rng.uniform(0.13, 0.145)),
            fork(length=0.185),
            spoon(length=0.185),
            mug(),
        )
    }
    side = float(rng.choice([-1.0, 1.0]))
    heap = np.array([rng.uniform(-0.05, 0.0), -side * rng.uniform(0.20, 0.24)])
    laid = np.array([rng.uniform(-0.06, -0.02), side * rng.uniform(0.13, 0.16)])
    lay(finished, {bodies[name]: pose for name, pose in _laid(laid, diameter, rng).items()})
    lay(world, {bodies[name]: pose for name, pose in _heap_poses(heap, laid, diameter, rng).items()})
    touches = contacts(world)
    for name in ("fork", "spoon"):
        if frozenset((name, "plate")) not in touches or frozenset((name, "table")) in touches:
            raise Unlucky(f"{name} slid off the plate")
    said = "plate on table, bowl on plate, fork on table, spoon on table, mug on table"
    return said, tuple(bodies)


def _laid(middle: FloatArray, diameter: float, rng: np.random.Generator) -> dict[str, FloatArray]:
    """Poses (4, 4) on the laid table, seen by who sits opposite the robot; handles point to them."""
    x, y = middle.tolist()
    beside = diameter / 2 + BESIDE
    return {
        "plate": pose_at(x, y, 0.0),
        "bowl": pose_at(x, y, WELL + 1e-3),
        "fork": pose_at(x, y - beside, 2e-4),
        "spoon": pose_at(x, y + beside, 2e-4),
        "mug": pose_at(x - 0.17, y + 0.10, 0.0, Rotation.from_euler("z", np.pi + rng.uniform(-0.5, 0.5))),
    }


def _heap_poses(
    heap: FloatArray, laid: FloatArray, diameter: float, rng: np.random.Generator
) -> dict[str, FloatArray]:
    """Poses (4, 4) at the start: cutlery across the plate, bowl and mug where the table shall be laid."""
    first = rng.uniform(0, 2 * np.pi)
    across: dict[str, FloatArray] = {}
    for name, angle in (("fork", first), ("spoon", first + rng.uniform(1.2, 2.2))):
        out = np.array([np.cos(angle), np.sin(angle)])
        x, y = heap + (diameter / 2 - rng.uniform(0.01, 0.02)) * out
        across[name] = pose_at(float(x), float(y), 0.0185, Rotation.from_euler("ZY", [angle, -0.07]))
    places = laid + np.array([[rng.uniform(0.02, 0.06), -0.09], [rng.uniform(-0.06, -0.02), 0.09]])
    (bx, by), (mx, my) = rng.permutation(places).tolist()
    return {
        "plate": pose_at(float(heap[0]), float(heap[1]), 0.0),
        **across,
        "bowl": pose_at(bx, by, 0.0),
        "mug": pose_at(mx, my, 0.0, Rotation.from_euler("z", rng.uniform(0, 2 * np.pi))),
    }
