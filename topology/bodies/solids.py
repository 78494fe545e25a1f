"""What a scene's clouds fill: convex parts of every object, hidden undersides added, tops as slabs."""

import hashlib
from collections.abc import Callable, Mapping, Sequence

import numpy as np
from scipy.spatial import ConvexHull, QhullError

from topple.topology.base.arrays import BoolArray, FloatArray, round_off
from topple.topology.base.errors import InvalidInput
from topple.topology.base.tolerances import DEPTH_NOISE
from topple.topology.bodies.matter import MATTER, plates_along
from topple.topology.bodies.parts import convex_parts
from topple.topology.bodies.plates import plates_of
from topple.topology.bodies.tolerances import BOARD, GRAIN, HOLLOW, SKIN, SKY, SLAB, SOLIDS_CELL
from topple.topology.bodies.tops import Top, tops_of
from topple.topology.geometry.axes import level_axes
from topple.topology.geometry.pieces import pieces_of
from topple.topology.geometry.rigid import move_points
from topple.topology.geometry.samples import centre_of_mass
from topple.topology.geometry.sides import beyond, sides_of
from topple.topology.geometry.thin import spacing_of, voxel_means
from topple.topology.geometry.tolerances import LINKED, PIECE_FEWEST
from topple.topology.kernels.neighbours import PointTree
from topple.topology.scene.scene import Scene
from topple.topology.scene.tolerances import MATTER_SPACING

Solids = Mapping[str, Sequence[FloatArray]]
"""Per object the (V, 3) vertices of its convex parts, in the world [m]."""

REMEMBERED = (
    128  # clouds whose parts are kept: a scene is filled again after each step, with most clouds unchanged
)

NOTHING = np.empty((0, 3))
"""No points."""

_PARTS: dict[bytes, tuple[FloatArray, ...]] = {}


def up_of(scene: Scene) -> FloatArray:
    """The scene's up direction.

    Args:
        scene: The scene.

    Returns:
        (3,) unit vector.

    Raises:
        InvalidInput: The scene has none.
    """
    if scene.up is None:
        raise InvalidInput("handling needs to know where up is: give up=[X, Y, Z] or name a fixed table")
    up = np.asarray(scene.up, dtype=np.float64)
    return up / np.linalg.norm(up)


def solids_of(scene: Scene) -> dict[str, tuple[FloatArray, ...]]:
    """Fill every object of a scene.

    An object does not hover: where nothing it could stand on comes up to its lowest seen points, what is
    missing in between is its own unseen underside, and its parts are drawn down to it.

    Args:
        scene: The scene, with `up`.

    Returns:
        The convex parts of every object, in the world; those of `scene.matter` as `MATTER`.
    """
    up = up_of(scene)
    found: dict[str, tuple[FloatArray, ...]] = {}
    for name, cloud in scene.clouds.items():
        if name in scene.fixed:
            others = [points for other, points in scene.clouds.items() if other != name]
            found[name] = fixed_parts(cloud, up, np.vstack([NOTHING, *others]))
        else:
            found[name] = standing_parts(name, scene)
    if len(scene.matter):
        eyes = scene.viewpoints if len(scene.viewpoints) else scene.matter.mean(axis=0)[None] + SKY * up
        found[MATTER] = _parts_once(scene.matter, eyes.tobytes(), lambda: plates_along(scene.matter, eyes))
    return found


def centre_in(scene: Scene, name: str, parts: Sequence[FloatArray]) -> FloatArray:
    """(3,) centre of mass of an object [m]: as the scene gives it, else that of its convex parts."""
    known = scene.centres.get(name)
    return centre_of_mass(scene.clouds[name], parts) if known is None else known


def standing_parts(name: str, scene: Scene) -> tuple[FloatArray, ...]:
    """Convex parts of a movable object, drawn down to what it stands on.

    Args:
        name: The object.
        scene: The scene, with `up`.

    Returns:
        (V, 3) vertices of each part.
    """
    up = up_of(scene)
    gap = 0.0 if name in scene.whole else hidden_depth(name, scene, up)
    return tuple(drawn_down(part, gap, up) for part in parts_of(scene.clouds[name], scene))


def parts_of(cloud: FloatArray, scene: Scene) -> tuple[FloatArray, ...]:
    """Convex parts of what is seen of an object.

    Args:
        cloud: (N, 3) its points [m].
        scene: The scene, for the cameras that tell a hollow from a side nobody saw.

    Returns:
        (V, 3) vertices of each part.
    """
    seen_from = scene.viewpoints if len(scene.viewpoints) > 0 else None
    key = b"" if seen_from is None else seen_from.tobytes()
    return _parts_once(
        cloud, key, lambda: convex_parts(voxel_means(cloud, GRAIN, ahead=0.0), HOLLOW, viewpoints=seen_from)
    )


def _parts_once(
    cloud: FloatArray, more: bytes, make: Callable[[], tuple[FloatArray, ...]]
) -> tuple[FloatArray, ...]:
    """The parts of a cloud, made once."""
    key = hashlib.blake2b(cloud.tobytes() + more).digest()
    if key not in _PARTS:
        if len(_PARTS) >= REMEMBERED:
            _PARTS.pop(next(iter(_PARTS)))
        _PARTS[key] = make()
    return _PARTS[key]


def fixed_parts(cloud: FloatArray, up: FloatArray, others: FloatArray = NOTHING) -> tuple[FloatArray, ...]:
    """Parts of something that never moves: slabs under its tops, plates and convex parts of the rest.

    A top goes on where its points leave gaps, as things stand there or hide it, unless something is seen in a
    gap below its level: in the corner of an L, or through a hole.

    Args:
        cloud: (N, 3) points [m].
        up: (3,) unit vector.
        others: (M, 3) points of everything else that was seen [m].

    Returns:
        (V, 3) vertices of each part.
    """
    found = tops_of(cloud, up)
    spacing = spacing_of(cloud)
    slabs = [
        _slab(top, piece, thickness, up)
        for top, thickness in zip(found.tops, _thick(found.tops), strict=True)
        for piece in _extents(top, np.vstack([cloud, others]), spacing, up)
    ]
    rest = found.rest
    for slab in slabs:
        rest = rest[~_inside(rest, slab)]
    if len(rest) < PIECE_FEWEST:
        return tuple(slabs)
    more = up.tobytes() + b"fixed"
    return (*slabs, *_parts_once(rest, more, lambda: _plates(rest, up, spacing)))


def _plates(rest: FloatArray, up: FloatArray, spacing: float) -> tuple[FloatArray, ...]:
    """Plates and convex parts of what of a fixed cloud is no top."""
    return plates_of(voxel_means(rest, 2 * GRAIN, ahead=0.0), HOLLOW, up, spacing=spacing)


def _extents(top: Top, seen: FloatArray, spacing: float, up: FloatArray) -> Sequence[FloatArray]:
    """Points (K, 3) [m] of pieces of a top, the hull of each of which is a board."""
    below = seen[top.above(seen) < -SKIN]
    below = below[_inside(below - np.outer(top.above(below), top.normal), _slab(top, top.points, SKIN, up))]
    if len(below):
        level = np.stack(level_axes(up), axis=1)
        reach = max(LINKED, spacing) + LINKED
        below = below[PointTree(top.points @ level).query(below @ level)[0] > reach]
    if not pieces_of(voxel_means(below, 2 * GRAIN, ahead=0.0), spacing):
        return (top.points,)
    sky = top.points.mean(axis=0)[None] + SKY * up
    return plates_along(voxel_means(top.points, MATTER_SPACING), sky)


def _slab(top: Top, points: FloatArray, thickness: float, up: FloatArray) -> FloatArray:
    """(V, 3) corners of the board under points (K, 3) of a top [m]."""
    rim = hull_vertices(points - np.outer(top.above(points), top.normal))
    return np.vstack([rim, rim - thickness * up])


def _thick(tops: Sequence[Top]) -> list[float]:
    """How thick the boards under some tops, the highest first, are taken to be [m]."""
    unseen = [BOARD] * len(tops)
    unseen[-1:] = [SLAB] * (len(tops) > 0)
    return [
        least if np.isnan(top.thickness) else max(top.thickness, BOARD)
        for top, least in zip(tops, unseen, strict=True)
    ]


def _inside(points: FloatArray, corners: FloatArray) -> BoolArray:
    """Which of (N, 3) points lie in or on a convex part."""
    sides = sides_of(corners)
    return np.zeros(len(points), dtype=np.bool_) if sides is None else beyond(sides, points) < SKIN


def hidden_depth(name: str, scene: Scene, up: FloatArray) -> float:
    """How far an object reaches below its lowest seen points: the drop until something would carry it [m].

    Args:
        name: The object.
        scene: The scene.
        up: (3,) unit vector.

    Returns:
        The depth, 0 where it is seen to stand on something or nothing lies below.
    """
    axes = np.stack(level_axes(up))
    own = scene.clouds[name]
    cells = np.floor(own @ axes.T / SOLIDS_CELL).astype(np.int64)
    corner, size = cells.min(axis=0), np.ptp(cells, axis=0) + 1
    bottom = np.full(tuple(size), np.inf)
    np.minimum.at(bottom, tuple((cells - corner).T), own @ up)
    gap = np.inf
    for other, cloud in scene.clouds.items():
        if other == name:
            continue
        if other in scene.fixed:
            found = tops_of(cloud, up)
            top, cloud = found.under(own), found.rest
            if top is not None:
                # of the same points that the parts are drawn around: they shall end on the table, not below
                gap = min(gap, float(top.above(voxel_means(own, GRAIN, ahead=0.0)).min()))
        places = np.floor(cloud @ axes.T / SOLIDS_CELL).astype(np.int64) - corner
        shared = np.all((places >= 0) & (places < size), axis=1)
        room = bottom[tuple(places[shared].T)] - cloud[shared] @ up
        below = room[np.isfinite(room) & (room > -SOLIDS_CELL)]  # points above the object do not count
        if len(below) > 0:
            gap = min(gap, max(0.0, float(below.min())))
    return float(gap) if DEPTH_NOISE < gap < np.inf else 0.0


def drawn_down(part: FloatArray, depth: float, up: FloatArray) -> FloatArray:
    """Extend a convex part straight down.

    Args:
        part: (V, 3) vertices [m].
        depth: How far [m].
        up: (3,) unit vector.

    Returns:
        (W, 3) vertices of the extended part.
    """
    return part if depth <= 0.0 else np.vstack([part, part - depth * up])


def hull_vertices(points: FloatArray) -> FloatArray:
    """Corners of the convex hull of a cloud, flat ones too.

    Args:
        points: (N, 3) points [m].

    Returns:
        (V, 3) corners; all points where there are too few for a hull.
    """
    if len(points) < 5:
        return points
    centred = points - points.mean(axis=0)
    _, _, axes = np.linalg.svd(centred, full_matrices=False)
    along = round_off(centred @ axes.T)
    rank = int(np.count_nonzero(np.ptp(along, axis=0) > 1e-6))
    if rank < 2:
        return points[[int(np.argmin(along[:, 0])), int(np.argmax(along[:, 0]))]]
    try:
        return points[ConvexHull(along[:, :rank]).vertices]
    except QhullError:
        return points


def move_parts(parts: Sequence[FloatArray], pose: FloatArray) -> tuple[FloatArray, ...]:
    """Parts under a rigid transform.

    Args:
        parts: (V, 3) vertices each [m].
        pose: (4, 4) rigid transform.

    Returns:
        The transformed parts.
    """
    return tuple(move_points(part, pose) for part in parts)
