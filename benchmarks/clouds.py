"""Scenes to measure times with: ten household things, crowds of any size, and a depth camera's frame."""

import numpy as np

from topple.robots import shapes
from topple.robots.world.bodies import Body
from topple.robots.world.camera import Camera
from topple.robots.world.world import World
from topple.topology.base.arrays import FloatArray
from topple.topology.scene.scene import Scene
from topple.topology.views.image import DepthImage

NOISE = 0.0005
"""Standard deviation along each axis [m]: without it hulls of boxes have twelve facets."""

SPACING = 0.12
"""Distance of the places in a crowd [m]: about every second object meets a neighbour."""

BRICK = (0.08, 0.04, 0.03)
"""A brick of walls and stacks [m]."""

GRID = 0.006
"""Spacing of the points on it [m]."""


def household(points: int, seed: int) -> Scene:
    """Ten objects: a table, a lemon in a bowl, four stacked, two that touch, one alone.

    Args:
        points: Per object.
        seed: Seed of samples and noise.

    Returns:
        The scene.
    """
    rng = np.random.default_rng(seed)
    plane = np.column_stack([rng.uniform(-0.5, 0.5, (points, 2)), np.zeros(points)])
    placed: list[tuple[Body, tuple[float, float, float]]] = [
        (shapes.bowl("bowl"), (0.0, 0.0, 0.0)),
        (shapes.lemon("lemon"), (0.0, 0.0, 0.012)),
        (shapes.box("lowest", (0.1, 0.15, 0.05)), (0.25, 0.0, 0.0)),
        (shapes.box("second", (0.08, 0.1, 0.05)), (0.25, 0.0, 0.05)),
        (shapes.box("third", (0.06, 0.06, 0.06)), (0.25, 0.0, 0.1)),
        (shapes.can("topmost", diameter=0.06, height=0.1), (0.25, 0.0, 0.16)),
        (shapes.box("box", (0.1, 0.1, 0.1)), (-0.25, 0.0, 0.0)),
        (shapes.can("can", diameter=0.07, height=0.1), (-0.165, 0.0, 0.0)),
        (shapes.ball("ball"), (0.0, 0.25, 0.0)),
    ]
    clouds: dict[str, FloatArray] = {"table": plane}
    for body, place in placed:
        clouds[body.name] = body.surface(points, rng) + np.array(place)
    noisy = {name: cloud + rng.normal(0, NOISE, cloud.shape) for name, cloud in clouds.items()}
    return Scene(noisy, fixed=["table"], up=(0, 0, 1))


def crowd(count: int, points: int, seed: int) -> Scene:
    """Boxes and cans side by side on a square that grows with their number, some of them touching.

    Args:
        count: Objects.
        points: Per object.
        seed: Seed of sizes, places, samples and noise.

    Returns:
        The scene, without a table and without `up`: nothing is concluded from gravity.
    """
    rng = np.random.default_rng(seed)
    across = int(np.ceil(np.sqrt(count)))
    clouds: dict[str, FloatArray] = {}
    for number in range(count):
        name = f"object {number}"
        if rng.random() < 0.5:
            body = shapes.box(name, tuple(rng.uniform(0.06, 0.12, 3)))
        else:
            body = shapes.can(name, diameter=rng.uniform(0.06, 0.12), height=rng.uniform(0.06, 0.12))
        place = SPACING * np.array(divmod(number, across)) + rng.uniform(-0.01, 0.01, 2)
        cloud = body.surface(points, rng) + np.array([*place, 0.0])
        clouds[name] = cloud + rng.normal(0, NOISE, cloud.shape)
    return Scene(clouds)


def frame(seed: int) -> DepthImage:
    """A depth camera's view of fifteen things on a table.

    Args:
        seed: Seed of the camera's noise.

    Returns:
        640x480 depth and masks; the table is named "table".
    """
    makers = (shapes.mug, shapes.can, shapes.orange, shapes.cup, shapes.bowl)
    with World() as world:
        world.add_table()
        for number in range(15):
            row, column = divmod(number, 5)
            pose = np.eye(4)
            pose[:2, 3] = [0.16 * (row - 1), 0.16 * (column - 2)]
            world.add(makers[(row + column) % 5](f"object {number}"), pose)
        camera = Camera.looking_at((0.55, 0.1, 0.65), (0.0, 0.0, 0.03))
        return camera.look(world, np.random.default_rng(seed))


def brick_wall(count: int, seed: int) -> Scene:
    """A wall of bricks, six in a row, every other row shifted by half a brick: one island of contacts.

    Args:
        count: Bricks.
        seed: Seed of the noise.

    Returns:
        The scene: whole surfaces, the table fixed, `up` known.
    """
    turn = np.array([[np.cos(0.35), -np.sin(0.35), 0.0], [np.sin(0.35), np.cos(0.35), 0.0], [0.0, 0.0, 1.0]])
    places = [((k % 6 + 0.5 * (k // 6 % 2)) * BRICK[0], 0.0, (k // 6 + 0.5) * BRICK[2]) for k in range(count)]
    return _laid([np.array(place) @ turn.T for place in places], turn, seed)


def stacks_of_four(count: int, seed: int) -> Scene:
    """Stacks of four bricks, twelve centimetres apart, sixteen stacks in a row.

    Args:
        count: Bricks.
        seed: Seed of the noise.

    Returns:
        The scene: whole surfaces, the table fixed, `up` known.
    """
    stacks = [divmod(k // 4, 16) for k in range(count)]
    places = [np.array([0.12 * i, 0.12 * j, (k % 4 + 0.5) * BRICK[2]]) for k, (i, j) in enumerate(stacks)]
    return _laid(places, np.eye(3), seed)


def _laid(places: list[FloatArray], turn: FloatArray, seed: int) -> Scene:
    """Bricks at places, turned alike, on a table that reaches beyond them."""
    rng = np.random.default_rng(seed)
    brick = _box_grid(BRICK, GRID) @ turn.T
    clouds = {
        f"brick {k}": brick + place + rng.normal(0, NOISE, brick.shape) for k, place in enumerate(places)
    }
    middles = np.array(places)[:, :2]
    (x0, y0), (x1, y1) = middles.min(axis=0) - 0.15, middles.max(axis=0) + 0.15
    x, y = np.meshgrid(np.arange(x0, x1, 0.015), np.arange(y0, y1, 0.015))
    clouds["table"] = np.column_stack([x.ravel(), y.ravel(), np.zeros(x.size)])
    return Scene(clouds, fixed=["table"], up=(0, 0, 1))


def _box_grid(size: tuple[float, float, float], spacing: float) -> FloatArray:
    """Points (N, 3) on a grid on all sides of a box around the origin [m]."""
    axes = [np.linspace(-s / 2, s / 2, max(2, round(s / spacing) + 1)) for s in size]
    whole = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)
    outside = (np.abs(np.abs(whole) - np.array(size) / 2) < 1e-9).any(axis=1)
    return whole[outside]
