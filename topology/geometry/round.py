"""Balls, spheroids and cylinders: the round bodies whose hidden half follows from the half that was seen."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from topple.topology.base.arrays import BoolArray, FloatArray, lengths, middle_of, quantiles_of
from topple.topology.geometry.axes import perpendiculars
from topple.topology.geometry.tolerances import (
    BELOW_FLOOR,
    BETTER_THAN_BOX,
    COARSE,
    LARGEST_RADIUS,
    LARGEST_RESIDUAL,
    LEAST_ARC,
    LEAST_CAP,
    SPHEROID_PENALTY,
    STRAY,
    STRETCHES,
)
from topple.topology.kernels.spheres import sphere_nearest

FITTED = 10.0 * LARGEST_RADIUS
"""Radius [m] of a fit that is on its way to none."""


@dataclass(frozen=True, eq=False)
class Spheroid:
    """A ball, or one that is longer along its axis: a lemon.

    Attributes:
        centre: (3,) in [m].
        radius: Across its axis [m].
        axis: (3,) unit vector.
        stretch: How many times as long it is along its axis; 1 for a sphere.
    """

    centre: FloatArray
    radius: float
    axis: FloatArray
    stretch: float = 1.0

    def distances(self, points: FloatArray) -> FloatArray:
        """(N,) distances of points from its surface [m], along the ray from its centre."""
        rays = points - self.centre
        far = lengths(rays)
        there = lengths(_shorten_along(rays, self.axis, self.stretch))
        return far * np.abs(1.0 - self.radius / np.maximum(there, 1e-9))

    def outward(self, points: FloatArray) -> FloatArray:
        """(N, 3) directions out of it at points of its surface; of no unit length."""
        return _shorten_along(points - self.centre, self.axis, self.stretch**2)

    def surface(self, spacing: float) -> FloatArray:
        """(M, 3) points all over it, about `spacing` [m] apart."""
        count = max(16, round(4 * np.pi * (self.radius / spacing) ** 2))
        height = 1.0 - (2.0 * np.arange(count) + 1.0) / count
        angle = np.pi * (3.0 - np.sqrt(5.0)) * np.arange(count)  # the golden angle: no two above each other
        level = np.sqrt(1.0 - height**2)
        rays = np.column_stack([level * np.cos(angle), level * np.sin(angle), height])
        return self.centre + self.radius * _shorten_along(rays, self.axis, 1.0 / self.stretch)


@dataclass(frozen=True, eq=False)
class Cylinder:
    """A cylinder: (3,) centre, (3,) unit axis, radius and half its length in [m]."""

    centre: FloatArray
    axis: FloatArray
    radius: float
    half: float

    def distances(self, points: FloatArray) -> FloatArray:
        """(N,) distances of points from its side or an end, whichever is nearer [m]."""
        along = (points - self.centre) @ self.axis
        across = lengths(points - self.centre - np.outer(along, self.axis))
        return np.minimum(np.abs(across - self.radius), np.abs(np.abs(along) - self.half))

    def outward(self, points: FloatArray) -> FloatArray:
        """(N, 3) directions out of it at points of its surface; of no unit length."""
        along = ((points - self.centre) @ self.axis)[:, None] * self.axis
        across = points - self.centre - along
        end = np.abs(lengths(along) - self.half)
        side = np.abs(lengths(across) - self.radius)
        return np.where((end < side)[:, None], along, across)

    def surface(self, spacing: float) -> FloatArray:
        """(M, 3) points all over it, about `spacing` [m] apart."""
        u, v = perpendiculars(self.axis)
        around = np.linspace(0, 2 * np.pi, max(8, round(2 * np.pi * self.radius / spacing)), endpoint=False)
        ring = np.outer(np.cos(around), u) + np.outer(np.sin(around), v)
        heights = np.linspace(-self.half, self.half, max(2, round(2 * self.half / spacing) + 1))
        side = self.radius * ring[None] + (heights[:, None] * self.axis)[:, None]
        radii = np.arange(spacing / 2, self.radius, spacing)
        ends = [radius * ring + sign * self.half * self.axis for radius in radii for sign in (-1.0, 1.0)]
        return self.centre + np.vstack([side.reshape(-1, 3), *ends])


@dataclass(frozen=True, eq=False)
class Fit:
    """A round body fitted to points.

    Attributes:
        body: The body.
        residual: How far the points are off it [m], root mean square.
    """

    body: Spheroid | Cylinder
    residual: float

    @cached_property
    def lowest(self) -> float:
        """Height of its lowest point [m]."""
        return float(self.body.surface(COARSE)[:, 2].min())


def fits_of(points: FloatArray, normals: FloatArray) -> tuple[Fit, ...]:
    """Fit balls, spheroids and cylinders to what was seen of a body.

    Args:
        points: (N, 3) seen points [m].
        normals: (M, 3) normals at flat spots among them.
    """
    balls = [_ball(points, axis, stretch) for axis, stretch in _stretches(points)]
    found = [body for body in (*balls, *_cylinders(points, normals)) if body is not None]
    return tuple(Fit(body, _residual(body, points)) for body in found)


def round_body(
    fits: Sequence[Fit], box_residual: float, floor: float = -np.inf
) -> Spheroid | Cylinder | None:
    """The ball, spheroid or cylinder that explains what was seen of a body.

    Args:
        fits: What may be it, from `fits_of`.
        box_residual: How far the points are off the best box [m], root mean square.
        floor: Height of what everything stands on [m].

    Returns:
        What explains the points better than a box does; None where neither does, or where too little is seen
        to say how large it is.
    """
    for fit in sorted(fits, key=lambda fit: fit.residual):
        if fit.residual >= BETTER_THAN_BOX * box_residual:
            break  # so are all further ones
        if fit.lowest > floor - BELOW_FLOOR * fit.body.radius:
            return fit.body if fit.residual < LARGEST_RESIDUAL * fit.body.radius else None
    return None


def flattest_side(normals: FloatArray) -> tuple[BoolArray, int]:
    """Which of some normals (N, 3) point as most others do, either way round, and the one amid them."""
    agree = np.abs(normals @ normals.T) > np.cos(np.radians(12.0))
    best = int(np.argmax(agree.sum(axis=1)))
    return agree[best], best


def _residual(fit: Spheroid | Cylinder, points: FloatArray) -> float:
    """How far points are off a fit [m], root mean square, the strays left out; more for a longer spheroid."""
    distances = np.sort(fit.distances(points))
    kept = distances[: max(1, int(np.ceil((1.0 - STRAY) * len(distances))))]
    penalty = SPHEROID_PENALTY if isinstance(fit, Spheroid) and fit.stretch != 1.0 else 1.0
    return float(np.sqrt(np.mean(kept**2))) * penalty


def _stretches(points: FloatArray) -> list[tuple[FloatArray, float]]:
    """Axes and stretches of spheroids to try: a sphere, and longer ones along what is seen to be long."""
    axes = np.linalg.eigh(np.cov(points.T))[1] if len(points) > 3 else np.eye(3)
    return [(axes[:, 2], 1.0), *((axes[:, k], stretch) for k in (2, 1) for stretch in STRETCHES)]


def _shorten_along(rays: FloatArray, axis: FloatArray, stretch: float) -> FloatArray:
    """Rays (N, 3) shortened along an axis."""
    return rays + np.outer(rays @ axis * (1.0 / stretch - 1.0), axis)


def _ball(points: FloatArray, axis: FloatArray, stretch: float) -> Spheroid | None:
    """The spheroid of a stretch through points, where they show a cap of it deep enough."""
    if len(points) < 12:
        return None
    squeezed = _shorten_along(points, axis, stretch)
    fit = sphere_nearest(squeezed, FITTED)
    if fit is None:
        return None
    off = np.abs(lengths(squeezed - fit[0]) - fit[1])
    fit = sphere_nearest(squeezed[off <= quantiles_of(off, 1.0 - STRAY)[0]], FITTED)
    if fit is None or fit[1] * stretch > LARGEST_RADIUS:
        return None
    centre, radius = fit
    rays = (squeezed - centre) / radius
    towards = middle_of(rays)
    towards /= max(float(np.linalg.norm(towards)), 1e-9)
    depth = 1.0 - quantiles_of(rays @ towards, STRAY)[0]
    centre = _shorten_along(centre[None], axis, 1.0 / stretch)[0]
    return Spheroid(centre, radius, axis, stretch) if depth > LEAST_CAP else None


def _cylinders(points: FloatArray, normals: FloatArray) -> list[Cylinder]:
    """Cylinders along the directions that may be an axis: up, across all normals, square to a flat end."""
    axes = [np.array([0.0, 0.0, 1.0])]
    if len(normals) >= 8:
        axes.append(np.linalg.eigh(normals.T @ normals)[1][:, 0])
        group = normals[flattest_side(normals)[0]]
        axes.append(np.linalg.eigh(group.T @ group)[1][:, -1])
    found = (_cylinder(points, axis) for axis in axes)
    return [fit for fit in found if fit is not None]


def _cylinder(points: FloatArray, axis: FloatArray) -> Cylinder | None:
    """The cylinder along an axis that is nearest to points, where enough of its round shows."""
    if len(points) < 20:
        return None
    plane = np.stack(perpendiculars(axis), axis=1)
    flat, along = points @ plane, points @ axis
    low, high = quantiles_of(along, STRAY / 2, 1.0 - STRAY / 2)
    half = (high - low) / 2.0
    side = np.abs(along - (low + high) / 2.0) < half - min(0.004, 0.2 * half)  # what is no end
    circle = None
    for _ in range(4):
        circle = sphere_nearest(flat[side], FITTED)
        if circle is None:
            return None
        off = np.abs(lengths(flat - circle[0]) - circle[1])
        before, side = side, off < max(0.003, 0.1 * circle[1])
        if np.count_nonzero(side) < 12:
            return None
        if np.array_equal(side, before):
            break  # so is every further circle
    assert circle is not None
    middle, radius = circle
    if radius > LARGEST_RADIUS or _arc(flat[side] - middle) < LEAST_ARC:
        return None
    return Cylinder(plane @ middle + (low + high) / 2.0 * axis, axis, radius, float(half))


def _arc(rays: FloatArray) -> float:
    """How much of a round is seen from its middle [rad]: all of it less the widest gap."""
    angles = np.sort(np.arctan2(rays[:, 1], rays[:, 0]))
    gaps = np.diff(np.concatenate([angles, angles[:1] + 2 * np.pi]))
    return float(2 * np.pi - gaps.max())
