"""The 9-intersection model on complete solids whose surfaces are known up to noise.

Interior °, boundary ∂ and exterior ⁻ of one solid against those of the other, after Egenhofer and Franzosa,
"Point-set topological spatial relations" (1991), on regular closed solids: between two of them eight are
possible. A cell is true or false where it stays so however the surfaces move within the deviation, and open
where it does not. It knows no partial within, and convex parts of a body fill part of its hollow.
"""

from dataclasses import dataclass
from functools import cached_property
from itertools import combinations

import numpy as np

from topple.topology.base.arrays import FloatArray
from topple.topology.bodies.solids import parts_of, solids_of
from topple.topology.geometry.hull import Hull
from topple.topology.geometry.samples import sample
from topple.topology.scene.cloud import estimate_deviation
from topple.topology.scene.scene import Scene
from topple.topology.sixim.table import Relation

SURFACE_SPACING = 0.004
"""[m] of points on the surfaces: finer than the edge of any contact."""

ACROSS = 40
"""Points across the longest side of a part: what is small beside a table brings points of its own."""

OWN = 1e-6
"""[m] deeper than this in another part of the same solid a point is not on its surface."""

RELATIONS: dict[str, str] = {
    "disjoint": "FFTFFTTTT",
    "meet": "FFTFTTTTT",
    "overlap": "TTTTTTTTT",
    "inside": "TFFTFFTTT",
    "covered by": "TFFTTFTTT",
    "contains": "TTTFFTFFT",
    "covers": "TTTFTTFFT",
    "equal": "TFFFTFFFT",
}
"""The eight relations of solids, cells °°, °∂, °⁻, ∂°, ∂∂, ∂⁻, ⁻°, ⁻∂, ⁻⁻."""

AS = {
    "disjoint": Relation.DISJOINT,
    "meet": Relation.TOUCH,
    "overlap": Relation.CROSS,
    "inside": Relation.WITHIN,
    "covered by": Relation.WITHIN,
    "contains": Relation.CONTAIN,
    "covers": Relation.CONTAIN,
    "equal": Relation.TOUCH,
}
"""The same in words of the 6-intersection model, which has coincident clouds touch."""


def nine(scene: Scene) -> dict[tuple[str, str], Relation]:
    """Relations by the nine intersections of complete bodies.

    Args:
        scene: Best with `up`: bodies are completed down to what carries them.

    Returns:
        (a, b) -> the relation of every pair; touch where noise leaves several open and that is among them,
        since to meet is a single distance.
    """
    deviation = estimate_deviation(scene)
    parts = (
        solids_of(scene) if scene.up is not None else {n: parts_of(c, scene) for n, c in scene.clouds.items()}
    )
    solids = {name: Solid.of(name, parts.get(name, (cloud,))) for name, cloud in scene.clouds.items()}
    return {(a, b): _told(solids[a], solids[b], deviation) for a, b in combinations(scene.names, 2)}


def _told(a: "Solid", b: "Solid", deviation: float) -> Relation:
    if (np.maximum(a.lower - b.upper, b.lower - a.upper) > deviation).any():
        return Relation.DISJOINT
    relations = [AS[name] for name in nine_intersections(a, b, deviation).possible] or [Relation.CROSS]
    return Relation.TOUCH if Relation.TOUCH in relations else relations[0]


@dataclass(frozen=True, eq=False)
class Solid:
    """A complete body as a union of convex parts.

    Attributes:
        name: Of the object.
        hulls: Its convex parts.
    """

    name: str
    hulls: tuple[Hull, ...]

    @staticmethod
    def of(name: str, parts: tuple[FloatArray, ...]) -> "Solid":
        """The union of convex parts, (V, 3) vertices [m] each."""
        return Solid(name, tuple(Hull.of(part) for part in parts))

    @cached_property
    def lower(self) -> FloatArray:
        """(3,) least corner of the box [m]."""
        return np.min([hull.lower for hull in self.hulls], axis=0)

    @cached_property
    def upper(self) -> FloatArray:
        """(3,) greatest corner of the box [m]."""
        return np.max([hull.upper for hull in self.hulls], axis=0)

    @cached_property
    def surface(self) -> FloatArray:
        """(N, 3) points all over the surface [m], without those between two parts."""
        pieces: list[FloatArray] = []
        for own, hull in enumerate(self.hulls):
            spacing = max(SURFACE_SPACING, float((hull.upper - hull.lower).max()) / ACROSS)
            points = np.vstack([hull.vertices, sample([hull.vertices], spacing)])
            others = [other for number, other in enumerate(self.hulls) if number != own]
            inner = [other.facet_distance(points) < -OWN for other in others]
            pieces.append(points[~np.any(inner, axis=0)] if inner else points)
        return np.concatenate(pieces)

    def distance(self, points: FloatArray, near: float) -> FloatArray:
        """Distance of points to it, negative inside.

        Args:
            points: (N, 3) points [m].
            near: Of points further than this from its box, the distance to the box will do [m].

        Returns:
            (N,) metres.
        """
        away = np.linalg.norm(np.maximum(np.maximum(self.lower - points, points - self.upper), 0.0), axis=1)
        close = away <= near
        if close.any():
            away[close] = np.min([hull.signed_distance(points[close]) for hull in self.hulls], axis=0)
        return away


@dataclass(frozen=True)
class NineIntersections:
    """What is known of the nine cells.

    Attributes:
        cells: Nine of T, F and ?, in the order of `RELATIONS`.
    """

    cells: str

    @property
    def possible(self) -> tuple[str, ...]:
        """The relations that no cell rules out."""
        return tuple(
            name
            for name, mask in RELATIONS.items()
            if all(cell in ("?", wanted) for cell, wanted in zip(self.cells, mask, strict=True))
        )


def nine_intersections(a: Solid, b: Solid, deviation: float) -> NineIntersections:
    """The nine intersections of two solids.

    Args:
        a: Solid A.
        b: Solid B.
        deviation: How far the surfaces may be from where they are taken to be [m].
    """
    of_a, of_b = b.distance(a.surface, deviation), a.distance(b.surface, deviation)
    apart = float(min(of_a.min(), of_b.min()))
    deep_a, deep_b = -float(of_a.min()), -float(of_b.min())
    out_a, out_b = float(of_a.max()), float(of_b.max())

    def told(true: bool, false: bool) -> str:
        return "T" if true else "F" if false else "?"

    d, free = deviation, apart > deviation
    # where all of A is on B's surface neither is deep in the other, and yet they fill the same room
    same = max(out_a, out_b) <= d and _alike(a, b)
    interiors = told(max(deep_a, deep_b) > d or same, free)
    boundaries = told(
        (deep_a > d and out_a > d) or (deep_b > d and out_b > d), free or out_a < -d or out_b < -d
    )
    a_in, b_in = told(deep_a > d, free or out_b < -d), told(deep_b > d, free or out_a < -d)
    a_out, b_out = told(out_a > d, out_a < -d), told(out_b > d, out_b < -d)
    cells = "".join((interiors, b_in, a_out, a_in, boundaries, a_out, b_out, b_out, "T"))
    return NineIntersections(cells)


def _alike(a: Solid, b: Solid) -> bool:
    """Whether two solids fill the same room: some middle of one is in the other."""
    middles = np.array([hull.vertices.mean(axis=0) for hull in a.hulls])
    return bool((b.distance(middles, 0.0) < 0.0).any())
