"""A plate under two spoons and a fork, and a can that leans on its rim: free the plate."""

import numpy as np
from scipy.spatial.transform import Rotation

from topple.robots.scenarios.scenario import Scenario, Unlucky, contacts, overlap, pose_at, settle, settled
from topple.robots.scenarios.tolerances import RIM
from topple.robots.shapes import can, fork, plate, spoon
from topple.robots.world.physical_world import PhysicalWorld
from topple.topology.base.arrays import FloatArray

CUTLERY = ("spoon_1", "spoon_2", "fork")


def dishes(seed: int = 0) -> Scenario:
    """Make the scene.

    Cutlery lies with its head in the well and its handle across the rim; the can stands on the edge of its
    bottom and leans its side on the rim, between two handles.

    Args:
        seed: Any number.

    Returns:
        The scenario: `plate`, `spoon_1`, `spoon_2`, `fork`, `can`.
    """
    return settled("dishes", seed, _lay_out)


def _lay_out(world: PhysicalWorld, rng: np.random.Generator) -> tuple[str, tuple[str, ...]]:
    diameter = rng.uniform(0.24, 0.26)
    middle = np.array([rng.uniform(-0.03, 0.03), rng.uniform(-0.04, 0.04), 0.0])
    world.add(plate(diameter=diameter, height=RIM), pose_at(*middle))
    first = rng.uniform(0, 2 * np.pi)
    order = rng.permutation(len(CUTLERY))
    for slot, which in enumerate(order):
        name = CUTLERY[which]
        angle = first + slot * 2 * np.pi / 3 + rng.uniform(-0.25, 0.25)
        body = fork(name) if name == "fork" else spoon(name, length=rng.uniform(0.185, 0.2))
        world.add(body, _across_rim(middle, angle, rng))
    gap = first + (rng.integers(3) + 0.5) * 2 * np.pi / 3
    world.add(can(height=rng.uniform(0.09, 0.11)), _leaning_pose(middle, diameter / 2, gap, rng))
    if overlap(world) > 5e-4:
        raise Unlucky("two things would be in the same place")
    settle(world)
    _check(world)
    return "free plate", ("plate",)


def _across_rim(middle: FloatArray, angle: float, rng: np.random.Generator) -> FloatArray:
    """(4, 4) pose of a spoon or fork whose handle points outwards at an angle."""
    out = np.array([np.cos(angle), np.sin(angle)])
    place = middle[:2] + rng.uniform(0.105, 0.115) * out + rng.uniform(-0.008, 0.008) * out[::-1] * [-1, 1]
    turn = Rotation.from_euler("ZY", [angle + rng.uniform(-0.15, 0.15), -0.07])
    return pose_at(place[0], place[1], 0.0185, turn)


def _leaning_pose(middle: FloatArray, radius: float, angle: float, rng: np.random.Generator) -> FloatArray:
    """(4, 4) pose of a can with its bottom's edge on the table and its side on the rim."""
    rise = np.radians(rng.uniform(18, 38))  # of the can's axis above the table, pointing over the plate
    lowest = radius + (RIM + 0.001) / np.tan(rise)  # where the edge stands, from the plate's middle
    axis_from_edge = 0.033 * np.array([np.sin(rise), np.cos(rise)])  # outwards, up
    place = middle[:2] + (lowest + axis_from_edge[0]) * np.array([np.cos(angle), np.sin(angle)])
    turn = Rotation.from_euler("ZY", [angle, rise - np.pi / 2])
    return pose_at(place[0], place[1], axis_from_edge[1] + 0.001, turn)


def _check(world: PhysicalWorld) -> None:
    """Everything lies as it should."""
    touches = contacts(world)
    for name in CUTLERY:
        if frozenset((name, "plate")) not in touches or frozenset((name, "table")) in touches:
            raise Unlucky(f"{name} slid off the plate")
    tilt = np.degrees(np.arccos(np.clip(world.pose("can")[2, 2], -1, 1)))
    if frozenset(("can", "plate")) not in touches or not 20 < tilt < 80:
        raise Unlucky("the can does not lean on the plate")
    if any(frozenset(("can", name)) in touches for name in CUTLERY):
        raise Unlucky("the can touches cutlery")
