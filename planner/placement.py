"""Where to put things down: free, reachable places on the table, the object resting as it would by itself."""

from collections.abc import Collection, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.ndimage import distance_transform_edt
from scipy.spatial import ConvexHull, Delaunay, QhullError

from topple.planner.grasp.surface import centre_of_mass, voxel_means
from topple.planner.solids import Solids, hull_vertices, level_axes, solids_of, table_top, up_of
from topple.topology.arrays import BoolArray, FloatArray, frozen
from topple.topology.errors import UnknownObject
from topple.topology.scene import Scene


@dataclass(frozen=True)
class PlacementTolerances:
    """Lengths in metres, angles in radians.

    Attributes:
        cell: Grid of the free space: finer than any gap a hand can use.
        gap: Least distance to what stands there: a finger beside the object (20 mm) and 10 mm to spare.
        good_gap: Distance beyond which more does not help: the open hand's half width.
        edge: Distance kept from the table's edge, against tipping over it.
        drop: Height above the table at which it is let go: depth noise (2 mm) and tracking error (2 mm).
        reach: Distances from the arm's base between which it works freely top-down.
        stray: Points this far below the others of a face still belong to it: noise of the cloud.
        steady: Distance of the centre of mass from the edge of the face it stands on, where standing is safe.
        most_turn: Largest tilt by which an object may be turned to lie.
    """

    cell: float = 0.01
    gap: float = 0.03
    good_gap: float = 0.10
    edge: float = 0.03
    drop: float = 0.004
    reach: tuple[float, float] = (0.30, 0.70)
    stray: float = 0.003
    steady: float = 0.015
    most_turn: float = 1.75


PLACEMENT_TOLERANCES = PlacementTolerances()


@dataclass(frozen=True, eq=False)
class Placement:
    """A place for an object.

    Attributes:
        pose_before_to_after: (4, 4) rigid transform in the world that moves the object from where it is now.
        score: 0..1, higher is better.
        rest: How it stands there, in words.
    """

    pose_before_to_after: FloatArray
    score: float
    rest: str = ""

    def __post_init__(self) -> None:
        object.__setattr__(self, "pose_before_to_after", frozen(self.pose_before_to_after))


@dataclass(frozen=True, eq=False)
class Rest:
    """A way an object stands by itself.

    Attributes:
        rotation: (3, 3) rotation from how it lies now.
        turn: Its angle [rad].
        steadiness: Least distance of the centre of mass from the edge of the face it stands on [m].
    """

    rotation: FloatArray
    turn: float
    steadiness: float


@dataclass(frozen=True, eq=False)
class FreeSpace:
    """What of a table is free.

    Attributes:
        origin: (2,) level coordinates of the grid's corner [m].
        distance: (I, J) distance of each cell to the nearest thing, edge or unseen table [m].
        normal: (3,) unit normal of the table.
        height: Of the table along the normal [m].
        cell: Edge of a cell [m].
    """

    origin: FloatArray
    distance: FloatArray
    normal: FloatArray
    height: float
    cell: float

    def at(self, places: FloatArray) -> FloatArray:
        """Distance to the nearest thing.

        Args:
            places: (..., 2) level coordinates [m].

        Returns:
            (...) distances [m], 0 outside the table.
        """
        index = np.floor((places - self.origin) / self.cell).astype(np.int64)
        shape = np.array(self.distance.shape)
        inside = np.all((index >= 0) & (index < shape), axis=-1)
        index = np.clip(index, 0, shape - 1)
        return np.where(inside, self.distance[index[..., 0], index[..., 1]], 0.0)


def placements(
    name: str,
    scene: Scene,
    solids: Solids | None = None,
    *,
    pose_base_to_world: FloatArray | None = None,
    avoid: Sequence[FloatArray] = (),
    limit: int = 24,
    tolerances: PlacementTolerances = PLACEMENT_TOLERANCES,
) -> list[Placement]:
    """Find free places on the table for an object.

    Args:
        name: The object.
        scene: The scene, with `up` and a fixed flat surface.
        solids: Convex parts of the objects; made from the scene where not given.
        pose_base_to_world: (4, 4) the arm's base: places within its reach and off its foot.
        avoid: (N, 3) points each: places to keep free besides.
        limit: At most so many, spread over the table.
        tolerances: Distances.

    Returns:
        Placements, best first; empty where there is no room. Deterministic.

    Raises:
        UnknownObject: The scene has no such object.
    """
    if name not in scene.clouds:
        raise UnknownObject(name, scene.names)
    up = up_of(scene)
    solids = solids_of(scene) if solids is None else solids
    space = free_space(scene, solids, leave_out={name}, avoid=avoid, tolerances=tolerances)
    if space is None:
        return []
    base = None if pose_base_to_world is None else np.stack(level_axes(up)) @ pose_base_to_world[:3, 3]
    found: list[Placement] = []
    for rest in resting_poses(scene.clouds[name], solids[name], up, tolerances):
        found += _at_rest(scene.clouds[name], solids[name], rest, space, up, base, tolerances)
    return _spread_out(found, scene.clouds[name].mean(axis=0), limit)


def resting_poses(
    cloud: FloatArray,
    parts: Sequence[FloatArray],
    up: FloatArray,
    tolerances: PlacementTolerances = PLACEMENT_TOLERANCES,
) -> list[Rest]:
    """The faces an object can stand on, those that turn it least first.

    Args:
        cloud: (N, 3) its points [m].
        parts: Its convex parts [m].
        up: (3,) unit vector.
        tolerances: What counts as one face and as steady.

    Returns:
        Resting poses, at least one: where no face holds it, it keeps the attitude it has.
    """
    corners = np.vstack([hull_vertices(np.vstack([voxel_means(cloud, 0.004), *parts]))])
    centre = centre_of_mass(cloud, parts)
    found: list[Rest] = []
    for down in _face_normals(corners, up):
        turn = float(np.arccos(np.clip(-down @ up, -1.0, 1.0)))
        heights = corners @ down
        face = corners[heights > heights.max() - tolerances.stray]
        steadiness = _inset(face, centre, down)
        if turn <= tolerances.most_turn and steadiness > 0.0:
            found.append(Rest(_rotation_between(down, -up), turn, steadiness))
    if not found:
        return [Rest(np.eye(3), 0.0, 0.0)]
    wanted = [rest for rest in found if rest.steadiness > 0.3 * tolerances.steady] or found
    return sorted(wanted, key=lambda rest: rest.turn - 0.15 * min(1.0, rest.steadiness / tolerances.steady))[
        :3
    ]


def _face_normals(corners: FloatArray, up: FloatArray, same: float = 0.14) -> list[FloatArray]:
    """Outward normals of a hull's faces, largest first; less than `same` [rad] apart is one face."""
    try:
        hull = ConvexHull(corners, qhull_options="QJ")
    except (QhullError, ValueError):
        return [-up]
    normals = hull.equations[:, :3]
    edges = corners[hull.simplices]
    areas = np.linalg.norm(np.cross(edges[:, 1] - edges[:, 0], edges[:, 2] - edges[:, 0]), axis=1) / 2.0
    kept: list[FloatArray] = []
    for index in np.argsort(-areas, kind="stable"):
        if all(normals[index] @ other < np.cos(same) for other in kept):
            near = normals @ normals[index] > np.cos(same)
            mean = (areas[near, None] * normals[near]).sum(axis=0)
            kept.append(mean / np.linalg.norm(mean))
        if len(kept) >= 40:
            break
    return kept


def _inset(face: FloatArray, centre: FloatArray, down: FloatArray) -> float:
    """How far inside a face's outline the centre of mass stands over it [m], negative outside."""
    x, y = level_axes(down)
    outline = np.stack([(face - centre) @ x, (face - centre) @ y], axis=1)
    try:
        hull = ConvexHull(outline)
    except (QhullError, ValueError):
        return -1.0
    return float(-hull.equations[:, 2].max())


def _rotation_between(a: FloatArray, b: FloatArray) -> FloatArray:
    """The smallest rotation that takes unit vector a to unit vector b."""
    axis, cosine = np.cross(a, b), float(np.clip(a @ b, -1.0, 1.0))
    if cosine < -1.0 + 1e-9:
        axis, _ = level_axes(a)
        return 2.0 * np.outer(axis, axis) - np.eye(3)
    skew = np.array([[0.0, -axis[2], axis[1]], [axis[2], 0.0, -axis[0]], [-axis[1], axis[0], 0.0]])
    return np.eye(3) + skew + skew @ skew / (1.0 + cosine)


def free_space(
    scene: Scene,
    solids: Solids,
    *,
    leave_out: Collection[str] = (),
    avoid: Sequence[FloatArray] = (),
    tolerances: PlacementTolerances = PLACEMENT_TOLERANCES,
) -> FreeSpace | None:
    """Map what of the table is free, everything seen from straight above.

    Args:
        scene: The scene.
        solids: Convex parts of its objects.
        leave_out: Objects that do not count, for they are to be moved.
        avoid: (N, 3) points each, of places to keep free besides.
        tolerances: Grid and distance from the edge.

    Returns:
        The map, or None where the scene has no fixed level surface.
    """
    up = up_of(scene)
    axes = np.stack(level_axes(up))
    tables = [
        (name, top)
        for name in scene.names
        if name in scene.fixed and (top := table_top(scene.clouds[name], up))
    ]
    if not tables:
        return None
    table, (normal, height) = max(tables, key=lambda item: len(scene.clouds[item[0]]))
    ground = scene.clouds[table] @ axes.T
    origin = ground.min(axis=0)
    shape = np.ceil((ground.max(axis=0) - origin) / tolerances.cell).astype(int) + 1
    middles = origin + (np.stack(np.indices(tuple(shape)), axis=-1) + 0.5) * tolerances.cell
    free = _within(middles, ground)
    edge = _to_nearest(free) * tolerances.cell
    free &= edge > tolerances.edge
    for name in scene.names:
        if name != table and name not in leave_out:
            for part in solids[name]:
                free &= ~_within(middles, part @ axes.T)
            _mark(free, scene.clouds[name] @ axes.T, origin, tolerances.cell)
    for points in avoid:
        free &= ~_within(middles, points @ axes.T)
    return FreeSpace(origin, _to_nearest(free) * tolerances.cell, normal, height, tolerances.cell)


def _to_nearest(free: BoolArray) -> FloatArray:
    """Distance of every cell to the nearest one that is not free or beyond the edge, in cells."""
    distance: FloatArray = np.asarray(distance_transform_edt(np.pad(free, 1)), dtype=np.float64)
    return distance[1:-1, 1:-1]


def _within(places: FloatArray, points: FloatArray) -> BoolArray:
    """Which places lie in the convex outline of level points."""
    low, high = points.min(axis=0), points.max(axis=0)
    result = np.all((places >= low) & (places <= high), axis=-1)
    try:
        corners = points[ConvexHull(points).vertices]
        result[result] = Delaunay(corners).find_simplex(places[result]) >= 0
    except (QhullError, ValueError):
        pass  # a line or a point: its box is it
    return result


def _mark(free: BoolArray, points: FloatArray, origin: FloatArray, cell: float) -> None:
    index = np.floor((points - origin) / cell).astype(np.int64)
    inside = np.all((index >= 0) & (index < np.array(free.shape)), axis=1)
    free[index[inside, 0], index[inside, 1]] = False


def _at_rest(
    cloud: FloatArray,
    parts: Sequence[FloatArray],
    rest: Rest,
    space: FreeSpace,
    up: FloatArray,
    base: FloatArray | None,
    tolerances: PlacementTolerances,
    yaws: int = 8,
) -> list[Placement]:
    """Every free place and heading for an object in one resting pose."""
    axes = np.stack(level_axes(up))
    middle = cloud.mean(axis=0)
    body = np.vstack([voxel_means(cloud, 0.008), *parts])
    open_cells = np.argwhere(space.distance[::2, ::2] > tolerances.gap)
    places = space.origin + (2.0 * open_cells + 0.5) * space.cell
    if base is not None and len(places) > 0:
        far = np.linalg.norm(places - base, axis=1)
        places = places[(far > tolerances.reach[0]) & (far < tolerances.reach[1])]
    found: list[Placement] = []
    for k in range(yaws):
        rotation = _about(up, 2.0 * np.pi * k / yaws) @ rest.rotation
        turned = (body - middle) @ rotation.T
        outline = np.unique(np.round(turned @ axes.T / space.cell), axis=0) * space.cell
        room = space.at(places[:, None, :] + outline[None, :, :]).min(axis=1)
        lift = space.height + tolerances.drop - float((turned @ space.normal).min())
        for place, gap in zip(places, room, strict=True):
            if gap > tolerances.gap:
                target = axes.T @ place
                target = target + up * (lift - float(target @ space.normal)) / float(up @ space.normal)
                pose = np.eye(4)
                pose[:3, :3], pose[:3, 3] = rotation, target - rotation @ middle
                found.append(_scored(pose, rest, float(gap), place, axes @ middle, base, k, yaws, tolerances))
    return found


def _scored(
    pose: FloatArray,
    rest: Rest,
    gap: float,
    place: FloatArray,
    before: FloatArray,
    base: FloatArray | None,
    yaw: int,
    yaws: int,
    tolerances: PlacementTolerances,
) -> Placement:
    room = min(1.0, gap / tolerances.good_gap)
    way = 1.0 / (1.0 + float(np.linalg.norm(place - before)) / 0.5)
    easy = 1.0
    if base is not None:
        comfortable = 0.5 * (tolerances.reach[0] + tolerances.reach[1])
        easy = 1.0 - min(1.0, abs(float(np.linalg.norm(place - base)) - comfortable) / comfortable)
    heading = 1.0 - min(yaw, yaws - yaw) / yaws
    upright = 1.0 - rest.turn / np.pi
    steady = min(1.0, rest.steadiness / tolerances.steady)
    score = 0.3 * room + 0.15 * way + 0.15 * easy + 0.1 * heading + 0.15 * upright + 0.15 * steady
    return Placement(
        pose, score, f"turned {np.degrees(rest.turn):.0f} deg onto a face, {1e3 * gap:.0f} mm free"
    )


def _about(axis: FloatArray, angle: float) -> FloatArray:
    """Rotation about a unit axis (Rodrigues)."""
    skew = np.array([[0.0, -axis[2], axis[1]], [axis[2], 0.0, -axis[0]], [-axis[1], axis[0], 0.0]])
    return np.eye(3) + np.sin(angle) * skew + (1.0 - np.cos(angle)) * skew @ skew


def _spread_out(found: list[Placement], middle: FloatArray, limit: int) -> list[Placement]:
    """Best first, at most three headings at a place and places at least 6 cm apart."""
    kept: list[Placement] = []
    spots: list[FloatArray] = []
    for placement in sorted(found, key=lambda placement: -placement.score):
        pose = placement.pose_before_to_after
        spot = pose[:3, :3] @ middle + pose[:3, 3]
        near = [other for other in spots if np.linalg.norm(other - spot) < 0.06]
        same = sum(bool(np.linalg.norm(other - spot) < 0.005) for other in near)
        if len(near) == same and same < 3:
            kept.append(placement)
            spots.append(spot)
        if len(kept) >= limit:
            break
    return kept
