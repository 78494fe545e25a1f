"""Bodies as they stand and fall: what was seen of them, with the sides that no camera saw guessed.

What is kept clear of is what was seen. How a thing stands is another question: what one camera saw of it is a
shell, and the open side of that looks like the best face of all. Placements, their simulated release and the
check of a plan all ask the same body.
"""

from collections.abc import Collection, Mapping, Sequence

import numpy as np
from scipy.spatial import ConvexHull, QhullError

from topple.topology.base.arrays import FloatArray
from topple.topology.bodies.solids import Solids, hull_vertices
from topple.topology.bodies.tolerances import BENT, COMPLETED_LEVEL, RAGGED, SPACING
from topple.topology.geometry.axes import level_axes
from topple.topology.geometry.samples import sample


def completed_bodies(
    clouds: Mapping[str, FloatArray], solids: Solids, surfaces: Mapping[str, FloatArray]
) -> dict[str, Sequence[FloatArray]]:
    """Complete bodies.

    Args:
        clouds: (N, 3) points [m] that were seen of each object.
        solids: Convex parts of the objects, as far as they are known.
        surfaces: (M, 3) points [m] of the whole surface, guessed sides included, of those that can move.

    Returns:
        For each object with a surface one convex part around what is known and what is guessed; what is
        known alone of the others.
    """
    return {
        name: (hull_vertices(np.vstack([clouds[name], surfaces[name], *parts])),)
        if name in surfaces
        else parts
        for name, parts in solids.items()
    }


def with_level_undersides(
    bodies: Solids, names: Collection[str], up: FloatArray
) -> dict[str, Sequence[FloatArray]]:
    """Level the undersides of bodies that stand on them, for what is seen of a foot is its ragged edge.

    A carton that stands in the scene falls over in simulation where noise of a few millimetres made a rocker
    of its foot. What has most of its underside at one height stands on that; round and leaning things stay
    as they are.

    Args:
        bodies: Convex parts of objects that are at rest as they are [m].
        names: Those that can move.
        up: (3,) unit vector.

    Returns:
        The bodies, those with a foot drawn down to its lowest point as one convex part each.
    """
    return {name: _level_underside(parts, up) if name in names else parts for name, parts in bodies.items()}


def _level_underside(parts: Sequence[FloatArray], up: FloatArray) -> Sequence[FloatArray]:
    corners = np.vstack(parts)
    points = np.vstack([corners, sample(parts, SPACING)])
    height, axes = points @ up, np.stack(level_axes(up))
    bottom = float(height.min())
    low = points[height < bottom + min(RAGGED, BENT * float(np.ptp(height)))]
    try:
        foot, outline = ConvexHull(low @ axes.T), ConvexHull(corners @ axes.T)
    except (QhullError, ValueError):
        return parts
    if foot.volume < COMPLETED_LEVEL * outline.volume:  # areas, in the plane
        return parts
    level = low[foot.vertices]
    level = level - np.outer(level @ up - bottom, up)
    return (hull_vertices(np.vstack([corners, level])),)
