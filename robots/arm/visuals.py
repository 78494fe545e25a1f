"""The visual meshes of an arm, as its URDF gives them: made coarse, each with its colour."""

import logging
from collections.abc import Iterator, Mapping
from functools import lru_cache
from pathlib import Path
from typing import Any, NamedTuple
from xml.etree.ElementTree import Element

import numpy as np

from topple.robots.arm.arm import Arm
from topple.robots.arm.elements import numbers, origin_of
from topple.robots.arm.shapes import find_mesh, geometry_parts
from topple.robots.arm.tolerances import BARE, DARKEST, FINEST, SCREWS
from topple.robots.arm.urdf import urdf_root
from topple.robots.collision.convex import hull_of
from topple.topology.base.arrays import FloatArray, IntArray
from topple.topology.geometry.rigid import move_points

log = logging.getLogger(__name__)


class Visual(NamedTuple):
    """A part of a link as it is drawn: corners (V, 3) in the link's frame [m], triangles (F, 3), colour."""

    vertices: FloatArray
    faces: IntArray
    colour: tuple[int, int, int]  # red, green, blue, 0..255


def visuals(arm: Arm, most: int) -> list[list[Visual]]:
    """The visuals of each link of an arm; its collision shapes where none can be read.

    Args:
        arm: The arm.
        most: Triangles of all links together, about.
    """
    return [_of_link(link, arm, most / max(len(arm.links), 1)) for link in arm.links]


def _of_link(link: str, arm: Arm, most: float) -> list[Visual]:
    try:
        found = _in_file(arm.model.path, link)
    except Exception as error:  # trimesh raises whatever its format readers raise
        log.info("%s is drawn by its collision shapes: %s", link, error)
        found = tuple(Visual(*hull_of(part), BARE) for part in arm.model.links[link].parts)
    areas = [_area(visual) for visual in found]
    shares = [(visual, area / sum(areas)) for visual, area in zip(found, areas, strict=True)]
    return [_coarse(visual, int(most * share)) for visual, share in shares if share > SCREWS]


@lru_cache(maxsize=64)
def _in_file(path: Path, link: str) -> tuple[Visual, ...]:
    """The visuals of a link as its files have them: pages and cameras make them coarse, each as it needs."""
    return tuple(part for element in _elements(path)[link] for part in _visuals_of(element, path))


@lru_cache(maxsize=4)
def _elements(path: Path) -> Mapping[str, list[tuple[Element, FloatArray | None]]]:
    """The elements that draw each link of a URDF, with the colours (3,), 0..1, that it gives them."""
    robot = urdf_root(path)
    named = {paint.get("name"): paint for paint in robot.iter("material") if paint.find("color") is not None}

    def colour(visual: Element) -> FloatArray | None:
        material = visual.find("material")
        given = None if material is None else named.get(material.get("name"), material).find("color")
        return None if given is None else numbers(given.get("rgba"), 4, None, "rgba")[:3]

    return {
        str(link.get("name")): [(visual, colour(visual)) for visual in link.findall("visual")]
        for link in robot.findall("link")
    }


def _visuals_of(visual: tuple[Element, FloatArray | None], path: Path) -> Iterator[Visual]:
    import trimesh

    element, given = visual
    pose, geometry = origin_of(element, "visual"), element.find("geometry")
    named = None if geometry is None else geometry.find("mesh")
    if named is None:
        parts = geometry_parts(geometry, path, "visual", [], None)
        meshes = [(np.eye(4), trimesh.Trimesh(*hull_of(part))) for part in parts]
        scale = np.ones(3)
    else:
        scene: Any = trimesh.load_scene(find_mesh(str(named.get("filename")), path), process=False)
        placed = map(scene.graph.get, scene.graph.nodes_geometry)
        meshes = [(there, scene.geometry[name]) for there, name in placed]
        scale = numbers(named.get("scale"), 3, (1.0, 1.0, 1.0), "scale")
        if scene.units is not None:  # Collada states them; other formats do not
            scale = scale * trimesh.units.unit_conversion(scene.units, "meters")
    for there, mesh in meshes:
        own: Any = getattr(getattr(mesh.visual, "material", None), "main_color", None)
        colour = BARE if given is None else 255 * given
        if own is not None and (
            given is None or given.min() == 1.0
        ):  # white is what a file's own are drawn on
            colour = own[:3]
        red, green, blue = np.maximum(colour, DARKEST).round().astype(int).tolist()
        vertices = move_points(move_points(np.asarray(mesh.vertices), there) * scale, pose)
        yield Visual(vertices, np.asarray(mesh.faces), (red, green, blue))


def _area(visual: Visual) -> float:
    a, b, c = np.moveaxis(visual.vertices[visual.faces], 1, 0)
    return float(np.linalg.norm(np.cross(b - a, c - a), axis=1).sum())


def _coarse(visual: Visual, most: int) -> Visual:
    """The mesh with all corners in a cell made one, their mean; cells widen until triangles are so few."""
    lower, wide = visual.vertices.min(axis=0), float(np.ptp(visual.vertices, axis=0).max())
    count = round(most**0.5) + FINEST
    while True:
        cells = ((visual.vertices - lower) / wide * count).astype(np.int64) @ [1, 1 << 20, 1 << 40]
        _, of_cell, held = np.unique(cells, return_inverse=True, return_counts=True)
        faces = of_cell[visual.faces]
        faces = faces[(faces != np.roll(faces, 1, axis=1)).all(axis=1)]
        kept = np.unique(np.sort(faces, axis=1), axis=0, return_index=True)[1]
        if len(kept) <= most or count == 2:
            break
        count -= 1
    sums = [np.bincount(of_cell, visual.vertices[:, axis]) for axis in range(3)]
    used, faces = np.unique(faces[kept], return_inverse=True)
    return Visual((np.stack(sums, axis=1) / held[:, None])[used], faces.reshape(-1, 3), visual.colour)
