"""Hand directions where a thing hangs over an edge: a level hand, one finger above it and one below."""

import numpy as np

from topple.planner.grasp.frames import Frames
from topple.planner.grasp.tolerances import HANGING, HANGING_ASIDE, HANGING_BESIDE, HANGING_DIRECTIONS
from topple.topology.bodies.edges import edge_ahead, top_under
from topple.topology.bodies.solids import hull_vertices
from topple.topology.geometry.axes import cross, level_axes
from topple.topology.geometry.samples import centre_of_mass
from topple.topology.geometry.sides import beyond, sides_of, way_out
from topple.topology.situation import Situation


def overhang_frames(name: str, situation: Situation) -> list[Frames]:
    """Lay out hand directions that come in level from beyond an edge, at what hangs over it.

    There is no ground below such a hand: it is beyond the table altogether.

    Args:
        name: The object.
        situation: Where everything is.

    Returns:
        The directions, place by place along what hangs over; none where the thing hangs over no edge that was
        seen to be one. Deterministic.
    """
    scene, up = situation.scene, situation.up
    found = top_under(name, scene)
    if found is None:
        return []
    owner, top = found
    axes = np.stack(level_axes(up))
    body = hull_vertices(np.vstack([scene.clouds[name], *situation.completed[name]]))
    ground = sides_of(top.points @ axes.T)
    if ground is None or float(beyond(ground, body @ axes.T).max()) < HANGING:
        return []
    centre = centre_of_mass(scene.clouds[name], situation.completed[name])
    middle = float((body @ up).max() + (body @ up).min()) / 2.0
    frames: list[Frames] = []
    for angle in np.arange(HANGING_DIRECTIONS) * (2.0 * np.pi / HANGING_DIRECTIONS):
        out = np.array([np.cos(angle), np.sin(angle)]) @ axes
        across = cross(up, out)
        left, right = float(((body - centre) @ across).max()), float(((body - centre) @ across).min())
        beside = (right - HANGING_BESIDE, right), (left, left + HANGING_BESIDE)  # below it the edge is hidden
        edge = edge_ahead(owner, top, scene, centre, out, beside)
        if edge is None:
            continue
        for offset in HANGING_ASIDE:
            start = centre + offset * across
            way = way_out(np.column_stack([(body - start) @ out, (body - start) @ across]))
            if way is None or float(edge.beyond(start + way * out)) < HANGING:
                continue
            place = start + way * out + (middle - float(start @ up)) * up
            turned = np.column_stack([cross(up, -out), up, -out])
            frames.append(Frames(place, turned[None], np.array([np.pi / 2.0])))
    return frames
