"""From what a file says to a Scene: fixed objects, the table, and which way is up."""

from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from topple.topology.base.arrays import FloatArray, bounds, middle_of, within_corners
from topple.topology.base.checks import as_plane, as_points, as_viewpoints
from topple.topology.base.errors import InvalidInput
from topple.topology.geometry.axes import perpendiculars
from topple.topology.geometry.plane import TABLE as _TABLE
from topple.topology.geometry.tolerances import ON_PLANE
from topple.topology.io.tolerances import (
    FAR_SPACING,
    MOST_TABLE_POINTS,
    NARROWEST_TABLE,
    ON_PLANE_SHARE,
    TABLE_MARGIN,
    TABLE_REACH,
    TABLE_SPACING,
)
from topple.topology.scene.background import hanging_together, table_among
from topple.topology.scene.mesh import Mesh
from topple.topology.scene.scene import Scene
from topple.topology.scene.tolerances import OVER
from topple.topology.views.image import DepthImage, said_of_images


@dataclass
class Parts:
    """What a file says, not yet checked as a whole.

    Attributes:
        clouds: Points (N, 3) in [m] per object.
        fixed: Names the file calls fixed.
        up: Direction (3,) or None.
        viewpoints: Camera centres (k, 3) or None.
        table_plane: (n, d), n.x + d is the height above the table in [m], or None.
        robot_base: Pose (4, 4) base to world, or None.
        images: Depth images the clouds came from.
        background: Points (N, 3) in [m] that belong to no object, the table's perhaps among them.
        matter: Points (N, 3) in [m] of walls and the like, or None (`Scene.matter`).
        meshes: Meshes in world coordinates.
        notes: Sentences on what was assumed.
        masses: Mass in [kg] by name, or None; checked as a whole with the scene.
        friction: Coefficient of friction by name, or None.
        centres: Centre of mass (3,) in [m] by name, or None.

    Examples:
        >>> Parts({"cup": np.zeros((1, 3))}, fixed=["table"]).fixed
        ['table']
    """

    clouds: dict[str, ArrayLike]
    fixed: list[str] = field(default_factory=list[str])
    up: ArrayLike | None = None
    viewpoints: ArrayLike | None = None
    table_plane: ArrayLike | None = None
    robot_base: ArrayLike | None = None
    images: tuple[DepthImage, ...] = ()
    background: FloatArray = field(default_factory=lambda: np.empty((0, 3)))
    matter: ArrayLike | None = None
    meshes: dict[str, Mesh] = field(default_factory=dict[str, Mesh])
    notes: list[str] = field(default_factory=list[str])
    masses: Any = None
    friction: Any = None
    centres: Any = None


def assemble(
    parts: Parts,
    fixed: list[str],
    up: ArrayLike | None,
    robot: Iterable[FloatArray] | Callable[[Scene], Iterable[FloatArray]] = (),
) -> Scene:
    """Make the scene, filling in what the file leaves open.

    Args:
        parts: What the file says.
        fixed: Names that never move, beside those in the file.
        up: Direction (3,) that goes before the file's, or None.
        robot: Corners (V, 3) [m] of bodies whose points are nobody's, or what gives them for the scene.

    Returns:
        The scene; what was filled in stands in its assumptions.

    Raises:
        InvalidInput: If a part is not what it should be; names the object.
        UnknownObject: If a fixed name is not there.
    """
    if not parts.clouds:
        raise InvalidInput("no objects found: expected at least one named cloud (N, 3) in metres")
    clouds = {name: _as_cloud(name, points) for name, points in parts.clouds.items()}
    notes = [*parts.notes, *said_of_images(parts.images)]
    all_fixed = list(dict.fromkeys([*parts.fixed, *fixed]))
    up = parts.up if up is None else up
    if parts.table_plane is not None:
        plane = as_plane(parts.table_plane)
        all_fixed = _place_table(clouds, all_fixed, plane, parts.background, notes)
        if up is None:
            up = plane[:3]
            notes.append("up is the normal of table_plane")
    elif not all_fixed:
        viewpoints = as_viewpoints([] if parts.viewpoints is None else parts.viewpoints)
        all_fixed = table_among(clouds, parts.background, viewpoints, notes)
    scene = Scene(
        clouds, all_fixed, up, parts.viewpoints, parts.images, parts.meshes, parts.robot_base, notes,
        matter=parts.matter,
    )  # fmt: skip
    scene = scene.weighed(parts.masses, parts.friction, parts.centres).upright()
    return scene.examined(parts.background, robot if isinstance(robot, Iterable) else robot(scene))


def _as_cloud(name: str, points: ArrayLike) -> FloatArray:
    cloud = as_points(points, f"cloud {name!r}")
    if len(cloud) == 1:
        raise InvalidInput(
            f"cloud {name!r} has a single point: expected points (N, 3) all over its surface; leave it out "
            "only if nothing is there"
        )
    return cloud


def _place_table(
    clouds: dict[str, FloatArray],
    fixed: list[str],
    plane: FloatArray,
    background: FloatArray,
    notes: list[str],
) -> list[str]:
    """Find the table in `plane`, of a label or none, or lay a flat cloud there; returns what is fixed."""
    if _TABLE in clouds:
        if _TABLE not in fixed:
            notes.append(f"{_TABLE!r} is taken as fixed because of its name")
        return list(dict.fromkeys([*fixed, _TABLE]))
    seen = next((name for name in clouds if _is_table(name, clouds, plane)), None)
    if seen is not None and _TABLE not in fixed:
        if seen in fixed:
            return fixed
        notes.append(f"{seen!r} is taken as the fixed table: it lies in table_plane, under the other objects")
        return [*fixed, seen]
    measured = hanging_together(background, plane, clouds)
    if len(measured) and _is_table(_TABLE, {**clouds, _TABLE: measured}, plane):
        clouds[_TABLE] = measured
        notes.append(
            f"{_TABLE!r} is what lies in table_plane and has no label ({len(measured)} points): "
            "it is taken as fixed"
        )
        return list(dict.fromkeys([*fixed, _TABLE]))
    clouds[_TABLE] = _flat_cloud(np.concatenate(list(clouds.values())), plane)
    notes.append(
        f"{_TABLE!r} is a flat cloud laid into table_plane under all objects and {TABLE_REACH:g} m beyond, "
        "since a plane has no edge: not a measured one"
    )
    return list(dict.fromkeys([*fixed, _TABLE]))


def _is_table(name: str, clouds: dict[str, FloatArray], plane: FloatArray) -> bool:
    """Tell whether an object lies in the plane, and is wide enough to be under all the others."""
    points = clouds[name]
    if float((np.abs(points @ plane[:3] + plane[3]) <= ON_PLANE).mean()) < ON_PLANE_SHARE:
        return False
    middles = [middle_of(cloud) for other, cloud in clouds.items() if other != name]
    if not middles:
        return False
    along = np.stack(perpendiculars(plane[:3]), axis=1)  # (3, 2)
    lower, upper = bounds(points @ along)
    if float((upper - lower).min()) < NARROWEST_TABLE:
        return False
    flat = np.array(middles) @ along
    return float(within_corners(flat, lower, upper).mean()) >= OVER


def _flat_cloud(points: FloatArray, plane: FloatArray) -> FloatArray:
    """Lay points (N, 3) into the plane: fine below all points, coarse as far beyond as an arm reaches."""
    normal, offset = plane[:3], plane[3]
    second, first = perpendiculars(normal)
    axes = np.stack([-first, second])
    flat = points @ axes.T
    lower, upper = bounds(flat)
    lower, upper = lower - TABLE_MARGIN, upper + TABLE_MARGIN
    fine = _grid(lower, upper, TABLE_SPACING)
    beyond = TABLE_REACH - TABLE_MARGIN
    coarse = _grid(lower - beyond, upper + beyond, FAR_SPACING)
    coarse = coarse[~((coarse > lower) & (coarse < upper)).all(axis=1)]
    return np.concatenate([fine, coarse]) @ axes - offset * normal


def _grid(lower: FloatArray, upper: FloatArray, spacing: float) -> FloatArray:
    """Points (N, 2) over a rectangle, its corners among them.

    They are at most a spacing apart [m], or as near as so many may be: objects may be far from each other.
    """
    extent = upper - lower
    spacing = max(spacing, float(np.sqrt(np.prod(extent) / MOST_TABLE_POINTS)))
    spacing = max(spacing, float(extent.max()) / MOST_TABLE_POINTS)
    steps = np.ceil((upper - lower) / spacing).astype(np.int64) + 1
    along, across = np.meshgrid(*(np.linspace(lower[k], upper[k], steps[k]) for k in (0, 1)))
    return np.stack([along.ravel(), across.ravel()], axis=1)
