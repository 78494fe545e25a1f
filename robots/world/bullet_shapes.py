"""What is seen of a body that others put into PyBullet."""

from collections.abc import Iterator
from typing import Any

import numpy as np

from topple.robots.collision.convex import hull_of
from topple.robots.engine import pybullet
from topple.robots.poses import inverse, pose_from
from topple.robots.world.rendering import NOBODY, Shown, Surface


def shown_in(client: int, number: int) -> Iterator[Shown]:
    """The surfaces of a body, as PyBullet draws its links; meshes by their hulls, endless planes not at all.

    Args:
        client: PyBullet's number of the simulation.
        number: Of the body.
    """
    shapes: Any = pybullet.getVisualShapeData(number, physicsClientId=client)
    for _, link, kind, size, _, *place, rgba in shapes:
        mesh = _mesh(client, number, link, kind, size)
        if mesh is not None:
            colour = [255 * share for share in rgba[:3]]
            yield Surface.of(*mesh, colour), _pose(client, number, link) @ pose_from(*place), NOBODY


def _mesh(client: int, number: int, link: int, kind: int, size: Any) -> tuple[Any, Any] | None:
    """Vertices (V, 3) [m] and faces (F, 3) of a shape."""
    import trimesh

    if kind == pybullet.GEOM_MESH:
        found: Any = pybullet.getMeshData(number, link, physicsClientId=client)
        return hull_of(np.array(found[1])) if found[0] else None
    if kind == pybullet.GEOM_BOX:
        made = trimesh.creation.box(size)
    elif kind == pybullet.GEOM_SPHERE:
        made = trimesh.creation.icosphere(radius=size[0])
    elif kind == pybullet.GEOM_CYLINDER:
        made = trimesh.creation.cylinder(radius=size[1], height=size[0])
    elif kind == pybullet.GEOM_CAPSULE:
        made = trimesh.creation.capsule(radius=size[1], height=size[0])
    else:
        return None
    return np.asarray(made.vertices), np.asarray(made.faces)


def _pose(client: int, number: int, link: int) -> Any:
    """(4, 4) pose of a link's frame in the world."""
    if link >= 0:
        state: Any = pybullet.getLinkState(number, link, computeForwardKinematics=1, physicsClientId=client)
        return pose_from(state[4], state[5])
    base: Any = pybullet.getBasePositionAndOrientation(number, physicsClientId=client)
    inertial: Any = pybullet.getDynamicsInfo(number, -1, physicsClientId=client)
    return pose_from(*base) @ inverse(pose_from(inertial[3], inertial[4]))
