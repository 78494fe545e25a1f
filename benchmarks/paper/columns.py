"""The methods that are compared, each from a scene's clouds to one answer per pair.

topple is asked as anyone would ask it. The others get the clouds without their stray points: the paper, too,
filters outliers before anything else.
"""

from collections.abc import Callable, Mapping
from itertools import combinations

import numpy as np

from topple.benchmarks.contrasts.features import support_features
from topple.benchmarks.contrasts.nine import nine
from topple.topology.base.arrays import FloatArray
from topple.topology.base.tolerances import TOLERANCES
from topple.topology.relations.relate import relate
from topple.topology.scene.cloud import clean, estimate_deviation
from topple.topology.scene.scene import Scene
from topple.topology.sixim.table import Relation, classify

Answer = Mapping[tuple[str, str], Relation]
"""Relation of every ordered pair (a, b) the method knows: "a relation b"."""
Column = Callable[[Scene], Answer]

TOPPLE, PLAIN, ESTIMATED, NINE, BOXES, SUPPORT, CONTACT_POINTS = (
    "topple", "plain 6IM, 2 mm", "plain 6IM, estimated", "9IM on solids", "AABB", "feature extraction",
    "learning",
)  # fmt: skip
LENIENT = frozenset({SUPPORT})
"""Columns that only know containment: contain or partial contain, the paper counts either as right."""


def columns(learned: Column | None = None) -> dict[str, Column]:
    """The methods by name.

    Args:
        learned: The trained method, where there is one.
    """
    found: dict[str, Column] = {
        TOPPLE: topple,
        PLAIN: plain,
        ESTIMATED: estimated,
        NINE: nine,
        BOXES: boxes,
        SUPPORT: support_features,
    }
    return found if learned is None else {**found, CONTACT_POINTS: learned}


def cleaned(scene: Scene) -> Scene:
    """The scene without stray points and images."""
    clouds = {name: clean(cloud) for name, cloud in scene.clouds.items()}
    return Scene(clouds, scene.fixed, scene.up, scene.viewpoints)


def topple(scene: Scene) -> Answer:
    """The default rule."""
    return {(pair.a, pair.b): pair.relation for pair in relate(scene)}


def plain(scene: Scene) -> Answer:
    """The paper's rule to the letter, at 2 mm."""
    return {(pair.a, pair.b): pair.relation for pair in relate(scene, plain=True)}


def estimated(scene: Scene) -> Answer:
    """The paper's rule to the letter, at the deviation of the point clouds."""
    return {(pair.a, pair.b): pair.relation for pair in relate(scene, estimate_deviation(scene), plain=True)}


def boxes(scene: Scene) -> Answer:
    """The paper's rule with axis-aligned boxes instead of hulls."""
    limits = {name: (cloud.min(axis=0), cloud.max(axis=0)) for name, cloud in scene.clouds.items()}
    return {
        (a, b): classify([_counts(scene.clouds[a], *limits[b]), _counts(scene.clouds[b], *limits[a])])
        for a, b in combinations(scene.names, 2)
    }


def _counts(points: FloatArray, lower: FloatArray, upper: FloatArray) -> tuple[int, int, int]:
    """Points inside, on and outside a box, by the deviation of the plain rule (equation 4)."""
    distance = np.maximum(lower - points, points - upper).max(axis=1)
    deviation = TOLERANCES.plain_deviation
    inner, outer = int((distance < -deviation).sum()), int((distance > deviation).sum())
    return inner, len(points) - inner - outer, outer
