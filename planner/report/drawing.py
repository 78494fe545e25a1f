"""What is drawn of a scene: surfaces as lit points, hull outlines, relation lines, and where to look from."""

import base64
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any, Protocol, runtime_checkable

import numpy as np
from trimesh import Trimesh

from topple.planner.decide.names import Colour, paints_of, photo_of
from topple.planner.decide.words import because, places, said
from topple.planner.report.limits import LIMITS
from topple.planner.report.palette import FIXED_COLOUR, css, ink_on, object_colours, relation_colour
from topple.robots.collision.convex import hull_of, reduce_hull
from topple.topology.base.arrays import FloatArray, IntArray
from topple.topology.bodies.surfaces import whole_surfaces
from topple.topology.geometry.thin import voxel_means
from topple.topology.kernels.neighbours import PointTree
from topple.topology.kernels.planes import patch_planes
from topple.topology.scene.cloud import clean
from topple.topology.scene.scene import Scene
from topple.topology.sixim.table import ONE_SIDED_CONTACT, Relation
from topple.topology.views.image import Photo

Document = Mapping[str, Any]


@runtime_checkable
class Documented(Protocol):
    """A result that gives its JSON document: Relations, Order."""

    def to_json(self) -> dict[str, Any]: ...  # noqa: D102


def document(result: Documented | Document) -> Document:
    """The JSON document of a result, which may be one already."""
    return result if isinstance(result, Mapping) else result.to_json()


@dataclass(frozen=True, eq=False)
class DrawnObject:
    """One object as it is drawn."""

    name: str
    colour: Colour  # that tells it from the others, in every picture of the scene
    paint: Colour  # its own where a photo shows it: the mean of its mask, else `colour`
    fixed: bool
    points: FloatArray  # (N, 3) of its surface [m], thinned: first what was seen, then what is guessed
    normals: FloatArray  # (N, 3) unit normals of the surface there, of either sign
    seen: int  # how many of the points were seen
    spacing: float  # typical distance of a point to its nearest neighbour [m]; the size of a drawn dot
    centre: FloatArray  # (3,) centroid of the whole cloud [m]
    top: FloatArray  # (3,) above the centroid at the height of the highest corner [m]; where the name stands
    corners: FloatArray  # (V, 3) of the drawn hull [m]
    edges: IntArray  # (E, 2) indices into `corners`


@dataclass(frozen=True, eq=False)
class Drawing:
    """A scene as it is drawn."""

    objects: tuple[DrawnObject, ...]  # in the scene's order
    centre: FloatArray  # (3,) point the view turns about [m]
    radius: float  # about it, that holds everything movable [m]
    up: FloatArray  # (3,) direction drawn upwards
    eye: FloatArray  # (3,) point to look from at first [m]

    @staticmethod
    def of(scene: Scene, points: int = LIMITS.page_points, taken: Photo | None = None) -> "Drawing":
        """Thin a scene's clouds to some points in all, add what is guessed, and outline their hulls.

        Args:
            scene: The scene.
            points: How many are kept in all.
            taken: A photo that was taken of it for people; else its first colour image gives the paints.
        """
        colours, shares, up = object_colours(scene.names, scene.fixed), _shares(scene, points), _up(scene)
        paints = colours | paints_of(taken or photo_of(scene))
        whole = whole_surfaces(scene) if scene.up is not None and len(scene.viewpoints) else {}
        objects = tuple(
            _draw(
                name,
                cloud,
                whole.get(name),
                (colours[name], paints[name], name in scene.fixed),
                shares[name],
                up,
            )
            for name, cloud in scene.clouds.items()
        )
        if len(scene.matter):
            grey = (FIXED_COLOUR, FIXED_COLOUR, True)
            objects += (_draw("unnamed matter", scene.matter, None, grey, LIMITS.least_points * 10, up),)
        # of what is movable, since a table may be metres wide; of everything where nothing is
        chosen = [drawn for drawn in objects if not drawn.fixed] or list(objects)
        corners = np.concatenate([drawn.corners for drawn in chosen])
        lower, upper = corners.min(axis=0), corners.max(axis=0)
        centre = (lower + upper) / 2
        radius = max(float(np.linalg.norm(upper - lower)) / 2, 1e-3)
        return Drawing(objects, centre, radius, up, _standpoint(scene, centre, radius, up))

    def beside(self, name: str, points: FloatArray) -> "Drawing":
        """The same with something fixed in it that is in no cloud, by points (N, 3) of it."""
        drawn = _draw(name, points, None, (FIXED_COLOUR, FIXED_COLOUR, True), len(points), self.up)
        return replace(self, objects=(*self.objects, drawn))

    @property
    def index(self) -> dict[str, int]:
        """Name -> number of every drawn object."""
        return {drawn.name: number for number, drawn in enumerate(self.objects)}

    @property
    def colours(self) -> dict[str, Colour]:
        """Name -> colour of every drawn object."""
        return {drawn.name: drawn.colour for drawn in self.objects}


def view_data(
    drawing: Drawing,
    relations: Document,
    order: Document | None,
    tool_path: FloatArray | None = None,
    motion: Document | None = None,
) -> dict[str, Any]:
    """Collect a drawing's data for the viewer script, ready for JSON.

    The path has shape (k, 3) [m]; the motion is what `played.motion_json` gave.
    """
    index, place = drawing.index, {} if order is None else places(order)
    lines = [_line(pair, index) for pair in relations.get("relations", ())]
    path = np.asarray([] if tool_path is None else tool_path, dtype=np.float64).reshape(-1, 3)
    kept = np.unique(np.linspace(0, len(path) - 1, min(len(path), LIMITS.path_points)).astype(np.int64))
    return {
        "centre": _round(drawing.centre),
        "radius": round(drawing.radius, 5),
        "up": _round(drawing.up),
        "eye": _round(drawing.eye),
        "objects": [_object_json(drawn) for drawn in drawing.objects],
        "relations": [line for line in lines if line is not None],
        "converse": {str(relation): str(relation.converse) for relation in Relation},
        "places": None if order is None else [place.get(name, 0) for name in index],
        "dependencies": [
            {"first": index[first], "then": index[then], "text": because([first], said(tie))}
            for tie in (order or {}).get("dependencies", ())
            if (first := str(tie["first"])) in index and (then := str(tie["then"])) in index
        ],
        "path": [_round(point) for point in path[kept]] or None,
        "motion": motion,
    }


def is_inferred(pair: Mapping[str, Any]) -> bool:
    """The relation was concluded, not seen."""
    return bool(pair.get("inferred", False)) or not pair.get("observed", True)


def _line(pair: Mapping[str, Any], index: Mapping[str, int]) -> dict[str, Any] | None:
    """A relation as a line; disjoint pairs have none, except contact that one side alone shows."""
    a, b, relation, kind = str(pair["a"]), str(pair["b"]), str(pair["relation"]), pair.get("kind")
    faint = relation == Relation.DISJOINT
    if a not in index or b not in index or (faint and kind != ONE_SIDED_CONTACT):
        return None
    return {
        "a": index[a],
        "b": index[b],
        "relation": relation,
        "kind": None if kind is None else str(kind),
        "colour": css(relation_colour(relation)),
        "dashed": faint or is_inferred(pair),
        "faint": faint,
    }


def _shares(scene: Scene, points: int) -> Mapping[str, int]:
    """Points each object may keep: equal shares of the budget; what small clouds leave goes to others."""
    shares: dict[str, int] = {}
    for names, part in ((scene.fixed, LIMITS.fixed_share), (scene.movable, 1 - LIMITS.fixed_share)):
        left = int(points * part)
        for position, name in enumerate(sorted(names, key=lambda name: (len(scene.clouds[name]), name))):
            share = max(left // (len(names) - position), LIMITS.least_points)
            shares[name] = min(share, len(scene.clouds[name]))
            left -= shares[name]
    return shares


def _draw(
    name: str,
    cloud: FloatArray,
    whole: FloatArray | None,
    paint: tuple[Colour, Colour, bool],
    share: int,
    up: FloatArray,
) -> DrawnObject:
    points = seen = clean(_thin(cloud, share))
    if whole is not None and len(whole):
        hidden = whole[PointTree(cloud).query(whole)[0] > LIMITS.guessed]
        points = np.concatenate([seen, _thin(hidden, share // 2)]) if len(hidden) else seen
    mesh: Any = Trimesh(*outline(cloud), process=False)
    corners = mesh.vertices.view(np.ndarray)
    edges = mesh.face_adjacency_edges[mesh.face_adjacency_angles > np.radians(LIMITS.crease)]
    centre = cloud.mean(axis=0)
    top = centre + up * float(((corners - centre) @ up).max())
    spacing, normals = _spacing_and_normals(points)
    return DrawnObject(name, *paint, points, normals, len(seen), spacing, centre, top, corners, edges)


def _thin(cloud: FloatArray, share: int) -> FloatArray:
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
    spacing = float(np.clip(np.median(distance[:, min(3, near - 1)]), 5e-4, LIMITS.widest))
    return spacing, patch_planes(points[np.asarray(neighbours)])[1]


def outline(points: FloatArray) -> tuple[FloatArray, IntArray]:
    """The hull of points, few enough corners to look at: (V, 3) [m] and triangles (F, 3)."""
    return hull_of(reduce_hull(hull_of(points)[0], LIMITS.finest)[0])


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
        "paint": css(drawn.paint),
        "fixed": drawn.fixed,
        "lower": [float(value) for value in lower],
        "step": step,
        "points": base64.b64encode(packed.tobytes()).decode("ascii"),
        "normals": base64.b64encode(np.round(drawn.normals * 127).astype(np.int8).tobytes()).decode("ascii"),
        "seen": drawn.seen,
        "spacing": round(drawn.spacing, 5),
        "centre": _round(drawn.centre),
        "top": _round(drawn.top),
        "corners": [_round(corner) for corner in drawn.corners],
        "edges": drawn.edges.tolist(),
    }


def _round(point: FloatArray) -> list[float]:
    """Coordinates to a hundredth of a millimetre."""
    return [round(float(value), 5) for value in point]
