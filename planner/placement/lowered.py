"""Putting a thing down as and where it is told: lowered there until it meets what is below."""

import numpy as np

from topple.planner.decide.goal import PlaceRelation
from topple.planner.placement.placement import Placement
from topple.planner.placement.resting import PLACEMENT_TOLERANCES
from topple.planner.placement.stacking import heights_of, underside
from topple.planner.placement.tolerances import CELL, CONTACT, OFF_BOARD, SKIN
from topple.topology.base.arrays import FloatArray, IntArray
from topple.topology.bodies.solids import centre_in, hull_vertices
from topple.topology.bodies.tops import tops_of
from topple.topology.geometry.axes import level_axes
from topple.topology.geometry.rigid import move_points
from topple.topology.geometry.samples import sample
from topple.topology.geometry.sides import inset
from topple.topology.geometry.thin import voxel_means
from topple.topology.scene.scene import Scene
from topple.topology.situation.situation import Situation
from topple.topology.statics.way_out import leads_up


def lower(name: str, situation: Situation, pose: FloatArray) -> Placement | None:
    """Lower an object, turned and over the place as it is told, onto what is there now.

    On what is fixed it comes to stand on its hidden sides, too.

    Args:
        name: The object.
        situation: Where everything is.
        pose: (4, 4) rigid transform in the world that brings it to where it shall lie; its height is found.

    Returns:
        The placement; None where there is nothing below.
    """
    found = _lower(name, situation, pose)
    if found is None or found.into is not None:
        return found
    return _lower(name, situation.with_completed(name), pose)


def _lower(name: str, situation: Situation, pose: FloatArray) -> Placement | None:
    scene, up, solids = situation.scene, situation.up, situation.solids
    axes = np.stack(level_axes(up))
    body = np.vstack([voxel_means(scene.clouds[name], CELL), sample(solids[name], CELL)])
    body = move_points(body, pose)
    slides = not leads_up(situation.way_out_from(body), up)
    ceiling = float((body @ up).max()) + (OFF_BOARD if slides else PLACEMENT_TOLERANCES.headroom)
    heights = heights_of(scene, up, leave_out=name, ceiling=ceiling)
    level, height = underside(body @ axes.T, body @ up)
    top, owner = _with_boards(*heights.look_up(level), level, scene, up)
    least = float((height - top).min())
    if not np.isfinite(least):
        return None
    carrying = np.bincount(owner[(height - top < least + CONTACT) & (owner >= 0)])
    below = scene.names[int(np.argmax(carrying))]
    drop = PLACEMENT_TOLERANCES.drop
    released = pose.copy()
    released[:3, 3] += (drop - least) * up
    if below in scene.fixed:
        return Placement(released, 1.0, "where it goes", drop)
    centre = pose[:3, :3] @ centre_in(scene, name, solids[name]) + pose[:3, 3]
    around = scene.clouds[below]
    sunk = float((around @ up).max() - (body @ up).min()) + least > CONTACT
    inside = sunk and inset(around @ axes.T, (axes @ centre)[None])[0] > 0.0
    how = PlaceRelation.WITHIN if inside else PlaceRelation.ON
    return Placement(released, 1.0, f"where it goes, {how} {below}", drop, below, how)


def _with_boards(
    top: FloatArray, owner: IntArray, places: FloatArray, scene: Scene, up: FloatArray
) -> tuple[FloatArray, IntArray]:
    """Heights and owners at (N, 2) level places: a table is flat, and goes on under what stood there."""
    axes, names = np.stack(level_axes(up)), list(scene.names)
    top, owner = top.copy(), owner.copy()
    for name in sorted(scene.fixed):
        found = tops_of(scene.clouds[name], up)
        for board in found.tops:
            noise = np.abs(top - board.height) < SKIN
            hidden = ~np.isfinite(top) | ((owner == names.index(name)) & noise)
            hidden[hidden] = inset(hull_vertices(board.points @ axes.T), places[hidden]) > 0.0
            top[hidden], owner[hidden] = board.height, names.index(name)
    return top, owner
