"""Objects strewn over a table, to be packed in a tray: flat ones first, others on top of them."""

import numpy as np
from scipy.spatial.transform import Rotation

from topple.robots.scenarios.scenario import Scenario, Unlucky, lay, pose_at, to_copy
from topple.robots.scenarios.tolerances import HAND_BETWEEN
from topple.robots.shapes import box, can, tray
from topple.robots.world.bodies import Body
from topple.robots.world.physical_world import PhysicalWorld
from topple.topology.base.arrays import FloatArray

TRAY = (0.34, 0.24, 0.03)  # [m]
FLAT = (0.14, 0.065, 0.035)  # [m] a carton of tea, lying
ASIDE = 0.17  # [m] from the middle of the tray to the nearest thing beside it


def pack(seed: int = 0) -> Scenario:
    """Make the scene: two flat cartons, a smaller carton and a can beside a tray bolted to the table.

    Args:
        seed: Any number.

    Returns:
        The scenario: `tea` and `rice`, which shall lie in `tray`, `cocoa` on one of them and `can` on the
        other.
    """
    return to_copy("pack", seed, _lay_out)


def _lay_out(
    world: PhysicalWorld, finished: PhysicalWorld, rng: np.random.Generator
) -> tuple[str, tuple[str, ...]]:
    flat = [box("tea", FLAT, color=(0.30, 0.55, 0.35, 1.0)), box("rice", FLAT, color=(0.85, 0.80, 0.65, 1.0))]
    tops = [
        box("cocoa", (0.09, 0.055, 0.05), color=(0.45, 0.28, 0.18, 1.0)),
        can("can", diameter=0.055, height=0.08),
    ]
    side = float(rng.choice([-1.0, 1.0]))
    middle = np.array([rng.uniform(-0.06, 0.0), side * rng.uniform(0.20, 0.23)])
    for each in (world, finished):
        each.add(tray("tray", TRAY), pose_at(middle[0], middle[1], 0.0), fixed=True)
    order = rng.permutation(2)
    packed: dict[Body, FloatArray] = {}
    for slot, (low, high) in enumerate(zip(flat, (tops[k] for k in order), strict=True)):
        x = middle[0] + (slot - 0.5) * 0.14
        upright = Rotation.from_euler("z", np.pi / 2)
        packed[low] = pose_at(x, middle[1], 0.006, upright)
        packed[high] = pose_at(x, middle[1] + rng.uniform(-0.02, 0.02), 0.006 + FLAT[2] + 5e-4, upright)
    lay(finished, packed)
    strewn: list[FloatArray] = []
    start = {body: _free_pose(strewn, side, rng) for body in packed}
    lay(world, start)
    lower, upper = (flat[0].name, flat[1].name), tuple(tops[k].name for k in order)
    said = [f"{high} on {low}" for high, low in zip(upper, lower, strict=True)]
    return ", ".join([*(f"{low} within tray" for low in lower), *said]), (*lower, *upper)


def _free_pose(taken: list[FloatArray], side: float, rng: np.random.Generator) -> FloatArray:
    """(4, 4) a free pose on the table beside the tray; it is noted in `taken`."""
    for _ in range(200):
        x, y = rng.uniform(-0.16, 0.12), -side * rng.uniform(-0.05, 0.26)
        pose = pose_at(x, y, 0.0, Rotation.from_euler("z", rng.uniform(0, np.pi)))
        if all(np.linalg.norm((pose - other)[:2, 3]) > HAND_BETWEEN for other in taken):
            taken.append(pose)
            return pose
    raise Unlucky("no room for another thing")
