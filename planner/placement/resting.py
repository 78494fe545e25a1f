"""How an object stands by itself: the faces it can stand on, and where placing tolerances come from."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.spatial import ConvexHull, QhullError

from topple.planner.placement.tolerances import ALIKE, FLAT_SHARE, FLATNESS, MOST_RESTS, MOST_TILT
from topple.topology.base.arrays import FloatArray
from topple.topology.bodies.solids import hull_vertices
from topple.topology.geometry.axes import cross, level_axes
from topple.topology.geometry.samples import centre_of_mass
from topple.topology.geometry.sides import inset
from topple.topology.geometry.thin import voxel_means


@dataclass(frozen=True)
class PlacementTolerances:
    """Lengths in metres, angles in radians.

    Attributes:
        cell: Grid of the free space: finer than any gap a hand can use.
        gap: Least distance to what stands there: a finger beside the object (20 mm) and 10 mm to spare.
        good_gap: Distance beyond which more does not help: the open hand's half width.
        edge: Distance kept from the table's edge, against tipping over it.
        drop: Height above the table at which it is let go: depth noise (2 mm) and tracking error (2 mm).
        headroom: Kept free between what is put down and a board above it: a hand from its fingertips to the
            wrist (15 cm) and the way straight down (6 cm).
        reach: Distances from the arm's base between which it works freely top-down.
        stray: Points this far below the others of a face still belong to it: noise of the cloud.
        least_steady: Below this it is taken to fall over: noise of the cloud's middle.
        least_barrier: Rise of the centre of mass to turn over that keeps a thing where it is put: a drop of
            4 mm leaves a fifth of its energy, and facets that noise cuts into a can's side make half as much.
        steady: Distance of the centre of mass from the edge of the face it stands on, where standing is safe.
        most_turn: Largest tilt by which an object may be turned to lie.
    """

    cell: float = 0.01
    gap: float = 0.03
    good_gap: float = 0.10
    edge: float = 0.03
    drop: float = 0.004
    headroom: float = 0.21
    reach: tuple[float, float] = (0.30, 0.70)
    stray: float = 0.003
    least_steady: float = 0.002
    least_barrier: float = 0.001
    steady: float = 0.015
    most_turn: float = 1.75


PLACEMENT_TOLERANCES = PlacementTolerances()


@dataclass(frozen=True, eq=False)
class Rest:
    """A way an object stands by itself.

    Attributes:
        rotation: (3, 3) rotation from how it lies now.
        turn: Its angle [rad].
        steadiness: Least distance of the centre of mass from the edge of the face it stands on [m].
        barrier: How far the centre of mass has to rise before it turns over the easiest way [m]: nothing for
            what can roll.
        rolls: Whether that is too little to keep it where it is put.
    """

    rotation: FloatArray
    turn: float
    steadiness: float
    barrier: float = 0.0
    rolls: bool = False

    def alike(self, other: "Rest") -> bool:
        """Whether another way is this one to a hand, but for its heading."""
        return bool(np.trace(self.rotation.T @ other.rotation) > 1.0 + 2.0 * np.cos(ALIKE))


def resting_poses(
    cloud: FloatArray,
    parts: Sequence[FloatArray],
    up: FloatArray,
    centre: FloatArray | None = None,
) -> list[Rest]:
    """The faces an object can stand on: flat ones before rounds it could roll on, then the least turn first.

    Args:
        cloud: (N, 3) its points [m].
        parts: Its convex parts [m].
        up: (3,) unit vector.
        centre: (3,) centre of mass [m] where it is known; else the density is taken as even.

    Returns:
        Resting poses, those that cannot roll before those that can; one near the attitude it has is among
        them, and is all there is where no face holds it.
    """
    few = voxel_means(cloud, 0.004, ahead=0.0)
    corners = hull_vertices(np.vstack([few, *parts]))
    centre = centre_of_mass(cloud, parts) if centre is None else centre
    found: list[Rest] = []
    flats = _flat_sides(few)
    for number, down in enumerate([*flats, *_face_normals(corners, up)]):
        turn = float(np.arccos(np.clip(-down @ up, -1.0, 1.0)))
        heights = corners @ down
        stray = FLAT_SHARE * float(np.ptp(heights)) if number < len(flats) else 0.0
        face = corners[heights > heights.max() - max(PLACEMENT_TOLERANCES.stray, stray)]
        steadiness = float(inset((face - centre) @ np.stack(level_axes(down), axis=1), np.zeros((1, 2)))[0])
        if turn <= PLACEMENT_TOLERANCES.most_turn and steadiness > PLACEMENT_TOLERANCES.least_steady:
            barrier = _barrier(corners - centre, down)
            rolls = barrier < PLACEMENT_TOLERANCES.least_barrier
            found.append(Rest(_rotation_between(down, -up), turn, steadiness, barrier, rolls))
    if not found:
        return [Rest(np.eye(3), 0.0, 0.0, rolls=True)]
    steady = PLACEMENT_TOLERANCES.steady
    found.sort(key=lambda rest: (rest.rolls, rest.turn - 0.15 * min(1.0, rest.steadiness / steady)))
    kept = list[Rest]()
    for rest in found:  # facets that noise cuts into a face are no faces of their own
        if len(kept) < MOST_RESTS and not any(rest.alike(other) for other in kept):
            kept.append(rest)
    if all(rest.turn > ALIKE for rest in kept):  # a hand may reach nothing but how it lies now
        least = min(found, key=lambda rest: rest.turn)
        kept.append(least if least.turn <= ALIKE else Rest(np.eye(3), 0.0, 0.0, rolls=True))
    return kept


def _barrier(corners: FloatArray, down: FloatArray) -> float:
    """How far a body's centre has to rise until it turns over on a level plane, the easiest way [m].

    Rolled without slipping, a convex body stands as high over the plane as its outline reaches in the
    direction that then points down; that height is looked up over a cone of directions.

    Args:
        corners: (V, 3) of the hull, from the centre of mass [m].
        down: (3,) unit vector that points down now, in the body.
    """
    x, y = level_axes(down)
    turns, tilts = np.arange(24) * (2.0 * np.pi / 24), np.linspace(0.0, MOST_TILT, 9)[1:]
    aside = np.cos(turns)[:, None] * x + np.sin(turns)[:, None] * y
    towards = np.cos(tilts)[:, None, None] * down + np.sin(tilts)[:, None, None] * aside
    heights = (towards.reshape(-1, 3) @ corners.T).max(axis=1).reshape(len(tilts), -1)
    return max(0.0, float(heights.max(axis=0).min() - (corners @ down).max()))


def _flat_sides(points: FloatArray) -> list[FloatArray]:
    """Both directions across a flat thing, which lies down on them whatever its bends; else none."""
    centred = points - points.mean(axis=0)
    _, _, axes = np.linalg.svd(centred, full_matrices=False)
    extents = np.ptp(centred @ axes.T, axis=0)
    return [axes[2], -axes[2]] if len(points) > 3 and extents[2] < FLATNESS * extents[0] else []


def _face_normals(corners: FloatArray, up: FloatArray, same: float = 0.14) -> list[FloatArray]:
    """Outward normals of a hull's faces, largest first; less than `same` [rad] apart is one face."""
    try:
        hull = ConvexHull(corners, qhull_options="QJ")
    except (QhullError, ValueError):
        return [-up]
    normals = hull.equations[:, :3]
    edges = corners[hull.simplices]
    areas = np.linalg.norm(cross(edges[:, 1] - edges[:, 0], edges[:, 2] - edges[:, 0]), axis=1) / 2.0
    kept: list[FloatArray] = []
    for index in np.argsort(-areas, kind="stable"):
        if areas[index] == 0.0:  # corners in a line: no face, and nothing stands on it
            break
        if all(normals[index] @ other < np.cos(same) for other in kept):
            near = normals @ normals[index] > np.cos(same)
            mean = (areas[near, None] * normals[near]).sum(axis=0)
            kept.append(mean / np.linalg.norm(mean))
        if len(kept) >= 40:
            break
    return kept


def _rotation_between(a: FloatArray, b: FloatArray) -> FloatArray:
    """The smallest rotation that takes unit vector a to unit vector b."""
    axis, cosine = cross(a, b), float(np.clip(a @ b, -1.0, 1.0))
    if cosine < -1.0 + 1e-9:
        axis, _ = level_axes(a)
        return 2.0 * np.outer(axis, axis) - np.eye(3)
    skew = np.array([[0.0, -axis[2], axis[1]], [axis[2], 0.0, -axis[0]], [-axis[1], axis[0], 0.0]])
    return np.eye(3) + skew + skew @ skew / (1.0 + cosine)


def about(axis: FloatArray, angle: float) -> FloatArray:
    """Rotation about an axis (Rodrigues).

    Args:
        axis: (3,) unit vector.
        angle: Angle [rad].

    Returns:
        (3, 3) rotation.
    """
    skew = np.array([[0.0, -axis[2], axis[1]], [axis[2], 0.0, -axis[0]], [-axis[1], axis[0], 0.0]])
    return np.eye(3) + np.sin(angle) * skew + (1.0 - np.cos(angle)) * skew @ skew
