"""Flat faces of clouds that lie on each other: how far apart they are, and where they meet.

Contacts of clouds are found in cells of a centimetre, whose points say neither where a face ends nor whether
a gap is noise. Of two flat faces all points together do.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
from scipy.spatial import ConvexHull, QhullError

from topple.topology.base.arrays import FloatArray
from topple.topology.bodies.upright import Upright
from topple.topology.geometry.axes import perpendiculars
from topple.topology.statics.contact import Contact
from topple.topology.statics.grounds import planes_and_rest
from topple.topology.statics.tolerances import (
    FACE_BAND,
    FACE_CELL,
    FACE_CELLS,
    FACE_EVEN,
    FLAT_SHARE,
    LEVEL_FACE,
    LOWEST_SHARE,
    ON_FACE_PLANE,
    ROUND_FACE,
    SAME_FACE,
)


@dataclass(frozen=True, eq=False)
class Faces:
    """Two flat faces that lie on each other.

    Attributes:
        contact: The corners of what they share.
        gap: How far apart they are [m], negative where they are in each other.
    """

    contact: Contact
    gap: float


def faces_of(
    contact: Contact, clouds: Mapping[str, FloatArray], upright: Upright, noise: float
) -> Faces | None:
    """Hold the faces of two clouds at a contact against each other; what is round, against a table.

    Args:
        contact: A patch between them.
        clouds: name -> (N, 3) upright points [m], all that there are.
        upright: The upright scene.
        noise: Standard deviation of the points across their surfaces [m].

    Returns:
        The faces; None where they are not flat, level and parallel.
    """
    found = _flat_faces(contact, clouds, upright, noise)
    planes = planes_and_rest(upright, contact.a)[0] if found is None and contact.a in upright.fixed else ()
    if len(planes) != 1 or planes[0].ends:
        return found
    lowest = float(np.quantile(planes[0].heights(clouds[contact.b]), LOWEST_SHARE))
    return Faces(contact, lowest)


def _flat_faces(
    contact: Contact, clouds: Mapping[str, FloatArray], upright: Upright, noise: float
) -> Faces | None:
    """The same of flat faces alone."""
    alike = contact.normals @ contact.normals.T > SAME_FACE
    best = int(alike.sum(axis=1).argmax())
    if alike[best].mean() < FLAT_SHARE:
        return None
    normal = contact.normals[alike[best]].mean(axis=0)
    normal /= np.linalg.norm(normal)
    if abs(normal[2]) < LEVEL_FACE:
        return None
    middle = contact.points[alike[best]].mean(axis=0)
    planes = planes_and_rest(upright, contact.a)[0] if contact.a in upright.fixed else ()
    near = [plane for plane in planes if abs(plane.heights(middle[None])[0]) < FACE_BAND]
    second = _along(clouds[contact.b], middle, normal)
    if near and not near[0].ends:
        first = np.column_stack(
            [second[:, :2], second[:, 2] - near[0].heights(_back(second, middle, normal))]
        )
    else:
        first = _along(clouds[contact.a], middle, normal)
    gaps = _gaps(first, second)
    if len(gaps) < FACE_CELLS or np.subtract(*np.quantile(gaps, (0.75, 0.25))) > FACE_EVEN + 2 * noise:
        return None
    ends = _face(first, noise, 1.0), _face(second, noise, -1.0)
    outline = None if ends[0] is None or ends[1] is None else _shared_outline(ends[0], ends[1])
    if outline is None:
        return None
    points = _back(np.column_stack([outline, np.zeros(len(outline))]), middle, normal)
    count = len(points)
    flat = replace(
        contact,
        points=points,
        normals=np.tile(normal, (count, 1)),
        gaps=np.zeros(count),
        turns=np.zeros(count),
    )
    return Faces(flat, float(np.median(gaps)))


def _along(points: FloatArray, middle: FloatArray, normal: FloatArray) -> FloatArray:
    """Points near a plane: two coordinates in it and one along its normal [m]."""
    local = (points - middle) @ np.stack([*perpendiculars(normal), normal], axis=1)
    return local[np.abs(local[:, 2]) < FACE_BAND]


def _back(local: FloatArray, middle: FloatArray, normal: FloatArray) -> FloatArray:
    return local @ np.stack([*perpendiculars(normal), normal]) + middle


def _gaps(first: FloatArray, second: FloatArray) -> FloatArray:
    """(K,) gaps [m] in the cells where both have points."""
    found: list[float] = []
    cells = [np.floor(each[:, :2] / FACE_CELL).astype(np.int64) for each in (first, second)]
    keys = [each[:, 0] * (1 << 20) + each[:, 1] for each in cells]
    for key in np.intersect1d(keys[0], keys[1]):
        low, high = first[keys[0] == key, 2], second[keys[1] == key, 2]
        top, bottom = low[low > low.max() - ON_FACE_PLANE], high[high < high.min() + ON_FACE_PLANE]
        found.append(float(np.median(bottom) - np.median(top)))
    return np.array(found)


def _face(local: FloatArray, noise: float, side: float) -> FloatArray | None:
    """(N, 2) points of the outer face of a cloud on one side; None of what is round there."""
    heights = side * local[:, 2]
    level = np.quantile(heights, 0.5) if np.ptp(heights) < ON_FACE_PLANE else _most_at(heights)
    near = np.abs(heights - level) < ON_FACE_PLANE + 2 * noise
    spread = float(np.subtract(*np.quantile(heights[near], (0.75, 0.25))))
    return (
        local[near, :2] if spread < 1.35 * noise + ROUND_FACE else None
    )  # the quartiles of noise are so far apart


def _most_at(heights: FloatArray) -> float:
    """The height at which most points are [m]."""
    counts, edges = np.histogram(
        heights, bins=np.arange(-FACE_BAND, FACE_BAND + ON_FACE_PLANE, ON_FACE_PLANE)
    )
    most = int(counts.argmax())
    inside = (heights >= edges[most] - ON_FACE_PLANE) & (heights < edges[most + 1] + ON_FACE_PLANE)
    return float(np.median(heights[inside]))


def _shared_outline(first: FloatArray, second: FloatArray) -> FloatArray | None:
    """(K, 2) corners of what two convex outlines share [m]; None where that has no area."""
    try:
        outline = first[ConvexHull(first).vertices]
        sides = ConvexHull(second).equations
        for normal, offset in zip(sides[:, :2], sides[:, 2], strict=True):
            beyond = outline @ normal + offset
            ahead, after = np.roll(outline, -1, axis=0), np.roll(beyond, -1)
            cut = beyond * after < 0
            share = beyond[cut] / (beyond[cut] - after[cut])
            crossed = outline[cut] + share[:, None] * (ahead[cut] - outline[cut])
            outline = np.concatenate([outline[beyond <= 0], crossed])
            outline = outline[ConvexHull(outline).vertices]
    except (QhullError, ValueError):
        return None
    return outline
