"""How an object has to be moved to lie as another cloud of it: rigid registration, and what that leaves."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import permutations, product

import numpy as np
from scipy.spatial.transform import Rotation

from topple.planner.placement.resting import about
from topple.planner.rearranging.tolerances import (
    ALIKE,
    ALL_BUT_STRAYS,
    AS_WELL,
    BARELY,
    BEST,
    COARSELY,
    FAR,
    FINELY,
    HEADINGS,
    KEPT,
    LEVEL,
    MOST,
    POINTS,
    ROUND,
    ROUNDS,
    SPACING,
    SYMMETRIC,
)
from topple.planner.tolerances import DISTURBED, STEPS_ROUND, TURNED
from topple.robots.poses import inverse
from topple.topology.base.arrays import BoolArray, FloatArray, freeze
from topple.topology.geometry.rigid import move_points, turned_to
from topple.topology.geometry.thin import voxel_means
from topple.topology.kernels.neighbours import PointTree


@dataclass(frozen=True, eq=False)
class Registration:
    """A rigid motion that brings one cloud of an object onto another one.

    Attributes:
        pose: (4, 4) rigid transform in the world.
        residual: What is left [m]: the mean way from a point of either cloud to the nearest of the other.
        way: How far it brings the middle of the object [m].
        turn: By how much it turns it [rad].
    """

    pose: FloatArray
    residual: float
    way: float
    turn: float

    def __post_init__(self) -> None:
        object.__setattr__(self, "pose", freeze(self.pose))

    @property
    def stays(self) -> bool:
        """Whether the object lies there already, but for what does not count as a move."""
        return self.way < DISTURBED and self.turn < TURNED


def register(
    start: FloatArray, goal: FloatArray, up: FloatArray, guess: FloatArray | None = None
) -> Registration:
    """Find the rigid motion that brings a cloud onto another of the same object.

    Headings and principal axes are tried, and the best of them followed to where they settle (iterative
    closest points, both ways, far ones left out). Of motions that fit alike those that do not tilt are
    taken, and of these the one that turns least; one that tilts little is taken not to tilt.

    Args:
        start: (N, 3) points [m].
        goal: (M, 3) points [m].
        up: (3,) unit vector.
        guess: (4, 4) motion to try before all else.

    Returns:
        The motion. Deterministic.
    """
    same = _point_by_point(start, goal)
    if same is not None:
        return same
    a, b = (_few(voxel_means(cloud, SPACING)) for cloud in (start, goal))
    pair = _Pair(a, b, up)
    if guess is not None and (near := pair.settle(guess)).residual < pair.spacing:
        return near
    starts = sorted((pair.shift(pose, 2) for pose in pair.attempts()), key=pair.distance)[:KEPT]
    found = [pair.settle(pose) for pose in starts]
    found = _as_well(found, ALIKE)  # a block fits upside down too, by noise even better
    level = [each for each in found if _tilt(each.pose, up) < LEVEL]
    return min(_as_well(level or found, AS_WELL), key=lambda each: each.turn)


def turns(surface: FloatArray, up: FloatArray) -> list[float]:
    """Angles [rad] about the vertical through its middle by which an object turns onto itself, 0 first.

    Args:
        surface: (N, 3) points of all of it [m].
        up: (3,) unit vector.
    """
    centred = surface - (surface.min(axis=0) + surface.max(axis=0)) / 2.0
    tree, points = PointTree(centred), _few(centred)

    def off(angle: float) -> float:
        return float(np.quantile(tree.query(points @ about(up, angle).T)[0], ALL_BUT_STRAYS))

    spacing = float(np.median([off(angle) for angle in BARELY]))  # which a turned grid of points has anyway
    angles = 2.0 * np.pi / HEADINGS * np.arange(HEADINGS)
    beside = np.array([off(float(angle)) for angle in angles]) - spacing
    if np.mean(beside < ROUND) > MOST:
        return (2.0 * np.pi / STEPS_ROUND * np.arange(STEPS_ROUND)).tolist()
    return [0.0, *angles[1:][beside[1:] < SYMMETRIC].tolist()]


def least(fit: Registration, start: FloatArray, surface: FloatArray, up: FloatArray) -> Registration:
    """The one that turns least of the motions that are alike, as the object can be turned onto itself.

    Args:
        fit: One of them.
        start: (N, 3) points of the object [m].
        surface: (M, 3) points of all of it, hidden sides too [m].
        up: (3,) unit vector.
    """
    there = move_points(surface, fit.pose)
    middle = (there.min(axis=0) + there.max(axis=0)) / 2.0
    alike = (turned_to(about(up, angle), middle, middle) @ fit.pose for angle in turns(there, up))
    return min((_result(pose, start, fit.residual) for pose in alike), key=lambda each: round(each.turn, 6))


def rest_of(known: Registration, before: FloatArray, now: FloatArray) -> Registration | None:
    """Compute the rest of a motion for an object moved meanwhile; None where it was seen anew since.

    Args:
        known: The motion.
        before: (N, 3) points that it is of [m].
        now: (M, 3) points of the object where it is now [m].
    """
    meanwhile = _point_by_point(before, now)
    return None if meanwhile is None else _result(known.pose @ inverse(meanwhile.pose), now, known.residual)


def _point_by_point(start: FloatArray, goal: FloatArray) -> Registration | None:
    """The motion of the very same points; None where the clouds are others."""
    if start.shape != goal.shape or len(start) < 3:
        return None
    pose = _rigid(start, goal)
    left = float(np.linalg.norm(move_points(start, pose) - goal, axis=1).max())
    return _result(pose, start, left) if left < ALIKE else None


def _few(points: FloatArray) -> FloatArray:
    """At most so many of the points, spread evenly."""
    step = max(1, len(points) // POINTS)
    return points[::step] if step > 1 else points


def _rigid(a: FloatArray, b: FloatArray) -> FloatArray:
    """(4, 4) the motion of points (N, 3) onto others with the least squares left (Kabsch)."""
    here, there = a.mean(axis=0), b.mean(axis=0)
    u, _, vt = np.linalg.svd((a - here).T @ (b - there))
    flip = np.diag([1.0, 1.0, np.sign(np.linalg.det(u @ vt)) or 1.0])
    return turned_to(vt.T @ flip @ u.T, here, there)


def _result(pose: FloatArray, start: FloatArray, residual: float) -> Registration:
    middle = (start.min(axis=0) + start.max(axis=0)) / 2.0
    turn = float(Rotation.from_matrix(pose[:3, :3]).magnitude())
    return Registration(pose, residual, float(np.linalg.norm(move_points(middle, pose) - middle)), turn)


def _as_well(fits: Sequence[Registration], by: float) -> list[Registration]:
    """Those that fit as well as the best one, but for so much [m]."""
    best = min(each.residual for each in fits)
    return [each for each in fits if each.residual <= best + by]


def _tilt(pose: FloatArray, up: FloatArray) -> float:
    """By how much a motion (4, 4) tilts what stands upright [rad]."""
    return float(np.arccos(np.clip(up @ pose[:3, :3] @ up, -1.0, 1.0)))


class _Pair:
    """Two clouds of one object."""

    def __init__(self, a: FloatArray, b: FloatArray, up: FloatArray) -> None:
        self._a, self._b, self._up = a, b, up
        self._near_a, self._near_b = PointTree(a), PointTree(b)
        self.spacing = float(np.mean([np.median(t.query(t.data, k=2)[0][:, 1]) for t in self._trees]))

    @property
    def _trees(self) -> Sequence[PointTree]:
        return self._near_a, self._near_b

    def attempts(self) -> Iterable[FloatArray]:
        """Motions to begin with: every heading, and principal axes onto principal axes."""
        here, there = self._a.mean(axis=0), self._b.mean(axis=0)
        for k in range(HEADINGS):
            yield turned_to(about(self._up, 2.0 * np.pi * k / HEADINGS), here, there)
        own, other = (
            np.linalg.svd(c - c.mean(axis=0), full_matrices=len(c) < 3)[2] for c in (self._a, self._b)
        )
        for order, signs in product(permutations(range(3)), product((1.0, -1.0), repeat=3)):
            rotation = other.T @ np.diag(signs) @ own[list(order)]
            if np.linalg.det(rotation) > 0.0:
                yield turned_to(rotation, here, there)

    def _match(self, pose: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Points of the first cloud and those of the second that they are next to, from either side."""
        there, nearest = self._near_b.query(move_points(self._a, pose))
        back, own = self._near_a.query((self._b - pose[:3, 3]) @ pose[:3, :3])
        here, over = _near(there), _near(back)
        a = np.vstack([self._a[here], self._a[own[over]]])
        return a, np.vstack([self._b[nearest[here]], self._b[over]])

    def distance(self, pose: FloatArray) -> float:
        """Mean way from a point of either cloud to the nearest of the other, none counted as too far [m]."""
        there = self._near_b.query(move_points(self._a, pose))[0]
        back = self._near_a.query((self._b - pose[:3, 3]) @ pose[:3, :3])[0]
        return float(np.minimum(np.concatenate([there, back]), FAR).mean())

    def settle(self, pose: FloatArray) -> Registration:
        """Where a motion settles; level where it tilts little."""
        pose = self._refine(pose, level=False)
        if _tilt(pose, self._up) < LEVEL:
            middle = self._a.mean(axis=0)
            pose = self._best_heading(
                self._refine(self._level(pose[:3, :3], middle, move_points(middle, pose)), True)
            )
        return _result(pose, self._a, self.distance(pose))

    def _best_heading(self, pose: FloatArray) -> FloatArray:
        """A level motion with the heading that fits best: points beside each other on a wall hold back.

        A mug's handle is a twelfth of its points; matched one by one the others keep it where it is. What was
        seen of it has its middle beside the axis: a turn about that is followed by a shift, in turns.
        """
        pose, best = self.shift(pose), np.inf
        while (left := self.distance(pose)) < best - ALIKE / 10.0:
            best = left
            for steps in (COARSELY, FINELY):
                middle = move_points(self._a.mean(axis=0), pose)
                turned = [turned_to(about(self._up, angle), middle, middle) @ pose for angle in steps]
                pose = min([pose, *map(self.shift, sorted(turned, key=self.distance)[:2])], key=self.distance)
        return pose

    def shift(self, pose: FloatArray, rounds: int = 5) -> FloatArray:
        """A motion moved along, unturned, to where it fits best nearby."""
        for _ in range(rounds):
            a, b = self._match(pose)
            pose = pose.copy()
            pose[:3, 3] += (b - move_points(a, pose)).mean(axis=0)
        return pose

    def _refine(self, pose: FloatArray, level: bool) -> FloatArray:
        for _ in range(ROUNDS):
            a, b = self._match(pose)
            following = _rigid(a, b)
            if level:
                following = self._level(following[:3, :3], a.mean(axis=0), b.mean(axis=0))
            moved = float(np.abs(following - pose).max())
            pose = following
            if moved < BEST:
                break
        return pose

    def _level(self, rotation: FloatArray, here: FloatArray, there: FloatArray) -> FloatArray:
        """(4, 4) the part of a turn that is about the vertical, with the way from one place to another."""
        sine = np.array([rotation[2, 1] - rotation[1, 2], rotation[0, 2] - rotation[2, 0],
                         rotation[1, 0] - rotation[0, 1]]) @ self._up  # fmt: skip
        cosine = float(np.trace(rotation) - self._up @ rotation @ self._up)
        return turned_to(about(self._up, float(np.arctan2(sine, cosine))), here, there)


def _near(distances: FloatArray) -> BoolArray:
    """Which matches count: those that are not far, and most in any case."""
    return distances <= max(FAR, float(np.quantile(distances, MOST)))
