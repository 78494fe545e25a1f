"""Convex parts of a concave object, from points on its surface.

A hull fills hollows: more than half of the hull of a bowl, a mug or a banana is empty. Two things show a
hollow: points deep below the hull (a banana's inner side), and hull faces that should have been seen and have
no points near them (the mouth of a bowl). A cloud with neither needs no parts; one with either is cut in two,
again and again.
"""

from dataclasses import dataclass

import numpy as np

from topple.topology.base.arrays import BoolArray, FloatArray
from topple.topology.bodies.tolerances import (
    FACE_SAMPLES,
    FRACTIONS,
    OUTLINE,
    PARTS_FEWEST,
    SEARCHED,
    SECTION,
)
from topple.topology.geometry.axes import cross
from topple.topology.geometry.hull import Hull
from topple.topology.geometry.thin import spacing_of, thinned
from topple.topology.kernels.neighbours import PointTree


@dataclass(frozen=True, eq=False)
class _Piece:
    points: FloatArray
    cuts: tuple[tuple[FloatArray, float], ...]  # planes axis . x = limit that made the piece
    hull: Hull
    hollow: float  # [m]


@dataclass(frozen=True)
class _Judge:
    """Measures how hollow a piece is.

    Attributes:
        viewpoints: (k, 3) camera centres [m]: faces turned away from all of them are not expected to have
            points. None: no face is. Empty: every face is, the cloud is complete.
        spacing: Distance of neighbouring points [m], below which a face counts as covered.
        outline: (m, 3) points spread over the whole object [m].
        outline_spacing: Distance of neighbouring points of `outline` [m].
    """

    viewpoints: FloatArray | None
    spacing: float
    outline: FloatArray
    outline_spacing: float

    def piece(self, points: FloatArray, cuts: tuple[tuple[FloatArray, float], ...]) -> _Piece:
        """Wrap points that some cuts left."""
        hull = Hull.of(points)
        return _Piece(points, cuts, hull, self.hollow(points, cuts, hull))

    def hollow(
        self,
        points: FloatArray,
        cuts: tuple[tuple[FloatArray, float], ...],
        hull: Hull,
        sparse: float = 1.0,
        enough: float = np.inf,
    ) -> float:
        """Depth of typical deep points or width of typical bare faces, whichever is larger [m].

        Args:
            points: (N, 3) points of the piece [m].
            cuts: Planes that made the piece.
            hull: Hull of the points.
            sparse: How much wider the points are spaced than in the whole cloud.
            enough: Beyond which it does not matter how hollow it is [m].
        """
        if hull.dimension < 3:
            complete = self.viewpoints is not None and len(self.viewpoints) == 0
            return self._bare(points, cuts, hull, sparse) if complete and hull.dimension == 2 else 0.0
        depth = -hull.facet_distance(points)
        rank = len(depth) - 1 - len(depth) // 50
        deep = float(np.partition(depth, rank)[rank])
        if self.viewpoints is None or deep >= enough:
            return deep
        return max(deep, self._bare(points, cuts, hull, sparse))

    def _bare(
        self, points: FloatArray, cuts: tuple[tuple[FloatArray, float], ...], hull: Hull, sparse: float
    ) -> float:
        """Distance from points that one tenth of the expected faces' area exceeds [m]."""
        corners = hull.vertices[hull.faces]
        across = cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        area = np.linalg.norm(across, axis=1)
        normals = across / np.maximum(area, 1e-30)[:, None]
        middle = corners.mean(axis=1)
        expected = np.ones(len(middle), dtype=np.bool_)
        if self.viewpoints is not None and len(self.viewpoints):
            towards = self.viewpoints[:, None] - middle
            expected = (np.einsum("vtj,tj->vt", towards, normals) > 0).any(axis=0)
        area = np.where(expected, area, 0.0)
        if area.sum() < 0.02 * np.linalg.norm(across, axis=1).sum():
            return 0.0
        # Evenly spread over the area, the same for the same hull: places at fixed shares of the running sum.
        shares = (np.arange(FACE_SAMPLES) + 0.5) / FACE_SAMPLES
        face = np.searchsorted(np.cumsum(area) / area.sum(), shares).clip(max=len(area) - 1)
        u = np.sqrt((np.arange(FACE_SAMPLES) * 0.618034) % 1)
        v = (np.arange(FACE_SAMPLES) * 0.754878) % 1
        weights = np.stack([1 - u, u * (1 - v), u * v], axis=1)
        places = np.einsum("sk,skj->sj", weights, corners[face])
        places = places[~self._in_section(places, normals[face], cuts, sparse)]
        if len(places) < FACE_SAMPLES // 16:
            return 0.0
        distance = PointTree(points).query(places)[0] - 2 * self.spacing * sparse
        return max(0.0, float(np.quantile(distance, 0.9)))

    def _in_section(
        self,
        places: FloatArray,
        normals: FloatArray,
        cuts: tuple[tuple[FloatArray, float], ...],
        sparse: float,
    ) -> BoolArray:
        """Which places lie on a cut through solid: straight out from there the object goes on."""
        inside = np.zeros(len(places), dtype=np.bool_)
        for axis, limit in cuts:
            beside = np.abs(places @ axis - limit) < 3 * self.spacing * sparse
            beside &= np.abs(normals @ axis) > SECTION
            inside |= beside
        chosen = np.flatnonzero(inside)
        if len(chosen):
            offset = self.outline[None] - places[chosen, None]
            along = np.einsum("spj,sj->sp", offset, normals[chosen])
            aside = np.einsum("spj,spj->sp", offset, offset) - along**2
            ahead = (along > self.outline_spacing) & (aside < self.outline_spacing**2)
            inside[chosen] = ahead.any(axis=1)
        return inside


def convex_parts(
    points: FloatArray,
    tolerance: float | None = None,
    viewpoints: FloatArray | None = None,
    most: int = 24,
    finest: int = 1500,
    fewest: int = PARTS_FEWEST,
) -> tuple[FloatArray, ...]:
    """Cut a surface cloud into pieces whose hulls its points hug.

    Args:
        points: (N, 3) points on the object's surface [m].
        tolerance: How far points may lie below the hull of their part [m]; 4 % of the object's mean extent
            and at least 3 mm where not given.
        viewpoints: (k, 3) camera centres [m]. A face of a hull that looks at one of them and has no points
            near it is a hollow's mouth; with k = 0 the cloud is taken to be complete and every bare face is
            one. Where not given, only points below the hull count, and a thin shell stays one part.
        most: Largest number of parts.
        finest: Points that are looked at: denser clouds are thinned to about this many first.
        fewest: Points that a part has at least.

    Returns:
        Corners (V, 3) of each part's hull; one entry for a convex cloud.

    Raises:
        InvalidInput: The array is no cloud.
    """
    if tolerance is None:
        tolerance = max(0.003, 0.04 * float(np.ptp(points, axis=0).mean()))
    few = _about(points, finest)
    outline = few[:: -(-len(few) // OUTLINE)]
    judge = _Judge(viewpoints, spacing_of(few), outline, spacing_of(outline))
    pieces = [judge.piece(few, ())]
    settled: list[_Piece] = []
    while pieces and len(pieces) + len(settled) < most:
        worst = max(range(len(pieces)), key=lambda index: pieces[index].hollow)
        piece = pieces.pop(worst)
        halves = _cut(piece, judge, fewest) if piece.hollow > tolerance else None
        if halves is None:
            settled.append(piece)
        else:
            pieces.extend(halves)
    return tuple(piece.hull.vertices for piece in settled + pieces)


def _about(points: FloatArray, count: int) -> FloatArray:
    """Thin a cloud to about a number of points, keeping the corners of its hull."""
    if len(points) <= count:
        return points
    spacing = float(np.ptp(points, axis=0).max()) / 64
    kept = thinned(points, spacing)
    for _ in range(8):  # points on a surface: their number goes with the square of the spacing
        if 0.7 * count <= len(kept) <= 1.3 * count:
            break
        spacing *= (len(kept) / count) ** 0.5
        kept = thinned(points, spacing)
    corners = Hull.of(points).vertices
    return np.concatenate([corners[:: -(-len(corners) // count)], kept])


def _cut(piece: _Piece, judge: _Judge, fewest: int) -> tuple[_Piece, _Piece] | None:
    """The two halves of the cut that leaves the least hollow, or None where no cut is worth it."""
    points = piece.points
    step = -(-len(points) // SEARCHED)
    few, sparse = points[::step], float(step) ** 0.5
    centred = points - points.mean(axis=0)
    _, axes = np.linalg.eigh(centred.T @ centred)
    least, best = np.inf, None
    for axis in axes.T:
        along = few @ axis
        for limit in np.quantile(along, FRACTIONS):
            cost, cuts = 0.0, (*piece.cuts, (axis, float(limit)))
            for half in (few[along <= limit], few[along > limit]):
                if len(half) == 0:
                    cost = np.inf
                if cost < least:
                    enough = (least - cost) / len(half)
                    cost += len(half) * judge.hollow(half, cuts, Hull.of(half), sparse, enough)
            if cost < least:
                least, best = cost, cuts[-1]
    if best is None:
        return None
    axis, limit = best
    along = points @ axis
    low, high = points[along <= limit], points[along > limit]
    if min(len(low), len(high)) < fewest:
        return None
    cuts = (*piece.cuts, (axis, limit))
    return judge.piece(low, cuts), judge.piece(high, cuts)
