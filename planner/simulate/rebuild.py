"""Bodies for simulation from a scene at rest: what was seen, completed, and fitted to stay at rest."""

from collections.abc import Collection, Mapping
from dataclasses import dataclass, field, replace

import numpy as np
from scipy.spatial import ConvexHull

from topple.planner.simulate.seating import Seat, Shape, balance_centres, floor_cut, part, seat
from topple.planner.simulate.tolerances import EDGE, FEWEST, FILLED, INTRUDERS, SLAB
from topple.robots.world.bodies import Body
from topple.robots.world.body_clouds import Piece, shell, solid
from topple.robots.world.physical_world import PhysicalWorld
from topple.robots.world.tolerances import FRICTION, TABLE_FRICTION
from topple.topology.base.arrays import FloatArray
from topple.topology.base.values import FrozenDict
from topple.topology.bodies.complete import is_hollow
from topple.topology.bodies.upright import Upright
from topple.topology.statics.grounds import planes_and_rest
from topple.topology.statics.rest import Statics

FLOOR = "the floor"
"""What everything stands on in a rebuilt world."""


@dataclass(frozen=True, eq=False)
class Rebuilt:
    """Bodies and their places in the upright frame.

    Attributes:
        bodies: Movable bodies, by name.
        grounds: Fixed bodies.
        poses: name -> (4, 4) pose_body_to_upright.
        floor: Height [m] of the surface everything stands on.
        friction: Coefficients of surfaces that were given, by name; that of the floor as `FLOOR`.
    """

    bodies: Mapping[str, Body]
    grounds: tuple[Body, ...]
    poses: Mapping[str, FloatArray]
    floor: float
    friction: Mapping[str, float] = field(default_factory=lambda: FrozenDict({}))

    def fill(self, world: PhysicalWorld) -> None:
        """Put a floor and all bodies into a world whose z axis is up."""
        x, y = np.mean([pose[:2, 3] for pose in self.poses.values()], axis=0).tolist()
        rough = self.friction.get(FLOOR, TABLE_FRICTION)
        world.add_table(FLOOR, height=self.floor, size=(3.0, 3.0), centre=(x, y), friction=rough)
        self.add_to(world)

    def add_to(self, world: PhysicalWorld) -> None:
        """Put all bodies, but no floor, into a world whose z axis is up."""
        for ground in self.grounds:
            world.add(ground, self.poses[ground.name], fixed=True)
        for name, body in self.bodies.items():
            world.add(body, self.poses[name])


def rebuild(statics: Statics, jitter: float = 0.0, seed: int = 0) -> Rebuilt:
    """Make bodies of the completed surfaces of a scene.

    Args:
        statics: The scene at rest.
        jitter: Standard deviation [m] along each axis by which each cloud is put elsewhere before the bodies
            are fitted to each other: what noise leaves open of poses and shapes.
        seed: Of the jitter.

    Returns:
        One body per object; the lowest top in use of the largest fixed body is the floor.
    """
    upright = statics.upright
    rng = np.random.default_rng(seed)
    shapes = {name: _move(shape_of(name, statics), rng.normal(0.0, jitter, 3)) for name in upright.movable}
    grounds = {name: ground_of(upright, name, upright.floor) for name in upright.fixed}
    grounds = {name: shape for name, shape in grounds.items() if shape}
    shapes = {name: floor_cut(shape, upright.floor) for name, shape in shapes.items()}
    part({**shapes, **grounds})
    lowest = {name: float(upright.clouds[name][:, 2].min()) for name in shapes}
    seats: dict[str, Seat] = {}
    for name in sorted(shapes, key=lowest.__getitem__):
        centre = upright.centres[name] if name in upright.centres else _centre(shapes[name], statics, name)
        seats[name] = seat(name, shapes, grounds, upright.floor, centre, statics.sight)
    masses = {name: statics.weights[name].mass for name in shapes}
    hidden = statics.sight is not None  # else the mass is where the shape has it
    centres = {name: each.centre for name, each in seats.items()}
    centres = {**(balance_centres(seats, masses) if hidden else centres), **_known_centres(upright, shapes)}
    part(shapes)
    bodies: dict[str, Body] = {}
    poses: dict[str, FloatArray] = {}
    for name, shape in {**shapes, **grounds}.items():
        origin = statics.surfaces[name].mean(axis=0)
        fixed = name in grounds
        parts = [piece.corners - origin for piece in shape]
        rough = upright.friction.get(name, FRICTION)
        body = Body.of(name, parts, mass=masses.get(name), friction=rough, kind="cloud")
        bodies[name] = body if fixed else replace(body, centre_of_mass=centres[name] - origin)
        poses[name] = np.eye(4)
        poses[name][:3, 3] = origin
    movable = {name: bodies[name] for name in shapes}
    friction = dict(upright.friction)
    largest = max(upright.fixed, key=lambda name: len(upright.clouds[name]), default="")
    if largest in friction:  # what the floor's height is of
        friction[FLOOR] = friction[largest]
    return Rebuilt(movable, tuple(bodies[name] for name in grounds), poses, upright.floor, friction)


def _known_centres(upright: Upright, names: Collection[str]) -> dict[str, FloatArray]:
    """Centres of mass (3,) [m] that are known and so not fitted."""
    return {name: centre for name, centre in upright.centres.items() if name in names}


def shape_of(name: str, statics: Statics) -> Shape:
    """The pieces of a body: thin ones where it is hollow, or where other things are in its hull."""
    surface, seen = statics.surfaces[name], statics.upright.clouds[name]
    whole = name in statics.upright.whole
    sight, viewpoints = (None, None) if whole else (statics.sight, statics.upright.viewpoints)
    if is_hollow(seen, sight) or _is_intruded(solid(seen, seen)[0], name, statics):
        return shell(surface, seen, viewpoints)
    return solid(surface, seen)


def _move(shape: Shape, offset: FloatArray) -> Shape:
    """The pieces somewhere else."""
    return [Piece(piece.corners + offset, piece.seen + offset) for piece in shape]


def _is_intruded(whole: Piece, name: str, statics: Statics) -> bool:
    """Whether points of other things lie deep in a hull."""
    others = [points for other, points in statics.upright.clouds.items() if other != name]
    if not others:
        return False
    planes = whole.planes
    reach = (np.concatenate(others) @ planes[:, :3].T + planes[:, 3]).max(axis=1)
    return int((reach < -FILLED).sum()) >= INTRUDERS


def _centre(shape: Shape, statics: Statics, name: str) -> FloatArray:
    """(3,) centre of mass: that of the hull of a solid, that of the surface of a shell [m]."""
    if len(shape) > 1:
        return statics.surfaces[name].mean(axis=0)
    return Body.of(name, [shape[0].corners], mass=1.0).centre_of_mass


def ground_of(upright: Upright, name: str, floor: float) -> Shape:
    """Pieces of something fixed: boards under its tops and a shell of the rest; none of the floor."""
    planes, rest = planes_and_rest(upright, name)
    if not planes:
        return shell(rest, rest, None)
    surfaces = upright.tops[name] if planes[0].ends else (upright.clouds[name],)
    pieces: Shape = []
    for surface in surfaces:
        if abs(float(np.median(surface[:, 2])) - floor) >= SLAB / 2:
            slab = np.concatenate([surface, surface - np.array([0.0, 0.0, SLAB])])
            pieces.append(Piece(slab[ConvexHull(slab).vertices], surface))
    sides = rest[rest[:, 2] > floor + SLAB / 2]
    for piece in pieces:
        sides = sides[(sides @ piece.planes[:, :3].T + piece.planes[:, 3]).max(axis=1) > EDGE]
    return [*pieces, *(shell(sides, sides, None) if len(sides) >= FEWEST else ())]
