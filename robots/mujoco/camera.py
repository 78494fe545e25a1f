"""What a camera sees of a world on MuJoCo, by rays: exact depth, which body, plain shading."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from topple.robots.mujoco.engine import mujoco
from topple.robots.mujoco.model import SEEN, TOUCHING
from topple.robots.mujoco.tolerances import AMBIENT, LIGHT
from topple.robots.world.camera import Camera, Rendered

ROBOT = (0.75, 0.75, 0.78)
BACKGROUND = 255


def rendered(camera: Camera, model: Any, data: Any, numbers: Mapping[int, int]) -> Rendered:
    """Cast a ray through the middle of every pixel.

    Args:
        camera: The camera.
        model: MuJoCo's model.
        data: Its state.
        numbers: Number of the shape that is seen of a body -> number of the body.

    Returns:
        Depth (H, W) in [m], 0 where nothing is; numbers of bodies (H, W), -1 where none; colours (H, W, 3).
    """
    K, pose = camera.K, camera.pose_camera_to_world
    u, v = np.meshgrid(np.arange(camera.width), np.arange(camera.height))
    rays = np.stack([(u - K[0, 2]) / K[0, 0], (v - K[1, 2]) / K[1, 1], np.ones_like(u)], axis=-1)
    lengths = np.linalg.norm(rays, axis=-1)
    directions = (rays / lengths[..., None]) @ pose[:3, :3].T
    count = u.size
    shape, distance = np.full(count, -1, dtype=np.int32), np.full(count, -1.0)
    groups = np.zeros(6, dtype=np.uint8)
    groups[[SEEN, TOUCHING]] = 1
    hidden = _hide_parts(model, numbers)
    try:
        mujoco.mj_multiRay(
            model, data, np.ascontiguousarray(pose[:3, 3]), np.ascontiguousarray(directions).ravel(), groups,
            True, -1, shape, distance, None, count, camera.farthest * float(lengths.max()),
        )  # fmt: skip
    finally:
        model.geom_group[hidden] = TOUCHING
    depth = np.where(shape < 0, 0.0, distance).reshape(u.shape) / lengths
    seen = (depth >= camera.nearest) & (depth <= camera.farthest)
    depth = np.where(seen, depth, 0.0)
    body = np.full(len(model.geom_group) + 1, -1, dtype=np.int64)
    for number, name in numbers.items():
        body[number] = name
    shape = np.where(seen.ravel(), shape, -1)
    labels = body[shape].reshape(u.shape)
    return depth, labels, _shaded(model, shape.reshape(u.shape), depth[..., None] * rays, pose, numbers)


def _hide_parts(model: Any, numbers: Mapping[int, int]) -> Any:
    """Put the convex parts of bodies, in place of which their surfaces are seen, out of the rays' groups."""
    bodies = [int(model.geom_bodyid[number]) for number in numbers]
    hidden = np.isin(model.geom_bodyid, bodies) & (model.geom_group == TOUCHING)
    model.geom_group[hidden] = 5
    return hidden


def _shaded(model: Any, shape: Any, points: Any, pose: Any, numbers: Mapping[int, int]) -> Any:
    """Colours of surfaces under one light, by the slope of the depth."""
    across, down = np.gradient(points, axis=1), np.gradient(points, axis=0)
    normal = np.cross(across, down) @ pose[:3, :3].T
    normal /= np.maximum(np.linalg.norm(normal, axis=-1, keepdims=True), 1e-12)
    facing = np.abs(normal @ np.array(LIGHT))
    colors = np.tile(ROBOT, (len(model.geom_group) + 1, 1))
    for number in numbers:
        colors[number] = model.geom_rgba[number][:3]
    lit = colors[shape] * (AMBIENT + (1.0 - AMBIENT) * facing)[..., None]
    return np.where((shape < 0)[..., None], BACKGROUND, np.clip(255.0 * lit, 0, 255)).astype(np.uint8)
