"""Convex parts of a concave object, from points on its surface.

A hull fills hollows: more than half of the hull of a bowl, a mug or a banana is empty. Two things show a
hollow: points deep below the hull (a banana's inner side), and hull faces that should have been seen and have
no points near them (the mouth of a bowl). A cloud with neither needs no parts; one with either is cut in two,
again and again.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from topple.topology.base.arrays import BoolArray, FloatArray, freeze
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
from topple.topology.kernels.compiled import address, kernels
from topple.topology.kernels.neighbours import PointTree


@dataclass(frozen=True, eq=False)
class _Piece:
    points: FloatArray
    cuts: FloatArray  # (k, 4) planes axis . x = limit that made the piece
    hollow: float  # [m]
    corners: FloatArray  # (V, 3) of its hull


@dataclass(frozen=True, eq=False)
class _Judge:
    """Measures how hollow a piece is.

    Attributes:
        viewpoints: (k, 3) camera centres [m]: faces turned away from all of them are not expected to have
            points. None: no face is. Empty: every face is, the cloud is complete.
        spacing: Distance of neighbouring points [m], below which a face counts as covered.
        outline: (m, 3) points spread over the whole object [m].
    """

    viewpoints: FloatArray | None
    spacing: float
    outline: FloatArray

    @cached_property
    def outline_spacing(self) -> float:
        """Distance of neighbouring points of `outline` [m]."""
        return spacing_of(self.outline)

    def piece(
        self, points: FloatArray, cuts: FloatArray, sparse: float = 1.0, enough: float = np.inf
    ) -> _Piece:
        """Measure how hollow a piece is: the depth of typical deep points or width of typical bare faces.

        Kernel and twin differ by rounding, and in which triangles cover four corners in one plane.

        Args:
            points: (N, 3) points of the piece [m].
            cuts: (k, 4) planes that made the piece.
            sparse: How much wider the points are spaced than in the whole cloud.
            enough: Beyond which it does not matter how hollow it is [m].
        """
        compiled, eyes = kernels(), self.viewpoints
        if compiled is not None and points.shape[1:] == (3,):
            corners = np.zeros(len(points), dtype=np.bool_)
            hollow = compiled.hollow_hull(
                address(points), len(points), None if eyes is None else address(eyes),
                0 if eyes is None else len(eyes), address(cuts), len(cuts), address(self.outline),
                len(self.outline), self.spacing * sparse, self.outline_spacing if len(cuts) else 0.0, SECTION,
                enough, FACE_SAMPLES, address(corners),
            )  # fmt: skip
            if not np.isnan(hollow):  # else rounding decides, or it is flat
                return _Piece(points, cuts, hollow, points[corners])
        hull, hollow = Hull.of(points), 0.0
        if hull.dimension == 3:
            depth = np.sort(-hull.facet_distance(points))
            hollow = float(depth[len(depth) - 1 - len(depth) // 50])
        # A flat hull has faces to be bare where the cloud is complete.
        if eyes is not None and hull.dimension + (len(eyes) == 0) >= 3 and hollow < enough:
            hollow = max(hollow, self._bare(points, cuts, hull, sparse))
        return _Piece(points, cuts, hollow, hull.vertices)

    def _bare(self, points: FloatArray, cuts: FloatArray, hull: Hull, sparse: float) -> float:
        """Distance from points that one tenth of the expected faces' area exceeds [m]."""
        first = hull.vertices[hull.faces, 0].argmin(axis=1)[:, None]
        corners = hull.vertices[np.take_along_axis(hull.faces, (first + np.arange(3)) % 3, axis=1)]
        corners = corners[np.lexsort(corners.sum(axis=1).T[::-1])]  # an order that hangs on places alone
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
        self, places: FloatArray, normals: FloatArray, cuts: FloatArray, sparse: float
    ) -> BoolArray:
        """Which places lie on a cut through solid: straight out from there the object goes on."""
        inside = np.zeros(len(places), dtype=np.bool_)
        for *axis, limit in cuts:
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
    few = _thin_to(np.ascontiguousarray(points, dtype=np.float64), finest)
    eyes = None if viewpoints is None else np.ascontiguousarray(viewpoints, dtype=np.float64)
    judge = _Judge(eyes, spacing_of(few), few[:: -(-len(few) // OUTLINE)].copy())
    pieces = [judge.piece(few, np.empty((0, 4)))]
    settled: list[_Piece] = []
    while pieces and len(pieces) + len(settled) < most:
        worst = max(range(len(pieces)), key=lambda index: pieces[index].hollow)
        piece = pieces.pop(worst)
        halves = _best_cut(piece, judge, fewest) if piece.hollow > tolerance else None
        if halves is None:
            settled.append(piece)
        else:
            pieces.extend(halves)
    return tuple(freeze(piece.corners) for piece in settled + pieces)


def _thin_to(points: FloatArray, count: int) -> FloatArray:
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
    corners = _Judge(None, 0.0, points).piece(points, np.empty((0, 4))).corners
    return np.concatenate([corners[:: -(-len(corners) // count)], kept])


def _best_cut(piece: _Piece, judge: _Judge, fewest: int) -> tuple[_Piece, _Piece] | None:
    """The two halves of the cut that leaves the least hollow, or None where no cut is worth it."""
    points = piece.points
    step = -(-len(points) // SEARCHED)
    few, sparse = points[::step], float(step) ** 0.5
    centred = points - points.mean(axis=0)
    _, axes = np.linalg.eigh(centred.T @ centred)
    least, best = np.inf, None
    places = few @ axes
    for axis, along, limits in zip(axes.T, places.T, np.quantile(places, FRACTIONS, axis=0).T, strict=True):
        for limit in limits:
            cost, cuts = 0.0, np.vstack([piece.cuts, [*axis, limit]])
            for half in (few[along <= limit], few[along > limit]):
                if len(half) * step < fewest:
                    cost = np.inf
                if cost < least:
                    enough = (least - cost) / len(half)
                    cost += len(half) * judge.piece(half, cuts, sparse, enough).hollow
            if cost < least:
                least, best = cost, cuts
    if best is None:
        return None
    below = points @ best[-1, :3] <= best[-1, 3]
    low, high = points[below], points[~below]
    if min(len(low), len(high)) < fewest:
        return None
    return judge.piece(low, best), judge.piece(high, best)
