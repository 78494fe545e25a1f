"""Whether the surfaces two objects turn to each other were seen: only then does a gap mean no contact.

What is turned away from all cameras is missing from a cloud, but not from its hull: where the hull has no
points near it the object was not seen there, and may reach further. A place of one hull that faces the other
is settled where both surfaces were seen, or where a camera looked through between them.
"""

import numpy as np

from topple.topology.base.arrays import BoolArray, FloatArray
from topple.topology.base.tolerances import DEPTH_NOISE
from topple.topology.relations.surface import SurfaceCloud
from topple.topology.relations.tolerances import COVERED, DEPTH, SETTLED
from topple.topology.views.free_space import FreeSpace

SHARES = np.array([0.1, 0.3, 0.5, 0.7, 0.9])[:, None, None]
"""Where between two surfaces a camera may have looked through."""


def facing_seen(a: SurfaceCloud, b: SurfaceCloud, sight: FreeSpace) -> bool:
    """Whether the surfaces two objects turn to each other were seen, or the space between them was.

    Args:
        a: One object.
        b: The other.
        sight: What the cameras saw.
    """
    return settled_share(a, b, sight) >= SETTLED


def settled_share(a: SurfaceCloud, b: SurfaceCloud, sight: FreeSpace) -> float:
    """Share of the facing places, on both hulls, where no contact can be hidden.

    Args:
        a: One object.
        b: The other.
        sight: What the cameras saw.
    """
    ways = [_across(one, other) for one, other in ((a, b), (b, a))]
    closest = min(float(length.min()) for _, _, length in ways)
    settled: list[BoolArray] = []
    for (start, end, length), (one, other) in zip(ways, ((a, b), (b, a)), strict=True):
        facing = length <= closest + DEPTH
        start, end = start[facing], end[facing]
        if len(start):
            found = _seen_from_front(one, start, end, sight)
            found[found] = _seen_from_front(other, end[found], start[found], sight)
            between = start[~found] * (1 - SHARES) + end[~found] * SHARES
            free = sight.empty(between.reshape(-1, 3), DEPTH_NOISE).reshape(len(SHARES), -1).any(axis=0)
            found[~found] = free
            settled.append(found)
    return float(np.concatenate(settled).mean())


def _across(a: SurfaceCloud, b: SurfaceCloud) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Places (N, 3) on A's hull, the places (N, 3) on B they face, and how far those are [m]."""
    places = a.places
    table = places @ b.hull.normals.T + b.hull.offsets
    facet = table.argmax(axis=1)
    length = table[np.arange(len(places)), facet]
    ends = places - length[:, None] * b.hull.normals[facet]
    # Inside the other's hull, and beside its faces, the nearest point of its surface is faced.
    aside = (length <= DEPTH_NOISE) | (b.hull.facet_distance(ends) > DEPTH_NOISE)
    if aside.any():
        distance, index = b.tree.query(places[aside])
        ends[aside], length[aside] = b.coarse[index], distance
    return places, ends, length


def _seen_from_front(a: SurfaceCloud, places: FloatArray, towards: FloatArray, sight: FreeSpace) -> BoolArray:
    """Which places of a hull have a surface near them that some camera sees from the side it faces."""
    covered = a.tree.query(places)[0] <= max(COVERED * a.spacing, DEPTH_NOISE)
    return covered & sight.faces(places, towards - places)
