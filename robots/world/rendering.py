"""What a camera sees of a world, whatever engine plays it: surfaces drawn under one lamp."""

from collections.abc import Iterable
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from topple.robots.arm.arm import Arm
from topple.robots.arm.visuals import visuals
from topple.robots.poses import inverse
from topple.robots.world.camera import Camera, Rendered
from topple.robots.world.tolerances import AMBIENT, ARM_TRIANGLES, LAMP, SMOOTH
from topple.topology.base.arrays import FloatArray, IntArray
from topple.topology.geometry.axes import cross
from topple.topology.geometry.rigid import move_points
from topple.topology.kernels.triangles import draw_triangles

NOBODY = -1
"""Number of what is no named body: robots, and where nothing is."""


@dataclass(frozen=True, eq=False)
class Surface:
    """A surface that cameras see.

    Attributes:
        corners: (F, 3, 3) of its triangles in the frame of its body or link [m].
        normals: (F, 3, 3) unit normals at these, those of the triangle where it bends sharply.
        colour: (3,) red, green, blue, 0..255.
    """

    corners: FloatArray
    normals: FloatArray
    colour: FloatArray

    @classmethod
    def of(cls, vertices: FloatArray, faces: IntArray, colour: Iterable[float]) -> "Surface":
        """The surface of a mesh, vertices (V, 3) [m] and faces (F, 3), its colour 0..255."""
        corners = np.asarray(vertices, dtype=np.float64)[faces]
        across = cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        sums = np.stack(
            [
                np.bincount(np.ravel(faces), np.repeat(across[:, k], 3), len(vertices)).astype(float)
                for k in range(3)
            ],
            axis=1,
        )
        flat, smooth = _unit(across)[:, None], _unit(sums)[faces]
        bends = (flat * smooth).sum(axis=-1, keepdims=True) < np.cos(SMOOTH)
        return cls(corners, np.where(bends, flat, smooth), np.array(list(colour), dtype=np.float64))


Shown = tuple[Surface, FloatArray, int]
"""A surface, where it is (4, 4) in the world, and the number that the picture has for it."""


def _unit(vectors: FloatArray) -> FloatArray:
    return vectors / np.maximum(np.linalg.norm(vectors, axis=-1, keepdims=True), 1e-30)


@lru_cache(maxsize=4)
def surfaces_of(arm: Arm) -> dict[str, list[Surface]]:
    """Link -> its surfaces, in its frame."""
    found = visuals(arm, ARM_TRIANGLES)
    return {link: [Surface.of(*part) for part in parts] for link, parts in zip(arm.links, found, strict=True)}


def draw(camera: Camera, shown: Iterable[Shown]) -> Rendered:
    """Draw what a camera without faults sees.

    Args:
        camera: The camera.
        shown: All that there is to see.

    Returns:
        Exact depth, numbers and colours.
    """
    parts = list(shown)
    world_to_camera = inverse(camera.pose_camera_to_world)
    lamp = np.array(LAMP) / np.linalg.norm(LAMP)
    corners = [np.zeros((0, 3, 3))]
    paints, numbers = [np.zeros((0, 3, 3))], [np.zeros(0, dtype=np.int64)]
    for surface, pose, number in parts:
        corners.append(move_points(surface.corners, world_to_camera @ pose))
        light = AMBIENT + (1.0 - AMBIENT) * np.maximum(surface.normals @ (pose[:3, :3].T @ lamp), 0.0)
        paints.append(light[..., None] * surface.colour)
        numbers.append(np.full(len(surface.corners), number))
    depth, face, colours = draw_triangles(
        np.concatenate(corners), np.concatenate(paints), camera.K, (camera.width, camera.height),
        camera.nearest, camera.farthest,
    )  # fmt: skip
    return depth, np.append(np.concatenate(numbers), NOBODY)[face], colours
