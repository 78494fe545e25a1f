"""What an order takes for granted: said in sentences, since a scene rarely shows everything."""

from itertools import permutations
from typing import TYPE_CHECKING

import numpy as np
from scipy.spatial import ConvexHull, QhullError

from topple.topology.arrays import FloatArray, bounds
from topple.topology.complete import is_hollow
from topple.topology.statics import Statics

if TYPE_CHECKING:
    from topple.topology.scene import Scene

DEEP = 0.01
"""Depth [m] below another body's hull from which clouds overlap: noise and spacing reach half of it."""

SHARE = 0.1
"""Share of an object's points that lie so deep: a few strays, or a corner of a mask, are less."""

BELOW = 0.01
"""How far [m] below the table's surface the top of an object lies that is said to be below it."""


def assumptions(scene: "Scene", statics: Statics) -> tuple[str, ...]:
    """What had to be assumed about gravity and bodies.

    Args:
        scene: The scene.
        statics: The scene at rest.

    Returns:
        Sentences: no fixed object, objects below the table or carried by nothing, overlapping clouds.
    """
    said = list(_unfixed(scene))
    for name in statics.upright.movable:
        if statics.surfaces[name][:, 2].max() < statics.upright.floor - BELOW:
            said.append(f"{name} lies below the table's surface")
        elif statics.unexplained.get(name, 0.0) > 0.5:
            said.append(f"nothing seen carries {name}: it is taken to be held by something no camera saw")
    return (*said, *_overlaps(statics))


def _unfixed(scene: "Scene") -> tuple[str, ...]:
    if scene.fixed:
        return ()
    return ("no object is fixed: the lowest objects are taken to stand on a floor at their lowest point",)


def _overlaps(statics: Statics) -> tuple[str, ...]:
    """Pairs of which one lies within the other, which is not hollow: bodies cannot."""
    clouds = statics.upright.clouds
    boxes = {name: bounds(clouds[name]) for name in statics.upright.movable}
    said: list[str] = []
    for inner, outer in permutations(statics.upright.movable, 2):
        lower, upper = boxes[outer][0] + DEEP, boxes[outer][1] - DEEP
        if (boxes[inner][0] >= upper).any() or (boxes[inner][1] <= lower).any():
            continue
        boxed = clouds[inner][((clouds[inner] > lower) & (clouds[inner] < upper)).all(axis=1)]
        if len(boxed) <= SHARE * len(clouds[inner]):
            continue
        if _deep(boxed, clouds[outer]) > SHARE * len(clouds[inner]) and not is_hollow(
            clouds[outer], statics.sight
        ):
            said.append(f"the clouds of {inner} and {outer} overlap: both are taken to be where they seem")
    return tuple(said)


def _deep(points: FloatArray, around: FloatArray) -> int:
    """How many points lie deep inside the hull of others."""
    try:
        faces = ConvexHull(around).equations
    except (QhullError, ValueError):
        return 0
    return int(np.count_nonzero((points @ faces[:, :3].T + faces[:, 3]).max(axis=1) < -DEEP))
