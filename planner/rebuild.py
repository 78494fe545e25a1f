"""Bodies for simulation from a scene at rest: what the cameras saw, completed, as convex parts."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from topple.robots.bodies import Body
from topple.robots.world import World
from topple.topology.arrays import FloatArray
from topple.topology.complete import is_hollow
from topple.topology.contact import Plane
from topple.topology.parts import convex_parts
from topple.topology.statics import Statics

SKIN = 0.001
"""A rebuilt body is this much [m] smaller on each side: a hull over noisy points is too large by about
one standard deviation of their noise, and bodies that overlap push each other apart."""

THINNEST = 0.002
"""Least thickness [m] of a rebuilt part."""

PARTS = 24
"""Most convex parts of a hollow body: a bowl's wall in a ring of twelve and its bottom."""


@dataclass(frozen=True, eq=False)
class Rebuilt:
    """Bodies and their places in the upright frame.

    Attributes:
        bodies: Movable bodies, by name.
        grounds: Fixed bodies.
        poses: name -> (4, 4) pose_body_to_upright.
        planes: Heights of the table tops [m].
    """

    bodies: Mapping[str, Body]
    grounds: tuple[Body, ...]
    poses: Mapping[str, FloatArray]
    floor: float

    def world(self, offsets: Mapping[str, FloatArray] | None = None) -> World:
        """All bodies in a world of their own, which the caller closes.

        Args:
            offsets: name -> (3,) displacement [m] of where a body is thought to be.
        """
        world = World()
        middle = np.mean([pose[:2, 3] for pose in self.poses.values()], axis=0)
        world.add_table(
            "the floor", height=self.floor, size=(3.0, 3.0), centre=(float(middle[0]), float(middle[1]))
        )
        for ground in self.grounds:
            world.add(ground, self.poses[ground.name], fixed=True)
        for name, body in self.bodies.items():
            pose = np.array(self.poses[name])
            if offsets is not None and name in offsets:
                pose[:3, 3] += offsets[name]
            world.add(body, pose)
        return world


def rebuild(statics: Statics) -> Rebuilt:
    """Make bodies of the completed surfaces of a scene.

    Args:
        statics: The scene at rest.

    Returns:
        One body per object; flat fixed surfaces become the floor.
    """
    bodies: dict[str, Body] = {}
    grounds: list[Body] = []
    poses: dict[str, FloatArray] = {}
    for name, points in statics.surfaces.items():
        fixed = name in statics.upright.fixed
        if fixed and Plane.of(points) is not None:
            continue
        origin = points.mean(axis=0)
        parts = [
            _shrunk(part - origin)
            for part in _parts(points, is_hollow(statics.upright.clouds[name], statics.sight))
        ]
        body = Body.of(name, parts, mass=None if fixed else statics.weights[name].mass * DENSITY / 1e3)
        poses[name] = np.eye(4)
        poses[name][:3, 3] = origin
        if fixed:
            grounds.append(body)
        else:
            bodies[name] = body
    return Rebuilt(bodies, tuple(grounds), poses, statics.upright.floor)


DENSITY = 700.0
"""Density [kg/m³] of what nobody weighed."""


def _parts(points: FloatArray, hollow: bool) -> list[FloatArray]:
    """Convex parts of a surface: one for a body without a cavity."""
    if not hollow:
        return [points]
    return list(convex_parts(points, viewpoints=np.zeros((0, 3)), most=PARTS))


def _shrunk(part: FloatArray) -> FloatArray:
    """The part with `SKIN` taken off each side along its own axes, never thinner than `THINNEST`."""
    centre = part.mean(axis=0)
    axes = np.linalg.eigh(np.cov((part - centre).T))[1] if len(part) > 3 else np.eye(3)
    local = (part - centre) @ axes
    lower, upper = local.min(axis=0), local.max(axis=0)
    extent = upper - lower
    wanted = np.maximum(extent - 2 * SKIN, np.minimum(np.maximum(extent, 1e-4), THINNEST))
    middle = (lower + upper) / 2
    return ((local - middle) * (wanted / np.maximum(extent, 1e-4)) + middle) @ axes.T + centre
