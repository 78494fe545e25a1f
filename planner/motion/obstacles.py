"""What may stand in the way: clouds, convex parts, triangle meshes and primitives, all as convex parts."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from topple.planner.motion.tolerances import PARTS, SAMPLES
from topple.robots.arm.shapes import prism
from topple.topology.base.arrays import FloatArray
from topple.topology.base.errors import InvalidInput
from topple.topology.bodies.parts import convex_parts
from topple.topology.geometry.rigid import transformed
from topple.topology.scene.mesh import Mesh

NO_VIEWPOINTS = np.empty((0, 3))  # tells `convex_parts` that nothing of the surface is missing


@dataclass(frozen=True, eq=False)
class Cuboid:
    """A box of a size (3,) in [m] around the origin of its pose (4, 4) in the world."""

    size: FloatArray
    pose_to_world: FloatArray = field(default_factory=lambda: np.eye(4))


@dataclass(frozen=True, eq=False)
class Ball:
    """A ball: centre (3,) in the world and radius in [m]."""

    centre: FloatArray
    radius: float


@dataclass(frozen=True, eq=False)
class Cylinder:
    """A cylinder around the z axis of its pose (4, 4), its middle at the origin; radius and length in [m]."""

    radius: float
    length: float
    pose_to_world: FloatArray = field(default_factory=lambda: np.eye(4))


Obstacle = FloatArray | Sequence[FloatArray] | Mesh | Cuboid | Ball | Cylinder


def parts_of(name: str, obstacle: Obstacle) -> Sequence[FloatArray]:
    """Convex parts that hold an obstacle.

    Primitives are held by polyhedra around them, at most 2 % wider. A convex mesh is its own hull; a concave
    one, and a cloud, is cut into pieces whose hulls its surface hugs, so that hollows stay open.

    Args:
        name: For messages.
        obstacle: A surface cloud (N, 3), a sequence of convex vertex sets (V, 3), a mesh, or a primitive; in
            the world, in [m].

    Returns:
        Vertex sets (V, 3) in the world.

    Raises:
        InvalidInput: If a primitive has no extent, or an array is no cloud.
    """
    if isinstance(obstacle, Cuboid):
        corners = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)])
        half = np.asarray(obstacle.size, dtype=float) / 2
        _refuse_without_extent(name, half)
        return (transformed(corners * half, obstacle.pose_to_world),)
    if isinstance(obstacle, Cylinder):
        _refuse_without_extent(name, np.array([obstacle.radius, obstacle.length]))
        return (transformed(prism(obstacle.radius, obstacle.length), obstacle.pose_to_world),)
    if isinstance(obstacle, Ball):
        import trimesh

        _refuse_without_extent(name, np.array([obstacle.radius]))
        # an icosphere lies inside the ball: scaled so that its faces do not
        around = trimesh.creation.icosphere(subdivisions=2, radius=1.02 * obstacle.radius)
        return (np.asarray(around.vertices, dtype=float) + obstacle.centre,)
    if isinstance(obstacle, Mesh):
        return _of_mesh(obstacle)
    if isinstance(obstacle, np.ndarray) and obstacle.ndim == 2:
        return convex_parts(obstacle)
    return list(obstacle)


def _of_mesh(mesh: Mesh) -> Sequence[FloatArray]:
    import trimesh

    whole = trimesh.Trimesh(mesh.vertices, mesh.faces, process=False)
    if whole.is_convex:
        return (mesh.vertices,)
    sampled: Any = trimesh.sample.sample_surface(whole, SAMPLES, seed=0)
    points = np.concatenate([mesh.vertices, np.asarray(sampled[0], dtype=float)])
    return convex_parts(points, viewpoints=NO_VIEWPOINTS, most=PARTS, finest=len(points))


def _refuse_without_extent(name: str, sizes: FloatArray) -> None:
    if not np.isfinite(sizes).all() or not (sizes > 0).all():
        raise InvalidInput(f"{name!r}: expected sizes above zero in [m], found {sizes.tolist()}")
