"""What points of no object show: the table on which the objects stand, and things without a name."""

from collections.abc import Iterable, Iterator, Mapping, Sequence

import numpy as np
from scipy import ndimage

from topple.topology.base.arrays import BoolArray, FloatArray, bounds, within_corners
from topple.topology.base.values import free_name
from topple.topology.geometry.axes import level_axes, perpendiculars
from topple.topology.geometry.pieces import pieces_of
from topple.topology.geometry.plane import TABLE, fit_plane, table_by_name
from topple.topology.geometry.sides import beyond, joggled_sides
from topple.topology.geometry.thin import cell_keys, voxel_means
from topple.topology.geometry.tolerances import LINKED, ON_PLANE
from topple.topology.kernels.neighbours import PointTree
from topple.topology.scene.tolerances import (
    BESIDE,
    IN_COMMON,
    LEAST_PLATE,
    MATTER_FEWEST,
    MATTER_SPACING,
    NEAR,
    OVER,
    PLANE_FEWEST,
    PLANES,
    REACH,
    RISES,
    ROBOT_NEAR,
    SAME,
    STANDS,
    TABLE_CELL,
)


def find_table(
    background: FloatArray, clouds: Mapping[str, FloatArray], viewpoints: FloatArray
) -> FloatArray | None:
    """Find the surface that carries the objects among points that belong to none.

    Of the planes near the objects (RANSAC, refined by least squares), those count that have the cameras and
    the objects on one side; the one on which most objects stand is taken, of several the largest, with all of
    its points that hang together under and around them.

    Args:
        background: Points (N, 3) in [m] that belong to no object.
        clouds: Points (N, 3) in [m] per object, at least one.
        viewpoints: Camera centres (k, 3) in [m], k >= 0.

    Returns:
        The table's points (M, 3), a part of the background; None where no plane carries an object.
    """
    lower, upper = bounds(np.concatenate(list(clouds.values())))
    left = background[((background >= lower - NEAR) & (background <= upper + NEAR)).all(axis=1)]
    best = (-1, 0)
    table: FloatArray | None = None
    for _ in range(PLANES):
        if len(left) < PLANE_FEWEST:
            break
        plane, _ = fit_plane(left)
        on = _on(left, plane)
        count = int(on.sum())
        if count < PLANE_FEWEST:
            break
        score = (_count_standing(plane, clouds, viewpoints), count)
        if score > best and score[0] >= 0:
            best, table = score, plane
        left = left[~on]
    return None if table is None else hanging_together(background, table, clouds)


def table_among(
    clouds: dict[str, FloatArray], background: FloatArray, viewpoints: FloatArray, notes: list[str]
) -> list[str]:
    """Find the table of a scene in which nothing is fixed, by its name or in what belongs to no object.

    Args:
        clouds: Points (N, 3) in [m] per object, at least one; a table that is found is added.
        background: Points (N, 3) in [m] that belong to no object.
        viewpoints: Camera centres (k, 3) in [m].
        notes: Where the sentence that says so is added.

    Returns:
        The names of what is fixed by this: one or none.
    """
    named = table_by_name(clouds)
    if named is not None:
        notes.append(f"{named!r} is taken as fixed because of its name")
        return [named]
    found = find_table(background, clouds, viewpoints)
    if found is None:
        return []
    clouds[TABLE] = found
    notes.append(
        f"{TABLE!r} is the plane found under the objects in what has no label ({len(found)} points): "
        "it is taken as fixed"
    )
    return [TABLE]


def without_bodies(points: FloatArray, bodies: Iterable[FloatArray]) -> FloatArray:
    """Leave out the points of convex bodies, `ROBOT_NEAR` around each.

    Args:
        points: (N, 3) points [m].
        bodies: (V, 3) corners of each body [m]: a robot's in its own picture.

    Returns:
        (M, 3) the others [m].
    """
    if len(points) == 0:
        return points
    keys = cell_keys(points, *bounds(points), ROBOT_NEAR / 4)  # a point stands for those of its cube
    _, first, cube = np.unique(keys, return_index=True, return_inverse=True)
    some, own = points[first], np.zeros(len(first), dtype=np.bool_)
    for body in bodies:
        lower, upper = bounds(body)
        near = np.flatnonzero(~own & within_corners(some, lower - ROBOT_NEAR, upper + ROBOT_NEAR))
        own[near] = beyond(joggled_sides(body), some[near]) < ROBOT_NEAR
    return points[~own[cube]]


def unnamed_among(
    background: FloatArray,
    clouds: Mapping[str, FloatArray],
    fixed: Iterable[str],
    up: FloatArray,
    things: bool = True,
) -> tuple[dict[str, FloatArray], FloatArray, list[str]]:
    """Find what has no name above what carries the objects: things over, under or at these, and matter.

    A wall, a screen or another table reaches beyond the objects: it is no thing that one could take away, but
    in the way.

    Args:
        background: (N, 3) points [m] that belong to no object.
        clouds: Points (N, 3) [m] per object.
        fixed: Names of those that never move.
        up: (3,) unit vector.
        things: Whether there are things; else they are matter as well.

    Returns:
        (M, 3) points of each thing, the largest first, by the names that they get, and of each object that a
        picture shows without a mask; (K, 3) points of matter, `MATTER_SPACING` apart; sentences on all these.
    """
    fixed = list(fixed)
    movable = {name: cloud for name, cloud in clouds.items() if name not in fixed}
    if not fixed or not movable or len(background) == 0:
        return {}, np.empty((0, 3)), []
    lower, upper = bounds(np.concatenate(list(movable.values())))
    around = background[within_corners(background, lower - REACH, upper + REACH)]
    around = around[
        _above_lowest([clouds[name] for name in fixed], np.mean([lower, upper], axis=0), up, around)
    ]
    lower, upper = lower - BESIDE, upper + BESIDE
    points, matter = around[within_corners(around, lower, upper)], surface_of(around)
    mended, found, notes = dict[str, FloatArray](), dict[str, FloatArray](), list[str]()
    for name, piece in _elsewhere_masked(points, movable):
        own = _near(piece, points, LINKED / 2)
        mended[name] = np.concatenate([mended.get(name, movable[name]), points[own]])
        points, matter = points[~own], matter[~_near(piece, matter, LINKED)]
    notes += [
        f"a picture that shows {name!r} has no mask of it: its points are taken for it" for name in mended
    ]
    known = np.concatenate([voxel_means(cloud, SAME / 2) for cloud in clouds.values()])
    points, matter = (some[~_near(known, some, SAME)] for some in (points, matter))
    level = np.stack(level_axes(up), axis=1)  # (3, 2)
    below = {name: voxel_means(cloud, LINKED / 3) @ level for name, cloud in movable.items()}
    for piece in sorted(pieces_of(voxel_means(points, LINKED / 3)), key=len, reverse=True):
        if not things or not within_corners(piece, lower + LINKED, upper - LINKED).all():
            continue
        near = [name for name, under in below.items() if _near(under, piece @ level, LINKED).any()]
        if near:
            name = free_name(f"unnamed_{len(found) + 1}", {*clouds, *found})
            found[name] = points[_near(piece, points, LINKED / 2)]
            matter = matter[~_near(piece, matter, LINKED)]
            at = ", ".join(near)
            notes.append(f"something without a name is at {at}: {name!r}; take it away, or name it")
    return {**mended, **found}, matter, notes + _note_of_matter(matter)


def _above_lowest(
    supports: Sequence[FloatArray], middle: FloatArray, up: FloatArray, points: FloatArray
) -> BoolArray:
    """Which points rise above the lowest under a place of what never moves: others may carry some alone."""
    planes = [plane * np.sign(plane[:3] @ up) for plane, _ in (fit_plane(each, up=up) for each in supports)]
    lowest = max(planes, key=lambda plane: float(plane[:3] @ middle + plane[3]))
    return np.asarray(points @ lowest[:3] + lowest[3] > RISES)


def surface_of(points: FloatArray) -> FloatArray:
    """Thin points to one for each cube that holds a surface: what flies between surfaces is left out.

    Args:
        points: (N, 3) points [m].

    Returns:
        (M, 3) means of the points in cubes with an edge of `MATTER_SPACING`.
    """
    means = voxel_means(points, MATTER_SPACING, fewest=2)
    if len(means) == 0:
        return means
    keys = cell_keys(means, *bounds(means), LEAST_PLATE)
    _, cell, count = np.unique(keys, return_inverse=True, return_counts=True)
    return means[count[cell] >= MATTER_FEWEST]


def _near(some: FloatArray, points: FloatArray, reach: float) -> BoolArray:
    """Which points (N, d) lie within a reach [m] of some (M, d)."""
    return np.isfinite(PointTree(some).query(points, distance_upper_bound=reach)[0])


def _elsewhere_masked(
    points: FloatArray, movable: Mapping[str, FloatArray]
) -> Iterator[tuple[str, FloatArray]]:
    """Pieces (K, 3) [m] of what no mask names that are of an object which has one in another picture.

    They have surface in common with what is known of it; another thing has next to none with what it touches.
    """
    known = {name: voxel_means(cloud, SAME / 2) for name, cloud in movable.items()}
    tree = PointTree(np.concatenate(list(known.values())))
    whose = np.repeat(np.arange(len(known)), [len(cloud) for cloud in known.values()])
    for piece in pieces_of(voxel_means(points, LINKED / 3)):
        distance, nearest = tree.query(piece)
        common = np.bincount(whose[nearest[distance < SAME / 2]], minlength=len(known))
        if common.max() > IN_COMMON * len(piece):
            yield list(known)[int(common.argmax())], piece


def _note_of_matter(points: FloatArray) -> list[str]:
    if len(points) == 0:
        return []
    low, high = (", ".join(f"{value:.2f}" for value in corner) for corner in bounds(points))
    return [
        f"what no mask names reaches beyond the objects: {len(points)} points {1e2 * MATTER_SPACING:g} cm "
        f"apart, between ({low}) and ({high}) m, are obstacles"
    ]


def _on(points: FloatArray, plane: FloatArray) -> BoolArray:
    """Which points (N, 3) lie in a plane, as far as noise lets them."""
    return np.abs(points @ plane[:3] + plane[3]) <= ON_PLANE


def _count_standing(plane: FloatArray, clouds: Mapping[str, FloatArray], viewpoints: FloatArray) -> int:
    """How many objects are seen to stand on a plane; from right above none may be.

    Returns:
        The count, or -1 where objects or cameras are on the wrong side of it, or it lies far below them.
    """
    heights = {name: cloud @ plane[:3] + plane[3] for name, cloud in clouds.items()}
    middle = float(np.median([np.median(each) for each in heights.values()]))
    side = 1.0 if middle > 0 else -1.0
    if len(viewpoints) and (side * (viewpoints @ plane[:3] + plane[3]) <= 0).any():
        return -1
    lowest = np.array([np.quantile(side * each, 0.02) for each in heights.values()])
    if (lowest > -STANDS).mean() < OVER or np.median(lowest) > NEAR:
        return -1
    return int(np.count_nonzero(np.abs(lowest) <= STANDS))


def hanging_together(
    background: FloatArray, plane: FloatArray, clouds: Mapping[str, FloatArray]
) -> FloatArray:
    """Points in a plane that hang together under and around objects: of no other table beyond a gap.

    Args:
        background: (N, 3) points [m] that belong to no object.
        plane: (4,) with a unit normal, as (n, d).
        clouds: Points (N, 3) [m] per object.

    Returns:
        (M, 3) those of them [m].
    """
    points = background[_on(background, plane)]
    if len(points) == 0:
        return points
    axes = np.stack(perpendiculars(plane[:3]), axis=1)  # (3, 2)
    places, covered = points @ axes, np.concatenate(list(clouds.values())) @ axes
    corner = np.minimum(places.min(axis=0), covered.min(axis=0))
    cells, hidden = (np.floor((each - corner) / TABLE_CELL).astype(np.int64) for each in (places, covered))
    occupied = np.zeros(np.maximum(cells.max(axis=0), hidden.max(axis=0)) + 1, dtype=np.bool_)
    occupied[tuple(cells.T)] = occupied[tuple(hidden.T)] = True
    parts = np.zeros(occupied.shape, dtype=np.int32)
    ndimage.label(occupied, structure=np.ones((3, 3)), output=parts)
    under = np.unique(parts[tuple(hidden.T)])
    return points[np.isin(parts[tuple(cells.T)], under)]
