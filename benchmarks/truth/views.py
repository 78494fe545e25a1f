"""What topple is given of a scene: whole surfaces, or depth images of one or three noisy cameras."""

from collections.abc import Mapping
from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np

from topple.benchmarks.piles import CAMERAS
from topple.benchmarks.truth.geometry import surface
from topple.benchmarks.truth.resting import TABLE, RestingScene
from topple.robots.world.camera import Camera, Noise
from topple.topology.base.arrays import FloatArray
from topple.topology.base.files import write_whole

VIEWS = {"whole": 0, "1 camera": 1, "3 cameras": 3}
"""Words -> how many cameras look; none for whole surfaces."""

POINTS = 2500  # of each cloud
QUANTUM = 1e-4  # [m] to which clouds are rounded
NOISE = Noise(floor=0.001, growth=0.0)
"""1 mm as the recorded piles have, a structured-light camera's lost pixels and steps, and borders as those of
recorded frames (`topple.benchmarks.truth.border_pixels`)."""
TARGET = (0.0, 0.0, 0.03)  # [m] in the middle of every picture
SIZE = (480, 360)  # pixels of 1.8 mm at 0.75 m, as those of recorded frames of 640 x 480 are at a metre
WIDE = (1.6, 1.6)  # [m] a table whose edges no picture shows
NARROW_EVERY = 4  # every so manieth scene's table ends within the pictures

Arrays = Mapping[str, np.ndarray[Any, Any]]


def seen(scene: RestingScene, cameras: int, look: int, table: tuple[float, float] = WIDE) -> Arrays:
    """Clouds or images of a scene, as arrays that a file holds.

    Args:
        scene: The scene.
        cameras: How many look, 0 for whole surfaces.
        look: Number of the look: the seed of its noise.
        table: Extents of the table [m], which has the objects in its middle.

    Returns:
        `names`, `fixed` and `cloud_K`, or `depth_K`, `label_K`, `pose_K` and `K` of each camera.
    """
    rng = np.random.default_rng([look, cameras])
    names = np.array([*scene.poses, "table"])
    head = {"names": names, "fixed": np.array([*sorted(scene.fixed), "table"])}
    if not cameras:
        clouds = [_cloud(scene, name, rng) for name in scene.poses]
        top = np.column_stack([rng.uniform(-0.5, 0.5, (POINTS, 2)) * TABLE, np.zeros(POINTS)])
        return head | {f"cloud_{k}": _rounded(cloud) for k, cloud in enumerate([*clouds, top])}
    found: dict[str, np.ndarray[Any, Any]] = {}
    with scene.world(table) as world:
        number = {world.ids[name] + 1: k + 1 for k, name in enumerate(names)}
        label = np.zeros(max(number) + 1, dtype=np.uint8)
        label[list(number)] = list(number.values())
        for k, eye in enumerate(CAMERAS[:cameras]):
            camera = Camera.looking_at(tuple(eye), TARGET, width=SIZE[0], height=SIZE[1], noise=NOISE)
            image = camera.look(world, rng)
            found[f"depth_{k}"], found[f"label_{k}"] = image.depth.astype(np.float32), label[image.label]
            found[f"pose_{k}"], found["K"] = image.pose_camera_to_world, image.K
    return head | found


def _cloud(scene: RestingScene, name: str, rng: np.random.Generator) -> FloatArray:
    body = next(body for body in scene.bodies if body.name == name)
    pose = scene.poses[name]
    return surface(body.parts, POINTS, rng) @ pose[:3, :3].T + pose[:3, 3]


def _rounded(points: FloatArray) -> FloatArray:
    return np.rint(points / QUANTUM) * QUANTUM


def keep(arrays: Arrays, path: Path) -> None:
    """Write what topple is given, whole or not at all."""
    buffer = BytesIO()
    np.savez_compressed(buffer, **dict[str, Any](arrays))
    write_whole(path, buffer.getvalue())
