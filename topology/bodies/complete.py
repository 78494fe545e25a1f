"""The hidden parts of bodies: what no camera saw, guessed from symmetry, convexity and free space."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.spatial import ConvexHull, QhullError

from topple.topology.base.arrays import FloatArray, bounds, cells_over, lengths, quantiles_of
from topple.topology.base.remembered import remember
from topple.topology.base.tolerances import VOXEL
from topple.topology.bodies.tolerances import (
    BARE,
    BOWL,
    BOXY,
    COMPLETE_CLOSED,
    KEPT_BODIES,
    LARGEST,
    MOUTH,
    OUTSIDE,
    PLACES,
    PLATE,
    REFUTED,
    ROUND_REFUTED,
    UPRIGHT,
)
from topple.topology.bodies.upright import Upright
from topple.topology.geometry.axes import cross, perpendiculars
from topple.topology.geometry.outline import least_rectangle
from topple.topology.geometry.round import Cylinder, Fit, Spheroid, fits_of, flattest_side, round_body
from topple.topology.geometry.sides import beyond, sides_of
from topple.topology.geometry.thin import voxel_means
from topple.topology.kernels.neighbours import PointTree
from topple.topology.kernels.planes import patch_planes
from topple.topology.views.free_space import FreeSpace


@dataclass(frozen=True, eq=False)
class Box:
    """An oriented box: rows of `axes` are its directions; the first one is the most upright."""

    axes: FloatArray
    lower: FloatArray
    upper: FloatArray

    @property
    def centre(self) -> FloatArray:
        """(3,) centre [m]."""
        return (self.lower + self.upper) / 2 @ self.axes

    @property
    def volume(self) -> float:
        """In [m³]; that of a flat one as if it were a voxel thick."""
        return float(np.prod(np.maximum(self.upper - self.lower, VOXEL)))

    def distances(self, points: FloatArray) -> FloatArray:
        """(N,) distances of points from the nearest of its planes [m]."""
        local = points @ self.axes.T
        return np.minimum(np.abs(local - self.lower), np.abs(local - self.upper)).min(axis=1)


@dataclass(frozen=True, eq=False)
class _Seen:
    """What was seen of a body, with what several guesses ask of it.

    Attributes:
        points: (N, 3) points [m].
    """

    points: FloatArray

    @cached_property
    def hull(self) -> ConvexHull | None:
        """Convex hull; None of points without volume."""
        return _hull(self.points)

    @cached_property
    def fits(self) -> tuple[Fit, ...]:
        """Round bodies that it may be."""
        return fits_of(self.points, self.normals)

    @cached_property
    def upright_box(self) -> Box:
        """The smallest box around it that stands upright."""
        return _box_along(self.points, np.array([0.0, 0.0, 1.0]))

    @cached_property
    def box(self) -> Box:
        """The box of least volume among those that stand upright or lie along a flat side."""
        return _least_box(self)

    @cached_property
    def tree(self) -> PointTree:
        """Search tree of the points."""
        return PointTree(self.points)

    @cached_property
    def normals(self) -> FloatArray:
        """(M, 3) local normals at the flat ones among some two hundred spots."""
        spots = self.points[:: max(1, len(self.points) // 200)]
        neighbours = self.points[self.tree.query(spots, k=min(12, len(self.points)))[1]]
        _, normals, squares = patch_planes(neighbours)
        return normals[squares[:, 0] < 0.05 * squares[:, 1]]


seen_of = remember(KEPT_BODIES)(_Seen)


def complete(upright: Upright, sight: FreeSpace | None) -> Mapping[str, FloatArray]:
    """Add the surfaces that no camera saw.

    Bodies without a cavity are taken to be symmetric about the centre of their box, hollow ones about
    the axis of their opening; both are closed from below by their hull. Nothing is put where a camera
    saw through. Clouds that show their undersides stay as they are, and so do known models and bodies that
    are too large to be taken.

    Args:
        upright: The upright scene.
        sight: What the cameras saw to be empty, or None where nobody knows.

    Returns:
        name -> (N, 3) upright points [m], the seen ones first.
    """
    done: dict[str, FloatArray] = {}
    for name, points in upright.clouds.items():
        known = name in upright.fixed or name in upright.whole
        done[name] = points if known else complete_body(points, sight, upright.floor_under(points))
    return done


def complete_body(points: FloatArray, sight: FreeSpace | None, floor: float = -np.inf) -> FloatArray:
    """Add the hidden surface of one body.

    Args:
        points: (N, 3) upright seen points [m].
        sight: What the cameras saw to be empty, or None where nobody knows.
        floor: Height of what everything stands on [m].

    Returns:
        (M, 3) points, M >= N, the seen ones first.
    """
    seen = seen_of(points)
    hull = None if _is_furniture(points) else seen.hull
    if hull is None:
        return points
    if sight is None and _is_closed(seen, hull):
        return points
    hollow = _mouth_share(seen, hull, sight) > MOUTH
    box = seen.upright_box if hollow else seen.box
    if not hollow and len(guess := _as_round(seen, box, sight, floor)):
        return np.concatenate([points, guess])
    mirrored = _half_turn(points, box) if hollow else 2 * box.centre - points
    extra = [_believable(mirrored, [seen.tree], sight)]
    known = np.concatenate([points, extra[0]])
    trees = [seen.tree, PointTree(extra[0])] if len(extra[0]) else [seen.tree]
    hull = hull_of(known)
    if hull is not None:
        extra.append(_believable(_underside(known, hull), trees, sight, partly=True))
    return np.concatenate([points, *extra])


def _is_furniture(points: FloatArray) -> bool:
    """Whether the box around points (N, 3) is larger than that of anything an arm takes."""
    lower, upper = bounds(points)
    x, y, z = upper - lower
    return float(2 * (x * y + y * z + z * x)) > LARGEST


def is_hollow(points: FloatArray, sight: FreeSpace | None) -> bool:
    """Whether a body has a cavity: its hull has a mouth, with none of the (N, 3) points [m] near it."""
    seen = seen_of(points)
    return seen.hull is not None and _mouth_share(seen, seen.hull, sight) > MOUTH


def kind_of(points: FloatArray, sight: FreeSpace | None, floor: float = -np.inf) -> str:
    """Say in a word what a body looks like: box, can, ball, bowl, cup, plate, or object where none is clear.

    Args:
        points: (N, 3) upright seen points [m].
        sight: What the cameras saw to be empty, or None where nobody knows.
        floor: Height of what everything stands on [m].
    """
    seen = seen_of(points)
    if _is_furniture(points):
        return "object"
    tall, *wide = (seen.upright_box.upper - seen.upright_box.lower).tolist()
    upright = tall > UPRIGHT * max(wide)
    if is_hollow(points, sight):
        if tall < PLATE * max(wide):  # tilted, it may as well be the lid of a tin
            return "plate" if seen.box is seen.upright_box else "object"
        open_above = seen.hull is not None and _mouth_share(seen, seen.hull, sight) > BOWL
        return "cup" if upright else "bowl" if open_above else "object"
    fit = _round_of(seen, seen.box, sight, floor)
    if isinstance(fit, Spheroid):  # a bowl upside down is as round, and half as high
        return "ball" if upright else "object"
    if fit is not None and fit.half > PLATE * fit.radius:  # a flatter one is a book as likely as a disc
        return "can"
    sides = seen.box.upper - seen.box.lower
    return "box" if _off(seen.box, seen) < BOXY * float(sides.max()) else "object"


def _least_box(seen: _Seen) -> Box:
    """The box of least volume; upright ones are preferred by a tenth."""
    lying = [_box_along(seen.points, axis) for axis in _flat_sides(seen)]
    costs = [0.9 * seen.upright_box.volume, *(box.volume for box in lying)]
    return [seen.upright_box, *lying][int(np.argmin(costs))]


def _flat_sides(seen: _Seen) -> list[FloatArray]:
    """The normals of the flat sides, the main directions of local normals, other than up."""
    axes: list[FloatArray] = [np.array([0.0, 0.0, 1.0])]
    normals = seen.normals if len(seen.points) >= 12 else np.empty((0, 3))
    for _ in range(2):  # the two best supported directions that are not yet there
        if len(normals) < 8:
            break
        side, best = flattest_side(normals)
        group = normals[side]
        group = group * np.sign(group @ normals[best])[:, None]
        axis = group.mean(axis=0)
        axis /= np.linalg.norm(axis)
        if all(abs(float(axis @ other)) < np.cos(np.radians(4.0)) for other in axes):
            axes.append(axis)
        normals = normals[~side]
    return axes[1:]


def _box_along(points: FloatArray, axis: FloatArray) -> Box:
    """The smallest box with one direction given: the least rectangle of the projection."""
    across = np.stack(perpendiculars(axis))
    side = least_rectangle(points @ across.T) @ across
    axes = np.stack([axis, side, cross(axis, side)])
    local = points @ axes.T
    # One point in two hundred may be stray on each side.
    lower, upper = np.array([quantiles_of(each, 0.005, 0.995) for each in local.T]).T.copy()
    return Box(axes, lower, upper)


def _as_round(seen: _Seen, box: Box, sight: FreeSpace | None, floor: float) -> FloatArray:
    """The hidden surface of a ball, a spheroid or a cylinder; (0, 3) where the body is none."""
    fit = _round_of(seen, box, sight, floor)
    if fit is None:
        return seen.points[:0]
    surface = fit.surface(VOXEL)
    surface[:, 2] = np.maximum(surface[:, 2], floor)
    return _believable(surface, [seen.tree], sight, refuted=ROUND_REFUTED)


def _round_of(seen: _Seen, box: Box, sight: FreeSpace | None, floor: float) -> Spheroid | Cylinder | None:
    """The ball, spheroid or cylinder that a body is; None where it is none."""
    fit = round_body(seen.fits, _off(box, seen), floor)
    # what a camera sees of a body is turned to it: the inside of a bowl is round as well, and is no ball
    out = fit is None or sight is None or sight.faces(seen.points, fit.outward(seen.points)).mean() > OUTSIDE
    return fit if out else None


def _off(box: Box, seen: _Seen) -> float:
    """How far what was seen of a body is off a box [m], root mean square."""
    return float(np.sqrt(np.mean(box.distances(seen.points) ** 2)))


def _half_turn(points: FloatArray, box: Box) -> FloatArray:
    """Half a turn about the upright axis of the box."""
    centre, axis = box.centre, box.axes[0]
    offset = points - centre
    return centre - offset + 2 * (offset @ axis)[:, None] * axis


def _believable(
    guess: FloatArray,
    known: Sequence[PointTree],
    sight: FreeSpace | None,
    partly: bool = False,
    refuted: float = REFUTED,
) -> FloatArray:
    """The part of a guess that says something new and is not refuted.

    Args:
        guess: (N, 3) guessed points.
        known: Search trees of points known before: a guess next to one of them adds nothing.
        sight: What was seen to be empty.
        partly: Keep what is not refuted however much is; a refuted symmetry is given up as a whole.
        refuted: Share from which it is.
    """
    if len(guess) == 0:
        return guess
    guess = voxel_means(guess, VOXEL)
    near = 1.5 * VOXEL
    for tree in known:
        distance, _ = tree.query(guess, distance_upper_bound=np.nextafter(near, np.inf))
        guess = guess[distance > near]
    if sight is None or len(guess) == 0:
        return guess
    empty = sight.empty(guess)
    return guess[:0] if not partly and empty.mean() > refuted else guess[~empty]


def _underside(points: FloatArray, hull: ConvexHull) -> FloatArray:
    """The lower side of the hull, sampled over its plan view."""
    cells = _plan_cells(points, hull)
    return np.column_stack([cells, _lower_height(hull, cells)])


def _plan_cells(points: FloatArray, hull: ConvexHull) -> FloatArray:
    """(N, 2) cell centres inside the plan view of a hull."""
    corners = points[hull.vertices][:, :2]
    return _over(corners, cells_over(*bounds(corners), VOXEL))


def _over(corners: FloatArray, cells: FloatArray) -> FloatArray:
    """The plan cells (N, 2) inside the hull of some points (M, 2); none where those have no area."""
    sides = sides_of(corners)
    return cells[:0] if sides is None else cells[beyond(sides, cells) <= 0]


def _lower_height(hull: ConvexHull, cells: FloatArray) -> FloatArray:
    """(N,) height of the lower side of a hull over plan cells."""
    down = hull.equations[hull.equations[:, 2] < -1e-6]
    heights = -(cells @ down[:, :2].T + down[:, 3]) / down[:, 2]
    return np.asarray(heights.max(axis=1), dtype=np.float64)


def _hull(points: FloatArray) -> ConvexHull | None:
    """The convex hull, or None for clouds without volume."""
    try:
        return ConvexHull(points)
    except (QhullError, ValueError):
        return None


hull_of = remember(KEPT_BODIES)(_hull)


def _is_closed(seen: _Seen, hull: ConvexHull) -> bool:
    """Does the cloud show its underside?"""
    underside = _underside(seen.points, hull)
    if len(underside) == 0:
        return True
    distance, _ = seen.tree.query(underside)
    return bool((distance < 2.5 * VOXEL).mean() > COMPLETE_CLOSED)


def _mouth_share(seen: _Seen, hull: ConvexHull, sight: FreeSpace | None) -> float:
    """Share of the hull's surface that is a mouth: no points near it, and seen through if anybody looked."""
    corners = seen.points[hull.simplices]
    areas = lengths(cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]))
    which = np.searchsorted(np.cumsum(areas) / areas.sum(), (np.arange(PLACES) + 0.5) / PLACES)
    # A low-discrepancy sequence: the same places for the same hull, without a seed.
    u = (np.arange(PLACES) * 0.7548776662466927) % 1.0
    v = (np.arange(PLACES) * 0.5698402909980532) % 1.0
    flip = u + v > 1
    u, v = np.where(flip, 1 - u, u)[:, None], np.where(flip, 1 - v, v)[:, None]
    first, second, third = corners[np.minimum(which, len(corners) - 1)].transpose(1, 0, 2)
    spots = first + u * (second - first) + v * (third - first)
    bare = seen.tree.query(spots)[0] > BARE
    if sight is not None:
        bare[bare] = sight.empty(spots[bare])
    return float(bare.mean())
