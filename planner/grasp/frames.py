"""Hand directions to try at an object: points spread over it, closing directions across it, tilts."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from topple.planner.grasp.surface import Surface
from topple.planner.grasp.tolerances import ALIKE, CENTRAL, ENOUGH, FRAMES_FLAT, LEANING
from topple.topology.base.arrays import FloatArray
from topple.topology.geometry.axes import cross


@dataclass(frozen=True, eq=False)
class Frames:
    """Hand directions to try at one point of an object.

    Attributes:
        origin: (3,) point of the object [m].
        rotations: (F, 3, 3), each with columns x, y (closing), z (approach) in the world.
        tilts: (F,) angles between the approaches and straight against the way out [rad].
    """

    origin: FloatArray
    rotations: FloatArray
    tilts: FloatArray


def frames(surface: Surface, up: FloatArray, tilts: Sequence[float], count: int = 32) -> Iterator[Frames]:
    """Lay out the hand directions to try: points spread over the object x closing directions x tilts.

    Args:
        surface: The object.
        up: (3,) unit vector along which it goes; up here is that way, be it level.
        tilts: Angles between the approach and straight against it, about the closing axis [rad].
        count: Points of the object to try.

    Yields:
        The directions point by point, nearest to the centre of mass first. Deterministic.
    """
    points = surface.points[: surface.seen]
    flat = points - np.outer(points @ up, up)
    across_all, leaning = _closing_directions(points, up), _leaning_sides(surface.normals, up)
    for origin in _places(points, surface.centre, up, count):
        around = np.linalg.norm(flat - (origin - up * float(origin @ up)), axis=1) < 0.02
        near = points[around]
        normal = _face_normal(near, up)
        level = _distinct([*_closing_directions(near, up), *across_all])
        # a bowl has no flat side, but here its wall leans one way
        square = leaning or _leaning_sides(surface.normals[: surface.seen][around], up)
        closings = [*(_along(closing, normal, up) for closing in level), *square]
        turned = np.array([rotation for closing in closings for rotation in _frames(closing, up, tilts)])
        yield Frames(origin, turned, np.arccos(np.clip(-turned[:, :, 2] @ up, -1.0, 1.0)))


def _along(closing: FloatArray, normal: FloatArray, up: FloatArray) -> FloatArray:
    """A level direction laid onto a face: where it leans pads close along it, or thin things roll in them."""
    along = closing - up * float(closing @ normal) / float(normal @ up)
    return along / np.linalg.norm(along)


def _leaning_sides(normals: FloatArray, up: FloatArray) -> list[FloatArray]:
    """Normals of flat sides that lean: pads square to them close on them without turning the object."""
    steep = normals[np.abs(normals @ up) < LEANING[1]]
    steep = steep[:: max(1, -(-len(steep) // ENOUGH))]  # each is compared with each
    found: list[FloatArray] = []
    left = np.ones(len(steep), dtype=bool)
    alike = np.abs(steep @ steep.T) > np.cos(ALIKE)
    while left.any():
        counts = np.count_nonzero(alike & left, axis=1) * left
        most = int(np.argmax(counts))
        if counts[most] < FRAMES_FLAT * len(steep):
            break
        side = steep[alike[most] & left]
        mean = (side * np.sign(side @ steep[most])[:, None]).mean(axis=0)
        found.append(mean / np.linalg.norm(mean))
        left &= ~alike[most]
    return [side for side in found if abs(float(side @ up)) > LEANING[0]]


def _frames(along: FloatArray, up: FloatArray, tilts: Sequence[float]) -> list[FloatArray]:
    """Rotations of a hand that closes along a direction, tilted about the pads' line."""
    across = cross(up, along)
    across /= np.linalg.norm(across)
    down = cross(across, along)
    approaches = [np.cos(tilt) * down + np.sin(tilt) * across for tilt in tilts]
    return [np.column_stack([cross(along, approach), along, approach]) for approach in approaches]


def _places(points: FloatArray, centre: FloatArray, up: FloatArray, count: int) -> list[FloatArray]:
    """Points to try: spread over the object, and closer together around its centre of mass."""
    offsets = points - centre
    aside = np.linalg.norm(offsets - np.outer(offsets @ up, up), axis=1)
    central = points[aside < CENTRAL]
    chosen = [points[index] for index in spread(points, centre, count)]
    return chosen + [central[index] for index in spread(central, centre, count // 4)]


def _face_normal(points: FloatArray, up: FloatArray) -> FloatArray:
    """Normal of the face some points lie on, where they lie on one that faces up; up otherwise."""
    if len(points) < 8:
        return up
    values, vectors = np.linalg.eigh(np.cov(points.T))
    normal = vectors[:, 0] if vectors[:, 0] @ up > 0 else -vectors[:, 0]
    return normal if values[0] < 0.15 * values[1] and normal @ up > 0.8 else up


def spread(points: FloatArray, first: FloatArray, count: int) -> list[int]:
    """Pick points far from one another (farthest point sampling).

    Args:
        points: (N, 3) points [m].
        first: (3,) the sampling starts at the point nearest to this one.
        count: How many.

    Returns:
        Indices of the picked points.
    """
    if len(points) == 0:
        return []
    chosen = [int(np.argmin(np.linalg.norm(points - first, axis=1)))]
    distance = np.linalg.norm(points - points[chosen[0]], axis=1)
    while len(chosen) < min(count, len(points)):
        chosen.append(int(np.argmax(distance)))
        distance = np.minimum(distance, np.linalg.norm(points - points[chosen[-1]], axis=1))
    return chosen


def _closing_directions(points: FloatArray, up: FloatArray) -> list[FloatArray]:
    """Level directions to close along: across the narrow side first; four where none stands out."""
    east = np.cross(up, [0.0, 1.0, 0.0] if abs(up[1]) < 0.9 else [1.0, 0.0, 0.0])
    east /= np.linalg.norm(east)
    north = np.cross(up, east)
    if len(points) < 4:
        return [east, north]
    plane = np.stack([(points - points.mean(axis=0)) @ east, (points - points.mean(axis=0)) @ north])
    values, vectors = np.linalg.eigh(plane @ plane.T)
    narrow = vectors[0, 0] * east + vectors[1, 0] * north
    wide = vectors[0, 1] * east + vectors[1, 1] * north
    if values[0] < 0.5 * values[1]:
        return [narrow, wide]
    turns = np.arange(4) * np.pi / 4.0
    return [np.cos(turn) * narrow + np.sin(turn) * wide for turn in turns]


def _distinct(directions: list[FloatArray], angle: float = 0.2) -> list[FloatArray]:
    kept: list[FloatArray] = []
    for direction in directions:
        if all(abs(float(direction @ other)) < np.cos(angle) for other in kept):
            kept.append(direction)
    return kept
