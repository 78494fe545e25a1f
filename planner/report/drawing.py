"""What is drawn of a scene: surfaces as lit points, hull outlines, centres, and where to look from."""

import base64
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from topple.planner.report.limits import LIMITS
from topple.planner.report.palette import Colour, css, ink_on, object_colours
from topple.topology.arrays import FloatArray, IntArray
from topple.topology.bodies.surfaces import whole_surfaces
from topple.topology.cloud import clean
from topple.topology.geometry.hull import Hull
from topple.topology.geometry.thin import voxel_means
from topple.topology.kernels.neighbours import PointTree
from topple.topology.kernels.planes import patch_planes
from topple.topology.scene import Scene


@dataclass(frozen=True, eq=False)
class DrawnObject:
    """One object as it is drawn.

    Attributes:
        name: The object's name.
        colour: Its colour.
        fixed: It never moves.
        points: (N, 3) points of its surface [m], thinned: those that were seen, then those that are guessed.
        normals: (N, 3) unit normals of the surface there, of either sign.
        seen: How many of the points were seen.
        spacing: Typical distance of a point to its nearest neighbour [m]; the size of a drawn dot.
        centre: (3,) centroid of the whole cloud [m].
        top: (3,) point above the centroid at the height of the highest corner [m]; where the name stands.
        corners: (V, 3) corners of the drawn hull [m].
        edges: (E, 2) indices into `corners`.
    """

    name: str
    colour: Colour
    fixed: bool
    points: FloatArray
    normals: FloatArray
    seen: int
    spacing: float
    centre: FloatArray
    top: FloatArray
    corners: FloatArray
    edges: IntArray


@dataclass(frozen=True, eq=False)
class Drawing:
    """A scene as it is drawn.

    Attributes:
        objects: The objects, in the scene's order.
        centre: (3,) point the view turns about [m].
        radius: Radius about it that holds everything movable [m].
        up: (3,) direction drawn upwards.
        eye: (3,) point to look from at first [m].
    """

    objects: tuple[DrawnObject, ...]
    centre: FloatArray
    radius: float
    up: FloatArray
    eye: FloatArray

    @staticmethod
    def of(scene: Scene, points: int = LIMITS.page_points) -> "Drawing":
        """Thin a scene's clouds, add what is guessed of their surfaces, and outline their hulls.

        Args:
            scene: The scene.
            points: Points that may be drawn in all.

        Returns:
            The drawing; the same scene gives the same drawing.
        """
        colours = object_colours(scene.names, scene.fixed)
        shares = _shares(scene, points)
        up = _up(scene)
        whole = whole_surfaces(scene) if scene.up is not None and len(scene.viewpoints) else {}
        objects = tuple(
            _drawn(name, cloud, whole.get(name), colours[name], name in scene.fixed, shares[name], up)
            for name, cloud in scene.clouds.items()
        )
        lower, upper = _box(objects)
        centre = (lower + upper) / 2
        radius = max(float(np.linalg.norm(upper - lower)) / 2, 1e-3)
        return Drawing(objects, centre, radius, up, _standpoint(scene, centre, radius, up))

    def beside(self, name: str, points: FloatArray) -> "Drawing":
        """The same with something fixed in it that is in no cloud, by points (N, 3) of it."""
        drawn = _drawn(name, points, None, object_colours([name], [name])[name], True, len(points), self.up)
        return replace(self, objects=(*self.objects, drawn))

    def to_json(self) -> dict[str, Any]:
        """The drawing as the viewer reads it: points as 16-bit steps of the object's box, in base64."""
        return {
            "centre": _rounded(self.centre),
            "radius": round(self.radius, 5),
            "up": _rounded(self.up),
            "eye": _rounded(self.eye),
            "objects": [_object_json(drawn) for drawn in self.objects],
        }


def thin_path(path: FloatArray) -> list[list[float]]:
    """At most `LIMITS.path_points` of a (k, 3) path [m], ends kept, as plain numbers."""
    path = np.asarray(path, dtype=np.float64).reshape(-1, 3)
    kept = np.unique(np.linspace(0, len(path) - 1, min(len(path), LIMITS.path_points)).astype(np.int64))
    return [_rounded(point) for point in path[kept]]


def _shares(scene: Scene, points: int) -> Mapping[str, int]:
    """Points each object may keep: equal shares of the budget; what small clouds leave goes to others."""
    shares: dict[str, int] = {}
    for names, budget in (
        ([name for name in scene.names if name in scene.fixed], int(points * LIMITS.fixed_share)),
        (list(scene.movable), int(points * (1 - LIMITS.fixed_share))),
    ):
        left = budget
        for position, name in enumerate(sorted(names, key=lambda name: len(scene.clouds[name]))):
            share = max(left // (len(names) - position), LIMITS.least_points)
            shares[name] = min(share, len(scene.clouds[name]))
            left -= shares[name]
    return shares


def _drawn(
    name: str,
    cloud: FloatArray,
    whole: FloatArray | None,
    colour: Colour,
    fixed: bool,
    share: int,
    up: FloatArray,
) -> DrawnObject:
    seen = clean(_thinned(cloud, share))
    points = seen
    if whole is not None and len(whole):
        hidden = whole[PointTree(cloud).query(whole)[0] > LIMITS.guessed]
        points = np.concatenate([seen, _thinned(hidden, share)]) if len(hidden) else seen
    corners, edges = hull_outline(cloud)
    centre = cloud.mean(axis=0)
    top = centre + up * float(((corners - centre) @ up).max())
    spacing, normals = _spacing_and_normals(points)
    return DrawnObject(name, colour, fixed, points, normals, len(seen), spacing, centre, top, corners, edges)


def _thinned(cloud: FloatArray, share: int) -> FloatArray:
    """Means of a cloud's points in cells, as fine as its share of the points allows."""
    cell = LIMITS.finest
    while len(kept := voxel_means(cloud, cell)) > share:
        cell *= max(1.1, float(np.sqrt(len(kept) / share)))
    return kept


def _spacing_and_normals(points: FloatArray) -> tuple[float, FloatArray]:
    """Typical distance between neighbours [m], and (N, 3) unit normals of the patches around the points."""
    near = min(LIMITS.normal, len(points))
    if near < 3:
        return 0.003, np.tile([0.0, 0.0, 1.0], (len(points), 1))
    distance, neighbours = PointTree(points).query(points, k=near)
    spacing = float(np.clip(np.median(distance[:, min(3, near - 1)]), 5e-4, 0.02))
    return spacing, patch_planes(points[np.asarray(neighbours)])[1]


def hull_outline(cloud: FloatArray) -> tuple[FloatArray, IntArray]:
    """Corners and creases of a cloud's hull, few enough to look at.

    Args:
        cloud: (N, 3) points [m].

    Returns:
        (V, 3) corners [m] and (E, 2) edges between them; no edge for a single point.
    """
    hull = Hull.of(cloud)
    if len(hull.vertices) > LIMITS.hull_vertices:
        hull = Hull.of(_farthest(hull.vertices, LIMITS.hull_vertices))
    if hull.dimension == 1:
        return hull.vertices, np.array([[0, 1]], dtype=np.int64)
    return hull.vertices, _creases(hull)


def _farthest(points: FloatArray, count: int) -> FloatArray:
    """Choose points one by one, each the farthest from those chosen before."""
    chosen = [int(np.linalg.norm(points - points.mean(axis=0), axis=1).argmax())]
    distance = np.linalg.norm(points - points[chosen[0]], axis=1)
    while len(chosen) < count:
        chosen.append(int(distance.argmax()))
        distance = np.minimum(distance, np.linalg.norm(points - points[chosen[-1]], axis=1))
    return points[np.array(chosen)]


def _creases(hull: Hull) -> IntArray:
    """Edges between facets that differ in direction, and edges with one facet only."""
    corners = hull.vertices[hull.faces]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    length = np.linalg.norm(normals, axis=1, keepdims=True)
    normals = normals / np.where(length > 0, length, 1.0)
    beside: dict[tuple[int, int], list[int]] = {}
    for index, face in enumerate(hull.faces.tolist()):
        for a, b in zip(face, (*face[1:], face[0]), strict=True):
            beside.setdefault((min(a, b), max(a, b)), []).append(index)
    straight = np.cos(np.radians(LIMITS.crease))
    creases = [
        edge
        for edge, faces in beside.items()
        if len(faces) != 2 or float(normals[faces[0]] @ normals[faces[1]]) < straight
    ]
    return np.array(sorted(creases), dtype=np.int64).reshape(-1, 2)


def _box(objects: tuple[DrawnObject, ...]) -> tuple[FloatArray, FloatArray]:
    """Box of what is movable, since a table may be metres wide; of everything where nothing is movable."""
    chosen = [drawn for drawn in objects if not drawn.fixed] or list(objects)
    corners = np.concatenate([drawn.corners for drawn in chosen])
    return corners.min(axis=0), corners.max(axis=0)


def _up(scene: Scene) -> FloatArray:
    """Which way is drawn up: the scene's own, else that of the camera whose frame the clouds are in."""
    if scene.up is not None:
        return np.array(scene.up, dtype=np.float64)
    in_camera_frame = len(scene.viewpoints) > 0 and float(np.linalg.norm(scene.viewpoints[0])) < 1e-6
    return np.array([0.0, -1.0, 0.0]) if in_camera_frame else np.array([0.0, 0.0, 1.0])


def _standpoint(scene: Scene, centre: FloatArray, radius: float, up: FloatArray) -> FloatArray:
    """A point to look from: the first camera's side where one is known, from above."""
    known = len(scene.viewpoints) > 0
    side = scene.viewpoints[0] - centre if known else np.array([-1.0, -2.0, -0.5])
    level = side - up * float(side @ up)
    if float(np.linalg.norm(level)) < 1e-6:  # straight above: any side will do
        level = np.eye(3)[int(np.abs(up).argmin())]
        level = level - up * float(level @ up)
    level = level / np.linalg.norm(level)
    raised = np.radians(32.0)
    return centre + (level * np.cos(raised) + up * np.sin(raised)) * radius * 3.2


def _object_json(drawn: DrawnObject) -> dict[str, Any]:
    lower = drawn.points.min(axis=0)
    step = max(float(np.ptp(drawn.points, axis=0).max()) / 65535, 1e-9)
    packed = np.round((drawn.points - lower) / step).astype("<u2")
    return {
        "name": drawn.name,
        "colour": css(drawn.colour),
        "ink": css(ink_on(drawn.colour)),
        "fixed": drawn.fixed,
        "lower": [float(value) for value in lower],
        "step": step,
        "points": base64.b64encode(packed.tobytes()).decode("ascii"),
        "normals": base64.b64encode(np.round(drawn.normals * 127).astype(np.int8).tobytes()).decode("ascii"),
        "seen": drawn.seen,
        "spacing": round(drawn.spacing, 5),
        "centre": _rounded(drawn.centre),
        "top": _rounded(drawn.top),
        "corners": [_rounded(corner) for corner in drawn.corners],
        "edges": drawn.edges.tolist(),
    }


def _rounded(point: FloatArray) -> list[float]:
    """Coordinates to a hundredth of a millimetre."""
    return [round(float(value), 5) for value in point]
