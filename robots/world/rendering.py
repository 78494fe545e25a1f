"""What a camera sees of a PyBullet world, drawn by TinyRenderer."""

from typing import Any

import numpy as np

from topple.robots.engine import pybullet
from topple.robots.poses import inverse
from topple.robots.world.camera import Camera, Rendered
from topple.topology.base.arrays import rounded


def rendered(camera: Camera, client: int) -> Rendered:
    """Draw what a camera without faults sees.

    Args:
        camera: The camera.
        client: PyBullet's number of the simulation.

    Returns:
        Exact depth, PyBullet's numbers, and colours.
    """
    found: Any = pybullet.getCameraImage(
        camera.width, camera.height, _view(camera), _projection(camera), shadow=0,
        lightDirection=[0.4, -0.5, 1.5], renderer=pybullet.ER_TINY_RENDERER, physicsClientId=client,
    )  # fmt: skip
    shape = (camera.height, camera.width)
    buffer = np.asarray(found[3], dtype=np.float64).reshape(shape)
    body = np.asarray(found[4], dtype=np.int64).reshape(shape)
    near, far = camera.nearest, camera.farthest
    depth = near * far / (far - (far - near) * buffer)
    depth[(body < 0) | (buffer >= 1.0)] = 0.0
    rgb = np.asarray(found[2], dtype=np.uint8).reshape(*shape, 4)[..., :3]
    return depth, body & 0xFFFFFF, np.ascontiguousarray(rgb)


def _view(camera: Camera) -> list[float]:
    """OpenGL's view matrix, column by column."""
    pose = camera.pose_camera_to_world @ np.diag([1.0, -1.0, -1.0, 1.0])
    return rounded(inverse(pose).T.ravel()).tolist()


def _projection(camera: Camera) -> list[float]:
    """OpenGL's projection matrix, column by column.

    TinyRenderer casts the ray of a pixel through its left lower corner, not its centre.
    """
    K, near, far = camera.K, camera.nearest, camera.farthest
    matrix = np.zeros((4, 4))
    matrix[0, 0], matrix[1, 1] = 2 * K[0, 0] / camera.width, 2 * K[1, 1] / camera.height
    matrix[0, 2] = 1 - 2 * K[0, 2] / camera.width
    matrix[1, 2] = 2 * (K[1, 2] + 1) / camera.height - 1
    matrix[2, 2], matrix[2, 3] = -(far + near) / (far - near), -2 * far * near / (far - near)
    matrix[3, 2] = -1
    return matrix.T.ravel().tolist()
