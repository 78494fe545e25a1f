"""Support from features: contact normals, planes and a support tree, with containment.

After Panda, Hafez and Jawahar, "Learning support order for manipulation in clutter" (IROS 2013), which the
paper compares itself to, as far as the paper describes it: support from below or from the side follows from
the normals of the surfaces where two segments meet, containment from the share of points one segment has
inside the other, and what has no support gets the surface below it that is nearest. An implementation of our
own; theirs is learned from photographs.
"""

from itertools import combinations

import numpy as np

from topple.topology.base.arrays import FloatArray, IntArray
from topple.topology.base.tolerances import NEIGHBOURS
from topple.topology.geometry.axes import perpendiculars
from topple.topology.geometry.hull import Hull
from topple.topology.geometry.thin import thinned
from topple.topology.kernels.neighbours import PointTree
from topple.topology.scene.scene import Scene
from topple.topology.sixim.table import Relation
from topple.topology.statics.contact import local_normals

REACH = 0.008
"""Distance [m] of points that may belong to a contact: spacing and noise of a depth camera, twice over."""

SPACING = 0.004
"""Clouds are thinned to about this [m]."""

FEWEST = 4
"""Points that make a contact."""

CONTAINED = 0.3
"""Share of a segment inside another's hull that makes it contained."""

PARALLEL = 0.7
"""Cosine of the angle of two surfaces up to which they face each other."""

DROP = 0.08
"""How far below [m] the support of a segment without one is looked for."""


def support_features(scene: Scene) -> dict[tuple[str, str], Relation]:
    """Touch where one supports the other from below or from the side, contain where one holds the other.

    Args:
        scene: Clouds, with `up`.

    Returns:
        One relation per pair.
    """
    up = np.array([0.0, 0.0, 1.0]) if scene.up is None else scene.up
    points = {name: thinned(cloud, SPACING) for name, cloud in scene.clouds.items()}
    trees = {name: PointTree(cloud) for name, cloud in points.items()}
    hulls = {name: Hull.of(cloud) for name, cloud in points.items()}
    found: dict[tuple[str, str], Relation] = {}
    for a, b in combinations(scene.names, 2):
        if _inside(points[a], hulls[b]) >= CONTAINED:
            found[a, b] = Relation.WITHIN
        elif _inside(points[b], hulls[a]) >= CONTAINED:
            found[a, b] = Relation.CONTAIN
        elif _supports(points[a], trees[a], points[b], trees[b], up):
            found[a, b] = Relation.TOUCH
        else:
            found[a, b] = Relation.DISJOINT
    return _with_tree(scene, found, points, up)


def _inside(points: FloatArray, hull: Hull) -> float:
    """Share of points inside a hull."""
    if hull.dimension < 3:
        return 0.0
    near = ((points >= hull.lower) & (points <= hull.upper)).all(axis=1)
    return float((hull.facet_distance(points[near]) < 0).sum()) / len(points) if near.any() else 0.0


def _supports(a: FloatArray, tree_a: PointTree, b: FloatArray, tree_b: PointTree, up: FloatArray) -> bool:
    """Whether the surfaces meet face to face: from below or from the side."""
    near_a = np.flatnonzero(tree_b.query(a, distance_upper_bound=REACH)[0] < REACH)
    near_b = np.flatnonzero(tree_a.query(b, distance_upper_bound=REACH)[0] < REACH)
    if min(len(near_a), len(near_b)) < FEWEST:
        return False
    normal_a, normal_b = _normals(a, tree_a, near_a), _normals(b, tree_b, near_b)
    partner = PointTree(b[near_b]).query(a[near_a])[1]
    facing = np.abs(np.einsum("ni,ni->n", normal_a, normal_b[partner])) >= PARALLEL
    below = np.abs(normal_a @ up) >= PARALLEL
    below |= np.abs(normal_b[partner] @ up) >= PARALLEL
    return bool((facing | below).sum() >= FEWEST)


def _normals(points: FloatArray, tree: PointTree, chosen: IntArray) -> FloatArray:
    groups = tree.query(points[chosen], k=min(NEIGHBOURS, len(points)))[1]
    return local_normals(points, list(groups.reshape(len(chosen), -1)))[0]


def _with_tree(
    scene: Scene, found: dict[tuple[str, str], Relation], points: dict[str, FloatArray], up: FloatArray
) -> dict[tuple[str, str], Relation]:
    """Give everything without a support the nearest thing below it: the tree needs one for each."""
    for name in scene.movable:
        held = [pair for pair, relation in found.items() if name in pair and relation != Relation.DISJOINT]
        if any(_carries(other, name, points, up, scene) for pair in held for other in pair if other != name):
            continue
        drops = {other: _drop(points[name], points[other], up) for other in scene.names if other != name}
        other = min(drops, key=lambda one: drops[one])
        if drops[other] <= DROP:
            found[(name, other) if (name, other) in found else (other, name)] = Relation.TOUCH
    return found


def _carries(other: str, name: str, points: dict[str, FloatArray], up: FloatArray, scene: Scene) -> bool:
    return other in scene.fixed or float((points[other] @ up).mean()) < float((points[name] @ up).mean())


def _drop(above: FloatArray, below: FloatArray, up: FloatArray) -> float:
    """How far a thing would fall onto another [m], infinite where that is not under it."""
    across = np.stack(perpendiculars(up), axis=1)
    distance, index = PointTree(below @ across).query(above @ across, distance_upper_bound=2 * SPACING)
    under = distance < np.inf
    fall = (above @ up)[under] - (below @ up)[index[under]]
    fall = fall[fall > -REACH]
    return float(fall.min()) if len(fall) else np.inf
