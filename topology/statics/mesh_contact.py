"""Contacts of triangle meshes as they are: vertices on faces and edges across edges, without samples between.

A patch of contact between polyhedra is the hull of vertices of either that lie on a face of the other and of
points where their edges cross. So the edge of a support is where the mesh has it.
"""

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from scipy.spatial import KDTree

from topple.topology.base.arrays import BoolArray, FloatArray, IntArray, bounds
from topple.topology.geometry.axes import around, perpendiculars
from topple.topology.geometry.samples import volume_and_centre
from topple.topology.kernels.neighbours import PointTree
from topple.topology.scene.mesh import Mesh
from topple.topology.statics.contact import Contact
from topple.topology.statics.tolerances import FACING, LIKE_NEAREST, NEAREST_WITHIN, ON_FACE, PATCH_CORNERS


@dataclass(frozen=True, eq=False)
class Polyhedron:
    """A body as its mesh.

    Attributes:
        vertices: (V, 3) corners [m], each once.
        faces: (F, 3) indices of corners, seen counterclockwise from outside.
        samples: (N, 3) points spread over the surface [m].
    """

    vertices: FloatArray
    faces: IntArray
    samples: FloatArray = field(repr=False)

    @staticmethod
    def of(mesh: Mesh, rotation: FloatArray, samples: FloatArray) -> "Polyhedron":
        """Weld a mesh and turn it upright.

        Args:
            mesh: The mesh.
            rotation: (3, 3) whose rows are the axes of the upright frame.
            samples: (N, 3) points spread over its surface [m], not turned.
        """
        places = mesh.vertices @ rotation.T
        grain = 1e-7 * max(float(np.ptp(places, axis=0).max()), 1e-6)
        _, first, welded = np.unique(np.round(places / grain), axis=0, return_index=True, return_inverse=True)
        faces = welded.reshape(-1)[mesh.faces]
        corners = places[first][faces]
        sides = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
        faces = faces[sides > grain**2]
        solid = Polyhedron(places[first], faces, samples @ rotation.T)
        return (
            solid if solid.signed_volume >= 0 else Polyhedron(solid.vertices, faces[:, ::-1], solid.samples)
        )

    @cached_property
    def corners(self) -> FloatArray:
        """(F, 3, 3) corners of the faces [m]."""
        return self.vertices[self.faces]

    @cached_property
    def normals(self) -> FloatArray:
        """(F, 3) outward unit normals of the faces."""
        found = np.cross(self.corners[:, 1] - self.corners[:, 0], self.corners[:, 2] - self.corners[:, 0])
        return found / np.linalg.norm(found, axis=1, keepdims=True)

    @cached_property
    def box(self) -> tuple[FloatArray, FloatArray]:
        """Least and greatest corner (3,) of the box around it [m]."""
        return bounds(self.vertices)

    @cached_property
    def signed_volume(self) -> float:
        """Volume inside of the faces [m³], negative where they are turned inwards."""
        local = self.corners - self.vertices.mean(axis=0)
        return float(np.linalg.det(local).sum() / 6.0)

    @cached_property
    def volume_and_centre(self) -> tuple[float, FloatArray]:
        """Volume [m³] and (3,) centre of it [m]; those of its hull where the mesh is not closed."""
        if not self._is_closed:
            return volume_and_centre(self.vertices, [self.vertices])
        middle = self.vertices.mean(axis=0)
        local = self.corners - middle
        pieces = np.linalg.det(local) / 6.0
        return float(pieces.sum()), middle + pieces @ local.sum(axis=1) / 4.0 / pieces.sum()

    @property
    def _is_closed(self) -> bool:
        return bool((self._sides[2] == 2).all()) and self.signed_volume > 0

    @cached_property
    def _sides(self) -> tuple[IntArray, IntArray, IntArray]:
        """Edges (E, 2), their faces (E, 2), one of them twice at a border, and how many faces each has."""
        pairs = np.sort(self.faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
        edges, first, which, count = np.unique(
            pairs, axis=0, return_index=True, return_inverse=True, return_counts=True
        )
        last = np.zeros(len(edges), dtype=np.int64)
        last[which.reshape(-1)] = np.arange(len(pairs))  # the last one written stays
        return edges, np.stack([first // 3, last // 3], axis=1), count

    @cached_property
    def edges(self) -> tuple[FloatArray, FloatArray]:
        """Edges (E, 2, 3) [m] that can be touched, and normals (E, 2, 3) of the faces on either side."""
        edges, faces, _ = self._sides
        normals = self.normals[faces]
        across = self.corners[faces[:, 1]].mean(axis=1) - self.vertices[edges[:, 0]]
        out = np.einsum("ij,ij->i", across, normals[:, 0])
        ridge = out <= 1e-9 * np.linalg.norm(across, axis=1)
        return self.vertices[edges][ridge], normals[ridge]

    def turned_from(self, vertices: IntArray, directions: FloatArray) -> FloatArray:
        """(K,) least angle [rad] between the faces at some vertices (K,) and unit directions (K, 3)."""
        order = np.argsort(self.faces.ravel(), kind="stable")
        counts = np.bincount(self.faces.ravel(), minlength=len(self.vertices))
        starts, each = (np.cumsum(counts) - counts)[vertices], counts[vertices]
        if len(vertices) == 0:
            return np.zeros(0)
        each = np.maximum(each, 1)  # a vertex of no face takes that of another one, and is far from all
        ends = np.cumsum(each)
        within = np.arange(ends[-1]) - np.repeat(ends - each, each)
        faces = order[np.minimum(np.repeat(starts, each) + within, len(order) - 1)] // 3
        along = np.einsum("ij,ij->i", self.normals[faces], np.repeat(directions, each, axis=0))
        return np.arccos(np.clip(np.maximum.reduceat(along, ends - each), -1.0, 1.0))


@dataclass(frozen=True, eq=False)
class _Hits:
    """Points (K, 3) where two meshes meet, normals (K, 3) out of the first, gaps and turns (K,)."""

    points: FloatArray
    normals: FloatArray
    gaps: FloatArray
    turns: FloatArray

    def only(self, keep: BoolArray | IntArray) -> "_Hits":
        return _Hits(self.points[keep], self.normals[keep], self.gaps[keep], self.turns[keep])


def mesh_contact(
    names: tuple[str, str], a: Polyhedron, b: Polyhedron, touch: float, sunk: float, friction: float
) -> Contact | None:
    """Find where two meshes touch.

    Args:
        names: Of both.
        a: One body.
        b: The other.
        touch: Largest gap [m] that counts as none.
        sunk: Depth [m] to which they may reach into each other and still touch.
        friction: Coefficient of dry friction.

    Returns:
        The contact, or None; of a flat patch its corners. Round things touch where they are nearest, not
        where their surfaces come within `touch` beside that.
    """
    lower, upper = (
        pick([one, other], axis=0) for pick, one, other in zip((np.max, np.min), a.box, b.box, strict=True)
    )
    if (lower > upper + touch).any():
        return None
    reach = max(touch, sunk)
    box = lower - reach, upper + reach
    first, second = _on_faces(a, b, reach, box), _on_faces(b, a, reach, box)
    hits = [_Hits(first.points, -first.normals, first.gaps, first.turns), second, _across(a, b, reach, box)]
    each = [np.concatenate(part) for part in zip(*(vars(hit).values() for hit in hits), strict=True)]
    found = _Hits(*each)
    found = found.only((found.gaps <= touch) & (found.gaps >= -sunk))
    if len(found.gaps) == 0:
        return None
    size = min(float(np.ptp(solid.vertices, axis=0).max()) for solid in (a, b))
    found = found.only(_level(found, NEAREST_WITHIN * size))
    found = found.only(_outermost(found))
    return Contact(
        *names, found.points, found.normals, found.gaps, found.turns, friction=friction, exact=True
    )


def _level(hits: _Hits, radius: float) -> BoolArray:
    """Which points carry: the nearest ones around, and those where the surfaces are parallel."""
    around_each = PointTree(hits.points).query_ball_point(hits.points, radius)
    least = np.array([hits.gaps[near].min() for near in around_each])
    return np.asarray((hits.gaps <= least + LIKE_NEAREST) | (hits.turns <= FACING))


def _outermost(hits: _Hits) -> IntArray:
    """Positions of the corners of each flat patch."""
    _, patch = np.unique(np.round(hits.normals, 3), axis=0, return_inverse=True)
    kept: list[IntArray] = []
    for number in range(int(patch.max()) + 1):
        members = np.flatnonzero(patch.reshape(-1) == number)
        if len(members) > PATCH_CORNERS:
            plane = np.stack(perpendiculars(hits.normals[members[0]]), axis=1)
            reach = hits.points[members] @ plane @ around(PATCH_CORNERS).T
            members = members[np.unique(reach.argmax(axis=0))]
        kept.append(members)
    return np.concatenate(kept)


def _near(points: FloatArray, middles: FloatArray, radii: FloatArray) -> tuple[IntArray, IntArray]:
    """Pairs of a point and a ball around a middle that holds it."""
    if len(points) == 0 or len(middles) == 0:
        return np.zeros(0, dtype=np.int64), np.zeros(0, dtype=np.int64)
    found = KDTree(points).query_ball_point(middles, radii)  # each ball has a radius of its own
    counts = [len(each) for each in found]
    return np.concatenate([np.asarray(each, dtype=np.int64) for each in found]), np.repeat(
        np.arange(len(middles)), counts
    )


def _inside(points: FloatArray, box: tuple[FloatArray, FloatArray]) -> BoolArray:
    return np.asarray(((points >= box[0]) & (points <= box[1])).all(axis=1))


def _over_faces(
    points: FloatArray, solid: Polyhedron, reach: float, box: tuple[FloatArray, FloatArray]
) -> tuple[IntArray, IntArray, FloatArray]:
    """Points over or under faces: which (K,), over which faces (K,), and heights (K,) above them [m]."""
    low, high = solid.corners.min(axis=1), solid.corners.max(axis=1)
    faces = np.flatnonzero(((low <= box[1]) & (high >= box[0])).all(axis=1))
    corners = solid.corners[faces]
    middles = corners.mean(axis=1)
    radii = np.linalg.norm(corners - middles[:, None], axis=2).max(axis=1) + reach
    point, face = _near(points, middles, radii)
    offset = points[point] - corners[face, 0]
    heights = np.einsum("ij,ij->i", offset, solid.normals[faces[face]])
    first, second = corners[face, 1] - corners[face, 0], corners[face, 2] - corners[face, 0]
    aa, ab, bb = (np.einsum("ij,ij->i", x, y) for x, y in ((first, first), (first, second), (second, second)))
    pa, pb = np.einsum("ij,ij->i", offset, first), np.einsum("ij,ij->i", offset, second)
    area = aa * bb - ab * ab
    u, v = (bb * pa - ab * pb) / area, (aa * pb - ab * pa) / area
    over = (np.abs(heights) <= reach) & (u >= -ON_FACE) & (v >= -ON_FACE) & (u + v <= 1 + ON_FACE)
    return point[over], faces[face[over]], heights[over]


def _on_faces(a: Polyhedron, b: Polyhedron, reach: float, box: tuple[FloatArray, FloatArray]) -> _Hits:
    """Vertices of a on faces of b, the nearest face for each; normals out of b."""
    vertices = np.flatnonzero(_inside(a.vertices, box))
    point, face, heights = _over_faces(a.vertices[vertices], b, reach, box)
    which, normals = vertices[point], b.normals[face]
    turns = a.turned_from(which, -normals)
    facing = np.flatnonzero(turns < np.pi / 2 - 1e-3)
    order = facing[np.lexsort((turns[facing], np.round(np.abs(heights[facing]), 9), which[facing]))]
    order = order[np.unique(which[order], return_index=True)[1]]
    return _Hits(a.vertices[which[order]], normals[order], heights[order], turns[order])


def _across(a: Polyhedron, b: Polyhedron, reach: float, box: tuple[FloatArray, FloatArray]) -> _Hits:
    """Where edges of a pass edges of b."""
    (one, out_of_a), (other, out_of_b) = (
        tuple(part[_crosses(solid.edges[0], box)] for part in solid.edges) for solid in (a, b)
    )
    length = np.linalg.norm(one[:, 1] - one[:, 0], axis=1), np.linalg.norm(other[:, 1] - other[:, 0], axis=1)
    if not len(one) or not len(other):
        return _Hits(np.zeros((0, 3)), np.zeros((0, 3)), np.zeros(0), np.zeros(0))
    second, first = _near(other.mean(axis=1), one.mean(axis=1), length[0] / 2 + length[1].max() / 2 + reach)
    along, across = (one[:, 1] - one[:, 0])[first], (other[:, 1] - other[:, 0])[second]
    between = one[first, 0] - other[second, 0]
    aa, ab, bb = (np.einsum("ij,ij->i", x, y) for x, y in ((along, along), (along, across), (across, across)))
    ra, rb = np.einsum("ij,ij->i", along, between), np.einsum("ij,ij->i", across, between)
    area = aa * bb - ab * ab
    crossing = area > 1e-6 * aa * bb
    area = np.where(crossing, area, 1.0)
    s, t = (ab * rb - ra * bb) / area, (aa * rb - ab * ra) / area
    crossing &= (s > ON_FACE) & (s < 1 - ON_FACE) & (t > ON_FACE) & (t < 1 - ON_FACE)
    first, second, s, t = first[crossing], second[crossing], s[crossing, None], t[crossing, None]
    along, across = along[crossing], across[crossing]
    on_a, on_b = one[first, 0] + s * along, other[second, 0] + t * across
    normals = np.cross(along, across)
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    mid_a, mid_b = out_of_a[first].sum(axis=1), out_of_b[second].sum(axis=1)
    normals = np.where((np.einsum("ij,ij->i", normals, mid_a - mid_b) < 0)[:, None], -normals, normals)
    gaps = np.einsum("ij,ij->i", normals, on_b - on_a)
    turns = np.maximum(_turn(out_of_a[first], normals), _turn(out_of_b[second], -normals))
    meets = (np.abs(gaps) <= reach) & _in_arc(out_of_a[first], normals) & _in_arc(out_of_b[second], -normals)
    return _Hits((on_a + on_b) / 2, normals, gaps, turns).only(meets)


def _crosses(edges: FloatArray, box: tuple[FloatArray, FloatArray]) -> BoolArray:
    return np.asarray(((edges.min(axis=1) <= box[1]) & (edges.max(axis=1) >= box[0])).all(axis=1))


def _turn(sides: FloatArray, normals: FloatArray) -> FloatArray:
    """(K,) angle [rad] of normals (K, 3) to the nearer one of two sides (K, 2, 3)."""
    return np.arccos(np.clip(np.einsum("kij,kj->ki", sides, normals).max(axis=1), -1.0, 1.0))


def _in_arc(sides: FloatArray, normals: FloatArray) -> BoolArray:
    """Whether unit normals (K, 3) are between those of the faces on both sides (K, 2, 3) of an edge."""
    middle = sides.sum(axis=1)
    middle /= np.maximum(np.linalg.norm(middle, axis=1, keepdims=True), 1e-12)
    limit = np.einsum("ij,ij->i", sides[:, 0], middle)
    return np.asarray(np.einsum("ij,ij->i", normals, middle) >= limit - FACING / 2)


def depth(a: Polyhedron, b: Polyhedron, deepest: float) -> float:
    """How deep the surface of either of two bodies is in the other [m], at most `deepest`; 0 where apart.

    Args:
        a: One body.
        b: The other.
        deepest: Depth [m] up to which it is measured; what is within the other altogether is as deep.
    """
    lower, upper = (
        pick([one, other], axis=0) for pick, one, other in zip((np.max, np.min), a.box, b.box, strict=True)
    )
    if (lower > upper).any():
        return 0.0
    return max(_sunk(a, b, deepest, (lower, upper)), _sunk(b, a, deepest, (lower, upper)))


def _sunk(a: Polyhedron, b: Polyhedron, deepest: float, box: tuple[FloatArray, FloatArray]) -> float:
    """How deep points of a are in b."""
    points = np.concatenate([a.vertices, a.samples])
    points = points[_inside(points, box)]
    wide = box[0] - deepest, box[1] + deepest
    point, face, heights = _over_faces(points, b, deepest, wide)
    if len(point) == 0:
        return deepest if len(points) and _encloses(b, points[0]) else 0.0
    order = np.lexsort((face, np.round(np.abs(heights), 9), point))
    order = order[np.unique(point[order], return_index=True)[1]]
    inside = order[heights[order] < 0]
    if len(inside) == 0:
        return 0.0
    # a side further off than the surface is not the one that the point is behind
    nearest = PointTree(np.concatenate([b.samples, b.vertices])).query(points[point[inside]])[0]
    deep, sunk = -heights[inside], points[point[inside]]
    deepest_first = np.argsort(-deep, kind="stable")
    # beside a seam between parts a point may be behind a face inside of them, and not within any
    likely = deepest_first[(deep <= nearest + 1e-9)[deepest_first]]
    return next((float(deep[k]) for k in likely if _encloses(b, sunk[k])), 0.0)


def _encloses(solid: Polyhedron, point: FloatArray) -> bool:
    """Whether the faces go around a point (3,), by the solid angle that they fill."""
    arms = solid.corners - point
    lengths = np.linalg.norm(arms, axis=2)
    products = [np.einsum("ij,ij->i", arms[:, k - 2], arms[:, k - 1]) * lengths[:, k] for k in range(3)]
    angles = np.arctan2(np.linalg.det(arms), lengths.prod(axis=1) + sum(products))
    return bool(abs(angles.sum()) > np.pi)


def drop(upper: Polyhedron, lower: Polyhedron) -> float:
    """How far a body can be let down straight until it meets another one [m]; inf where it passes that.

    Args:
        upper: The body.
        lower: What may be below it.
    """
    found = np.inf
    for one, other, sign in ((upper, lower, 1.0), (lower, upper, -1.0)):
        points = np.concatenate([one.vertices, one.samples])
        low, high = bounds(other.vertices)
        points = points[((points >= low) & (points <= high))[:, :2].all(axis=1)]
        corners, wanted = other.corners, sign * other.normals[:, 2] > 1e-6
        for a, b, c in corners[wanted]:
            first, second = b[:2] - a[:2], c[:2] - a[:2]
            area = first[0] * second[1] - first[1] * second[0]
            offset = points - a
            u = (offset[:, 0] * second[1] - offset[:, 1] * second[0]) / area
            v = (offset[:, 1] * first[0] - offset[:, 0] * first[1]) / area
            over = (u >= -ON_FACE) & (v >= -ON_FACE) & (u + v <= 1 + ON_FACE)
            gaps = sign * (offset[over, 2] - u[over] * (b - a)[2] - v[over] * (c - a)[2])
            found = min(found, float(gaps[gaps > 0].min(initial=np.inf)))
    return found
