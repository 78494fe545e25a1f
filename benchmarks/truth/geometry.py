"""Relations of exact shapes at rest: touch, within, partial within, disjoint, where they are beyond doubt."""

from collections.abc import Mapping
from itertools import combinations
from typing import Any

import numpy as np
from scipy.spatial import ConvexHull

from topple.benchmarks.truth.resting import RestingScene
from topple.robots.engine import pybullet
from topple.robots.world.bodies import spread_over
from topple.robots.world.world import World
from topple.topology.base.arrays import FloatArray
from topple.topology.scene.mesh import Mesh

RelationLabels = Mapping[tuple[str, str], str]
"""(a, b) -> "a relation b"."""

CLOSE = 0.0005  # [m] what is at rest on each other touches: the engine keeps a tenth of that
APART = 0.006  # [m] four times a camera's noise: what is this far apart is disjoint for any camera
SHALLOW = 0.002  # [m] in a hull: noise
DEEP = 0.008  # [m] in a hull: surely in the hollow
MUCH = 0.05  # share of a body's surface in a hull
LITTLE = 0.004  # share of a body's surface that sticks out and is overlooked: corners of facets
FOOTPRINT = 0.15  # [m] of the table around what stands on it


def relations_of(scene: RestingScene, world: World) -> RelationLabels:
    """Relations of every pair beyond doubt; those of two bodies that never move are left out.

    Args:
        scene: The scene at rest.
        world: The same in simulation.
    """
    rng = np.random.default_rng(0)
    points = {
        body.name: surface(body.parts, 1500, rng) @ scene.poses[body.name][:3, :3].T
        + scene.poses[body.name][:3, 3]
        for body in scene.bodies
    }
    hulls = {name: ConvexHull(cloud).equations for name, cloud in points.items()}
    fixed = scene.fixed | {"table"}
    found: dict[tuple[str, str], str] = {}
    for a, b in combinations([*scene.poses, "table"], 2):
        if not (a in fixed and b in fixed) and (told := _relation(a, b, points, hulls, world)):
            found[a, b] = told
    return found


def _relation(
    a: str, b: str, points: Mapping[str, FloatArray], hulls: Mapping[str, FloatArray], world: World
) -> str | None:
    met = pybullet.getClosestPoints(world.ids[a], world.ids[b], 0.05, physicsClientId=world.client) or ()
    gap = min((float(point[8]) for point in met), default=0.05)
    if b == "table":
        return "touch" if gap < CLOSE else "disjoint" if gap > APART else None
    in_b, in_a = _depths(points[a], hulls[b]), _depths(points[b], hulls[a])
    if max(in_b.max(), in_a.max()) < SHALLOW:
        return "touch" if gap < CLOSE else "disjoint" if gap > APART else None
    if gap >= CLOSE:
        return None  # a ring around a can: in its hull, and yet apart
    for depths, others, words in ((in_b, in_a, "within"), (in_a, in_b, "contain")):
        if (depths > DEEP).mean() > MUCH and (others > DEEP).mean() < LITTLE:
            out = (depths < -SHALLOW).mean()
            return words if out < LITTLE else f"partial {words}" if out > MUCH else None
    return None


def _depths(points: FloatArray, planes: FloatArray) -> FloatArray:
    """How deep (N,) points lie in a hull [m], negative outside."""
    return -(points @ planes[:, :3].T + planes[:, 3]).max(axis=1)


def surface(parts: tuple[FloatArray, ...], count: int, rng: np.random.Generator) -> FloatArray:
    """Points (N, 3) on what parts together show: what lies in or on another part is left out."""
    hulls: list[Any] = [ConvexHull(part) for part in parts]
    areas = np.array([hull.area for hull in hulls])
    kept: list[FloatArray] = []
    for k, (part, hull) in enumerate(zip(parts, hulls, strict=True)):
        wanted = max(1, round(count * areas[k] / areas.sum()))
        points = spread_over(Mesh(part, hull.simplices), wanted, rng)
        shown = np.ones(wanted, dtype=bool)
        for j, other in enumerate(hulls):
            if j != k:
                shown &= _depths(points, other.equations) < -1e-5
        kept.append(points[shown])
    return np.concatenate(kept)
