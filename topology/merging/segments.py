"""What stands on the ground without masks, cut into objects where it bends inwards; and its outliers."""

import numpy as np

from topple.topology.base.arrays import BoolArray, FloatArray, IntArray
from topple.topology.kernels.neighbours import PointTree
from topple.topology.kernels.pieces import pieces_of_links
from topple.topology.kernels.planes import patch_planes
from topple.topology.merging.tolerances import TOLERANCES


def outliers(points: FloatArray) -> BoolArray:
    """Which points have their neighbours further away than most have: flying pixels and single returns.

    Args:
        points: (N, 3) evenly thinned points [m].
    """
    count = min(TOLERANCES.near, len(points))
    if count < 2:
        return np.zeros(len(points), dtype=np.bool_)
    distance = PointTree(points).query(points, k=count)[0][:, 1:].mean(axis=1)
    return distance > distance.mean() + TOLERANCES.spread * distance.std()


def segment_cloud(points: FloatArray, eyes: FloatArray) -> IntArray:
    """Cut a cloud into parts that bend outwards only, as most objects do and no two that touch at an angle.

    After Stein et al., "Object partitioning using local convexity" (CVPR 2014), on single points.

    Args:
        points: (N, 3) thinned points [m].
        eyes: (N, 3) where the camera of each was [m].

    Returns:
        (N,) numbers of segments from 0 on, the largest first; -1 for points in none.
    """
    none = np.full(len(points), -1, dtype=np.int64)
    if len(points) < TOLERANCES.smallest:
        return none
    tree = PointTree(points)
    patches = tree.query(points, k=min(TOLERANCES.near, len(points)))[1]
    normals = patch_planes(points[patches])[1]
    normals *= np.where(np.einsum("ni,ni->n", normals, eyes - points) < 0.0, -1.0, 1.0)[:, None]
    a, b = tree.query_pairs(TOLERANCES.link).T
    along = points[b] - points[a]
    along /= np.linalg.norm(along, axis=1)[:, None]
    bend = np.einsum("ei,ei->e", normals[b] - normals[a], along)  # above 0 outwards
    inwards = bend < -2.0 * np.sin(TOLERANCES.convex / 2.0)
    linked = np.bincount(np.concatenate([a, b]), minlength=len(points))
    bent = np.bincount(np.concatenate([a[inwards], b[inwards]]), minlength=len(points))
    crease = bent > TOLERANCES.crease * np.maximum(linked, 1)
    kept = ~inwards & ~crease[a] & ~crease[b]
    parts = pieces_of_links(np.stack([a[kept], b[kept]], axis=1), len(points))
    sizes = np.bincount(parts)
    ranked = [part for part in np.argsort(-sizes, kind="stable") if sizes[part] >= TOLERANCES.smallest]
    if not ranked:
        return none
    number = np.full(len(sizes), -1)
    number[ranked] = np.arange(len(ranked))
    return _with_crumbs(points, number[parts])


def _with_crumbs(points: FloatArray, segment: IntArray) -> IntArray:
    """Points of creases and crumbs go to the segment that is nearest."""
    loose = segment < 0
    distance, nearest = PointTree(points[~loose]).query(points[loose], distance_upper_bound=TOLERANCES.link)
    found = segment[loose]
    near = np.isfinite(distance)
    found[near] = segment[~loose][np.asarray(nearest)[near]]
    segment = segment.copy()
    segment[loose] = found
    return segment
