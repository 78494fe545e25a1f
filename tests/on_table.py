"""Clouds of bodies on a table, seen from all around, for tests that need a scene and no camera."""

import numpy as np
from scipy.spatial.transform import Rotation

from topple.robots.shapes import box
from topple.robots.world.bodies import Body
from topple.topology.base.arrays import FloatArray
from topple.topology.scene.scene import Scene

BASE = np.eye(4)
BASE[0, 3] = -0.5  # where an arm stands that reaches what is about the origin


def table(half: float = 0.45, step: float = 0.008, x: float = 0.0) -> FloatArray:
    """Points (N, 3) of a square top at height 0, by half of its edge, their spacing and its middle in [m]."""
    axis = np.arange(-half, half, step)
    grid = np.meshgrid(axis + x, axis)
    return np.column_stack([grid[0].ravel(), grid[1].ravel(), np.zeros(grid[0].size)])


def on_table(
    *things: tuple[Body, tuple[float, float, float]], points: int = 3000, half: float = 0.45, x: float = 0.0
) -> Scene:
    """A scene of bodies, each with its place in [m], that stand on a fixed table."""
    rng = np.random.default_rng(0)
    clouds = {"table": table(half, x=x)}
    clouds |= {body.name: body.surface(points, rng) + np.array(place) for body, place in things}
    return Scene(clouds, fixed=["table"], up=[0, 0, 1])


def cards() -> Scene:
    """Two boards that lean on each other."""
    clouds, rng = dict(on_table().clouds), np.random.default_rng(0)
    for name, side in (("left", -1), ("right", 1)):
        turn = Rotation.from_euler("y", -side * 0.3).as_matrix()
        points = box(name, (0.01, 0.08, 0.1)).surface(3000, rng) @ turn.T
        inner = (side * points[:, 0]).min()
        clouds[name] = points - [side * inner, 0.0, points[:, 2].min()]
    return Scene(clouds, fixed=["table"], up=[0, 0, 1])


def balance() -> Scene:
    """A plank far past the edge of a pier, kept there by a weight."""
    return on_table(
        (box("plank", (0.3, 0.06, 0.02)), (0.11, 0.0, 0.1)),
        (box("pier", (0.06, 0.1, 0.1)), (0.0, 0.0, 0.0)),
        (box("weight", (0.05, 0.05, 0.06)), (-0.01, 0.0, 0.12)),
    ).weighed({"plank": 0.1, "weight": 1.0})
