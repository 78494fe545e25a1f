"""How far bodies truly are from where they shall lie, in whichever way their shape is turned onto itself."""

from collections.abc import Iterator, Mapping

import numpy as np
from scipy.spatial.transform import Rotation

from topple.planner.execution.tolerances import ITSELF, POINTS, ROUGH
from topple.planner.tolerances import STEPS_ROUND
from topple.robots.world.physical_world import PhysicalWorld
from topple.topology.base.arrays import FloatArray
from topple.topology.kernels.neighbours import PointTree


def off_goal_poses(
    world: PhysicalWorld, wanted: Mapping[str, FloatArray], up: FloatArray, most: float, turn: float
) -> tuple[str, ...]:
    """Say what is not where it shall be.

    Args:
        world: The world as it is.
        wanted: (4, 4) pose that a body shall have in it, by name.
        up: (3,) unit vector against gravity.
        most: Distance [m] from where on that counts.
        turn: Angle [rad] likewise.

    Returns:
        A sentence for each.
    """
    found: list[str] = []
    for name, pose in wanted.items():
        way, angle = off_goal_pose(world, name, pose, up)
        if way > most or angle > turn:
            where = f"{1e3 * way:.0f} mm and {np.degrees(angle):.0f} degrees from where it should be"
            found.append(f"{name} is {where}")
    return tuple(found)


def off_goal_pose(world: PhysicalWorld, name: str, wanted: FloatArray, up: FloatArray) -> tuple[float, float]:
    """How far a body is from where it shall lie.

    Args:
        world: The world as it is.
        name: The body.
        wanted: (4, 4) pose it shall have.
        up: (3,) unit vector against gravity.

    Returns:
        Distance of its centre of mass [m], and the least angle [rad] by which it would have to turn to look
        as it shall: a cup without a handle may be turned as it will.
    """
    now, body = world.pose(name), world.body(name)
    centre = np.append(body.centre_of_mass, 1.0)
    way = float(np.linalg.norm(((wanted - now) @ centre)[:3]))
    surface = body.surface(POINTS, np.random.default_rng(0)) - body.centre_of_mass
    tree, some = PointTree(surface), surface[:: POINTS // 300]
    spacing = float(np.quantile(tree.query(some, k=2)[0][:, 1], 0.98))
    near = max(ITSELF * spacing, ROUGH if body.kind == "cloud" else 0.0)
    relative = Rotation.from_matrix(now[:3, :3].T @ wanted[:3, :3])
    angle = float(relative.magnitude())
    for same in _onto_itself(now[:3, :3].T @ up):
        less = float((relative * same).magnitude())
        if less < angle and float(np.quantile(tree.query(same.apply(some))[0], 0.98)) < near:
            angle = less
    return way, angle


def _onto_itself(upward: FloatArray) -> Iterator[Rotation]:
    """Turns that may bring a body onto itself: those of a cube, and about its axes and the vertical."""
    yield from Rotation.create_group("O")
    for axis in (*np.eye(3), upward):
        for k in range(1, STEPS_ROUND):
            yield Rotation.from_rotvec(2.0 * np.pi * k / STEPS_ROUND * axis)
