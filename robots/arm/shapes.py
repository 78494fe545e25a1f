"""Collision elements of a URDF as convex parts, meshes found and cut where they are concave."""

import os
import xml.etree.ElementTree as ElementTree
from collections.abc import Iterator, Sequence
from functools import lru_cache
from glob import escape
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np

from topple.robots.arm.elements import number, numbers
from topple.robots.arm.tolerances import CYLINDER_SIDES, LONGEST, LONGEST_MESH
from topple.robots.collision.pieces import convex_pieces
from topple.topology.base.arrays import FloatArray
from topple.topology.base.errors import InvalidInput, NotInstalled
from topple.topology.io.geometry import as_read

PACKAGE = "package://"
IN_SOURCES = ("*/", "*/*/")
"""How deep packages lie in a workspace's folder of sources, where not at its top."""


def geometry_parts(
    geometry: ElementTree.Element | None, path: Path, where: str, missing: list[str], gain: float | None
) -> Sequence[FloatArray]:
    """Read a collision element's geometry.

    Args:
        geometry: The `<geometry>` element.
        path: The URDF.
        where: What to call the element's link in messages.
        missing: Takes down meshes that are not there or cannot be read.
        gain: Share of its volume that a cut of a concave mesh into convex parts saves; None: it is not cut.

    Returns:
        Vertices (V, 3) of each convex part in the element's frame in [m]; none where a mesh is missing.

    Raises:
        InvalidInput: There is no geometry, its numbers are none, or its shape is unknown.
    """
    shape = next(iter(geometry), None) if geometry is not None else None
    if shape is None:
        raise InvalidInput(f"{where} has a collision element without geometry")
    if shape.tag == "box":
        half = numbers(shape.get("size"), 3, None, f"{where} box") / 2
        return [np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]) * half]
    if shape.tag in ("cylinder", "capsule"):
        radius, length = _radius(shape, where), number(shape.get("length"), None, where)
        return [prism(radius, length + (2 * radius if shape.tag == "capsule" else 0.0))]
    if shape.tag == "sphere":
        import trimesh

        radius = _radius(shape, where)
        # the icosphere lies inside the ball: scale it so that its faces do not
        return [np.asarray(trimesh.creation.icosphere(subdivisions=2, radius=radius * 1.02).vertices)]
    if shape.tag != "mesh":
        raise InvalidInput(
            f"{where} has a collision shape <{shape.tag}>; expected mesh, box, cylinder or sphere"
        )
    name = str(shape.get("filename"))
    scale = numbers(shape.get("scale"), 3, (1.0, 1.0, 1.0), f"{where} scale")
    if not scale.all():
        raise InvalidInput(f"{where} scale: expected numbers other than 0, found {shape.get('scale')!r}")
    file = find_mesh(name, path)
    if file is None:
        missing.append(name)
        return []
    if file.suffix.lower() == ".dae" and find_spec("collada") is None:
        raise NotInstalled(f"{file.name} of {where} is Collada, which needs pycollada", "collada")
    try:
        parts = [part * scale for part in _mesh_parts(file, file.stat().st_mtime_ns, gain)]
    except Exception as error:  # trimesh raises whatever its format readers raise
        missing.append(f"{name} ({error})")
        return []
    far = max(float(np.abs(part).max()) for part in parts)
    if LONGEST_MESH < far < LONGEST:
        raise InvalidInput(
            f"{where}: its mesh {name} reaches {far:.4g} m, more than {LONGEST_MESH:g} m: it looks like "
            'millimetres; expected metres, or scale="0.001 0.001 0.001"'
        )
    return parts


@lru_cache(maxsize=256)  # an arm's meshes are read more than once on the way to PyBullet
def _mesh_parts(file: Path, _changed: int, gain: float | None) -> tuple[FloatArray, ...]:
    """Vertices (V, 3) of the convex parts of a mesh file."""
    import trimesh

    source: Any = as_read(file, file.name)
    kind = file.suffix[1:].lower()
    mesh: Any = trimesh.load(source, kind, force="mesh", process=False, skip_materials=True)
    if mesh.units is not None:  # Collada states them; other formats do not
        mesh.apply_scale(trimesh.units.unit_conversion(mesh.units, "meters"))
    vertices = np.asarray(mesh.vertices, dtype=float).reshape(-1, 3)
    if not len(vertices) or not np.isfinite(vertices).all():
        raise ValueError("no finite vertices")
    if gain is None or not len(mesh.faces):
        return (vertices,)
    return tuple(convex_pieces(np.array(mesh.triangles), gain))


def find_mesh(name: str, path: Path) -> Path | None:
    """Find the file of a mesh.

    Args:
        name: As the URDF has it: a path, `file://` or `package://`.
        path: The URDF.

    Returns:
        The file, or None where there is none.
    """
    relative = name.removeprefix("file://")
    if name.startswith(PACKAGE):
        package, _, inside = name.removeprefix(PACKAGE).partition("/")
        candidates = (folder / inside for folder in _packages(package, path))
    else:
        candidates = iter([path.parent / relative])  # which leaves an absolute path as it is
    return next((candidate for candidate in candidates if candidate.is_file()), None)


def _packages(package: str, path: Path) -> Iterator[Path]:
    """Folders that may be a ROS package: above a URDF, in the workspace that it lies in, on ROS's paths."""
    yield from (folder for above in path.parents for folder in (above / package, above))
    sources = [above for above in path.parents if above.name == "src"]
    yield from (found for src in sources for deep in IN_SOURCES for found in src.glob(deep + escape(package)))
    yield from (Path(place) / package for place in os.environ.get("ROS_PACKAGE_PATH", "").split(os.pathsep))
    prefixes = os.environ.get("AMENT_PREFIX_PATH", "").split(os.pathsep)
    yield from (Path(prefix) / "share" / package for prefix in prefixes)


def missing_meshes(names: Sequence[str], path: Path) -> str:
    """Say which meshes of a URDF are not there or cannot be read, and where they were looked for."""
    said = f"{path.name}: missing or unreadable collision meshes: {'; '.join(names)}"
    packages = sorted(
        {name.removeprefix(PACKAGE).split("/")[0] for name in names if name.startswith(PACKAGE)}
    )
    if not packages:
        return said
    return (
        f"{said}; packages are looked for in the folders above {path}, below those called src, and in "
        f"ROS_PACKAGE_PATH and AMENT_PREFIX_PATH: set ROS_PACKAGE_PATH to the folder that holds "
        f"{' and '.join(packages)}"
    )


def prism(radius: float, length: float) -> FloatArray:
    """Corners (2n, 3) [m] of a prism around a cylinder whose axis is z, about its middle.

    Args:
        radius: Radius of the cylinder [m].
        length: Its length [m].
    """
    angles = np.arange(CYLINDER_SIDES) * (2 * np.pi / CYLINDER_SIDES)
    outer = radius / np.cos(np.pi / CYLINDER_SIDES)
    ring = np.stack([outer * np.cos(angles), outer * np.sin(angles)], axis=1)
    ends = [np.column_stack([ring, np.full(len(ring), z)]) for z in (-length / 2, length / 2)]
    return np.concatenate(ends)


def _radius(shape: ElementTree.Element, where: str) -> float:
    radius = number(shape.get("radius"), None, where)
    if radius <= 0.0:
        raise InvalidInput(f"{where}: expected a radius above 0, found {shape.get('radius')!r}")
    return radius
