"""Body: what physics and the camera need to know of a thing, from parts, meshes or clouds."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from topple.robots.collision.convex import hull_of
from topple.robots.tolerances import TOLERANCES
from topple.robots.world.tolerances import FRICTION, ROLLING
from topple.topology.base.arguments import checked_arguments
from topple.topology.base.arrays import FloatArray, IntArray, freeze, round_off
from topple.topology.base.checks import as_name, as_points
from topple.topology.base.errors import InvalidInput
from topple.topology.scene.mesh import Mesh
from topple.topology.statics.tolerances import DENSITY

Color = tuple[float, float, float, float]
Hulls = Sequence[tuple[FloatArray, IntArray]]
GREY: Color = (0.6, 0.6, 0.62, 1.0)


@checked_arguments
@dataclass(frozen=True, eq=False)
class Body:
    """A rigid thing made of convex parts.

    Attributes:
        name: Its name in the scene.
        parts: Vertices (V, 3) of each convex part in the body's frame in [m]; together they collide.
        mass: In [kg].
        friction: Coulomb coefficient; PyBullet multiplies those of the two bodies that touch.
        centre_of_mass: (3,) in the body's frame in [m].
        inertia: (3, 3) about the centre of mass, along the body's axes, in [kg m^2].
        color: Red, green, blue, opacity in 0..1.
        mesh: What the camera sees, in the body's frame.
        kind: What it is: plate, spoon, can; "cloud" for an observed thing.
        rolling: Lever of rolling and spinning resistance in [m]: nothing is infinitely hard.

    Raises:
        InvalidInput: If it has no part, or no positive mass.

    Examples:
        >>> round(Body.of("crate", [corners], density=400).mass, 3)
        0.4
    """

    name: str
    parts: tuple[FloatArray, ...]
    mass: float
    friction: float
    centre_of_mass: FloatArray
    inertia: FloatArray
    color: Color
    mesh: Mesh
    kind: str = "thing"
    rolling: float = ROLLING

    def __post_init__(self) -> None:
        """Check and make read-only."""
        as_name(self.name)
        if not self.parts:
            raise InvalidInput(f"body {self.name!r} has no parts: expected at least one convex part (V, 3)")
        if not np.isfinite(self.mass) or self.mass <= 0:
            raise InvalidInput(f"body {self.name!r} has a mass of {self.mass} kg: expected a positive one")
        parts = tuple(as_points(part, f"a part of body {self.name!r}") for part in self.parts)
        object.__setattr__(self, "parts", parts)
        object.__setattr__(self, "mass", float(round_off(self.mass)))
        object.__setattr__(self, "centre_of_mass", freeze(round_off(self.centre_of_mass)))
        inertia = round_off(self.inertia, TOLERANCES.inertia_decimals)
        object.__setattr__(self, "inertia", freeze(inertia))

    @classmethod
    @checked_arguments
    def of(
        cls,
        name: str,
        parts: Sequence[ArrayLike],
        *,
        mass: float | None = None,
        density: float = DENSITY,
        friction: float = FRICTION,
        color: Color = GREY,
        mesh: Mesh | None = None,
        kind: str = "thing",
        rolling: float = ROLLING,
    ) -> "Body":
        """A body of even density from its convex parts.

        Args:
            name: Its name in the scene.
            parts: (V, 3) points of convex parts that do not overlap much, in [m]; flat ones get 0.2 mm.
            mass: In [kg]; None: volume times density.
            density: In [kg/m^3], for a body without a mass.
            friction: Coulomb coefficient; PyBullet multiplies those of the two bodies that touch.
            color: Red, green, blue, opacity in 0..1.
            mesh: Its surface; None: the hulls of the parts. A watertight one says where the mass is.
            kind: What it is.
            rolling: Lever of rolling and spinning resistance in [m].

        Returns:
            The body.

        Raises:
            InvalidInput: If there is no part, or the mass is not positive.
        """
        if not parts:
            raise InvalidInput(f"body {name!r} has no parts: expected at least one convex part (V, 3)")
        hulls = [hull_of(as_points(part, f"a part of body {name!r}")) for part in parts]
        volume, centre, inertia = _mass_properties(hulls, mesh)
        mass = volume * density if mass is None else mass
        corners, seen = tuple(vertices for vertices, _ in hulls), mesh or join_meshes(hulls)
        about = inertia * (mass / volume)
        return cls(name, corners, mass, friction, centre, about, color, seen, kind, rolling)

    @property
    def lower(self) -> FloatArray:
        """Lowest corner (3,) of the box around the parts, in the body's frame in [m]."""
        return np.min([part.min(axis=0) for part in self.parts], axis=0)

    @property
    def upper(self) -> FloatArray:
        """Highest corner (3,) of the box around the parts, in the body's frame in [m]."""
        return np.max([part.max(axis=0) for part in self.parts], axis=0)

    def named(self, name: str) -> "Body":
        """The same body under another name."""
        return replace(self, name=name)

    def colored(self, color: Color) -> "Body":
        """The same body in another colour."""
        return replace(self, color=color)

    def surface(self, count: int, rng: np.random.Generator) -> FloatArray:
        """Points spread evenly over the mesh.

        Args:
            count: How many.
            rng: Where the randomness comes from.

        Returns:
            (count, 3) points in the body's frame in [m].
        """
        return spread_over(self.mesh, count, rng)


def spread_over(mesh: Mesh, count: int, rng: np.random.Generator) -> FloatArray:
    """(count, 3) points spread evenly over a mesh, in its frame in [m]."""
    corners = mesh.vertices[mesh.faces]
    areas = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
    chosen = corners[rng.choice(len(corners), count, p=areas / areas.sum())]
    a, b = np.sqrt(rng.random((count, 1))), rng.random((count, 1))
    return (1 - a) * chosen[:, 0] + a * (1 - b) * chosen[:, 1] + a * b * chosen[:, 2]


def join_meshes(hulls: Hulls) -> Mesh:
    """Closed surfaces, corners (V, 3) in [m] and triangles (F, 3) of each, as one mesh."""
    offsets = np.cumsum([0, *(len(vertices) for vertices, _ in hulls[:-1])])
    faces = [triangles + offset for (_, triangles), offset in zip(hulls, offsets, strict=True)]
    return Mesh(np.concatenate([vertices for vertices, _ in hulls]), np.concatenate(faces))


def _mass_properties(hulls: Hulls, mesh: Mesh | None) -> tuple[float, FloatArray, FloatArray]:
    """Volume, centre (3,) and inertia (3, 3) about it at unit density; of the mesh if it is watertight."""
    import trimesh

    if mesh is not None:
        whole: Any = trimesh.Trimesh(mesh.vertices, mesh.faces, process=False)
        if whole.is_watertight and whole.is_winding_consistent and whole.volume > 0:
            return float(whole.volume), np.asarray(whole.center_mass), np.asarray(whole.moment_inertia)
    solids: list[Any] = [trimesh.Trimesh(vertices, faces, process=False) for vertices, faces in hulls]
    volumes = np.array([abs(float(solid.volume)) for solid in solids])
    centres = np.array([np.asarray(solid.center_mass) for solid in solids])
    total = float(volumes.sum())
    centre = volumes @ centres / total
    inertia = np.zeros((3, 3))
    for solid, volume, position in zip(solids, volumes, centres, strict=True):
        offset = position - centre
        inertia += np.asarray(solid.moment_inertia)
        inertia += volume * (offset @ offset * np.eye(3) - np.outer(offset, offset))
    return total, centre, inertia
