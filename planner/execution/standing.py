"""Whether an arm stands where it is believed to: the cameras see it, and its joints say where it is."""

from collections.abc import Sequence
from functools import lru_cache

import numpy as np

from topple.planner.execution.tolerances import (
    ARM_FEWEST,
    ARM_FITS,
    ARM_NEAR,
    ARM_SHIFTED,
    ARM_SPACING,
    BESIDE,
    ROUNDS,
    STEADY,
)
from topple.robots.arm.arm import Arm
from topple.robots.driver import Driver
from topple.topology.base.arrays import FloatArray
from topple.topology.bodies.solids import up_of
from topple.topology.geometry.samples import sampled_with_normals
from topple.topology.geometry.thin import thinned
from topple.topology.kernels.neighbours import PointTree
from topple.topology.scene.scene import Scene
from topple.topology.views.image import DepthImage


def shift_of(robot: Driver, images: Sequence[DepthImage], scene: Scene) -> FloatArray | None:
    """How far an arm is seen from where it should be.

    What the cameras see near the arm and no mask claims is matched with the arm's surface (point to plane,
    shifts alone), as robots are calibrated to cameras. Directions in which nothing of it is seen stay zero.

    Args:
        robot: The arm, where it believes to stand.
        images: Of one look.
        scene: What was seen in them: what belongs to a thing is none of the arm's.

    Returns:
        (3,) from where it should be to where it is seen in the world [m]; None where too little of it is
        seen, or what is seen there does not look like it.
    """
    unclaimed = np.concatenate([np.zeros((0, 3)), *(image.background() for image in images)])
    if len(unclaimed) == 0:
        return None
    points = thinned(unclaimed, ARM_SPACING)
    surface, normals = _surface(robot, [image.viewpoint for image in images])
    tree = PointTree(surface)
    points = points[tree.query(points, distance_upper_bound=ARM_NEAR)[0] < ARM_NEAR]
    if len(points) == 0:
        return None
    things = PointTree(np.concatenate(list(scene.clouds.values())))
    points = points[things.query(points)[0] > BESIDE]
    if len(points) < ARM_FEWEST:
        return None
    shift, off = np.zeros(3), np.zeros(0)
    for _ in range(ROUNDS):
        nearest = tree.query(points - shift)[1]
        n = normals[nearest]
        off = np.einsum("ij,ij->i", points - shift - surface[nearest], n)
        weight = 1.0 / np.maximum(np.abs(off), ARM_FITS)  # what is far from it may be something else
        system = (n * weight[:, None]).T @ n + STEADY * weight.sum() * np.eye(3)
        step = np.linalg.solve(system, (n * weight[:, None]).T @ off)
        shift = shift + step
        if np.linalg.norm(step) < 1e-4:
            break
    return shift if np.median(np.abs(off)) < ARM_FITS else None


def misplacement(robot: Driver, images: Sequence[DepthImage], scene: Scene) -> str | None:
    """Say that an arm is not where it should be; None where it is, or no camera shows.

    Heights are left out: along the vertical covers and the models of links differ most, and a base that is
    moved stays on its table.

    Args:
        robot: The arm.
        images: Of one look.
        scene: What was seen in them.
    """
    shift = shift_of(robot, images, scene)
    if shift is None:
        return None
    up = up_of(scene)
    way = float(np.linalg.norm(shift - (shift @ up) * up))
    if way < ARM_SHIFTED:
        return None
    return (
        f"the arm stands {1e3 * way:.0f} mm from where it should be, as the cameras see it: its base or the "
        "cameras were moved"
    )


def _surface(robot: Driver, viewpoints: Sequence[FloatArray]) -> tuple[FloatArray, FloatArray]:
    """Points (N, 3) on the arm's links that face a camera [m], and normals, in the world."""
    poses = robot.pose_base_to_world @ robot.arm.forward(robot.q_target, robot.tool_state)[0]
    found = [
        [each @ pose[:3, :3].T for each in link] + [pose[:3, 3]]
        for link, pose in zip(_links(robot.arm), poses, strict=True)
        if link
    ]
    points = np.concatenate([points + place for points, _, place in found])
    normals = np.concatenate([normals for _, normals, _ in found])
    facing = np.any([np.einsum("ij,ij->i", normals, eye - points) > 0 for eye in viewpoints], axis=0)
    return points[facing], normals[facing]


@lru_cache(maxsize=4)
def _links(arm: Arm) -> tuple[tuple[FloatArray, ...], ...]:
    """Points (N, 3) on each link of an arm [m], with normals, in its frame; empty where it has no parts."""
    return tuple(sampled_with_normals(parts, ARM_SPACING) if parts else () for parts in arm.parts)
