"""Edges of tops: where a table was seen to end, and not only the picture of it."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from topple.topology.arrays import FloatArray
from topple.topology.bodies.solids import up_of
from topple.topology.bodies.tolerances import (
    EDGE_BIN,
    EDGE_FEWEST,
    EDGE_SEEN,
    EDGE_STRAIGHT,
    EDGE_TURN,
    SIDE,
    SIDE_NEAR,
)
from topple.topology.bodies.tops import Top, tops_of
from topple.topology.geometry.axes import cross
from topple.topology.scene import Scene


@dataclass(frozen=True, eq=False)
class Edge:
    """A straight piece of the outline of a top, beyond which nothing carries.

    Attributes:
        owner: The fixed body whose top ends there.
        top: The top.
        place: (3,) a point on it [m].
        outward: (3,) level unit vector, away from the top.
    """

    owner: str
    top: Top
    place: FloatArray
    outward: FloatArray

    def beyond(self, points: FloatArray) -> FloatArray:
        """How far points (..., 3) are beyond it [m], negative over the top."""
        return (points - self.place) @ self.outward


def top_under(name: str, scene: Scene) -> tuple[str, Top] | None:
    """The highest top that an object stands on or over, with the fixed body that has it; None over none."""
    up = up_of(scene)
    found = [
        (other, tops_of(scene.clouds[other], up).under(scene.clouds[name])) for other in sorted(scene.fixed)
    ]
    tops = [(other, top) for other, top in found if top is not None]
    return max(tops, key=lambda each: float(each[1].points.mean(axis=0) @ up), default=None)


def edge_ahead(
    owner: str,
    top: Top,
    scene: Scene,
    middle: FloatArray,
    ahead: FloatArray,
    asides: Sequence[tuple[float, float]],
) -> Edge | None:
    """The edge that a thing comes to which goes straight along a top.

    A top's cloud ends where the table does, or where a camera saw no more of it. It is an edge where the
    table's own side is seen below its end, nearly all along.

    Args:
        owner: The fixed body whose top it is.
        top: The top.
        scene: What was seen.
        middle: (3,) where the thing is [m].
        ahead: (3,) level unit vector, where it goes.
        asides: From where to where to the left of the middle the edge has to be seen [m].

    Returns:
        The edge; None where the end of the top is no straight line square to the way, give or take
        `EDGE_TURN`, or was not seen to be its end.
    """
    up, cloud = up_of(scene), scene.clouds[owner]
    across = cross(up, ahead)
    lateral = (cloud - middle) @ across
    places: list[tuple[float, float]] = []
    for low, high in asides:
        kept = (lateral >= low) & (lateral < high)
        found = _ends((cloud[kept] - middle) @ ahead, top.above(cloud[kept]), lateral[kept], low, high)
        if found is None:
            return None
        places += found
    aside, ends = np.array(places).T
    slope, end = np.polyfit(aside, ends, 1)
    if abs(np.arctan(slope)) > EDGE_TURN or np.abs(slope * aside + end - ends).max() > EDGE_STRAIGHT:
        return None
    outward = (ahead - slope * across) / np.hypot(1.0, slope)
    place = middle + end * ahead
    return Edge(owner, top, place - float(top.above(place[None])[0]) * top.normal, outward)


def _ends(
    along: FloatArray, height: FloatArray, aside: FloatArray, low: float, high: float
) -> list[tuple[float, float]] | None:
    """Where a top ends, strip by strip, and its side is seen there; None where too few strips show that.

    Args:
        along: (N,) how far ahead points of its body are [m].
        height: (N,) how high above the top [m].
        aside: (N,) how far to the left [m], from `low` to `high`.
        low: Where the first strip begins.
        high: Where the last one ends.
    """
    count = max(2, int(np.ceil((high - low) / EDGE_BIN)))
    wide = (high - low) / count
    number = np.minimum(np.floor((aside - low) / wide).astype(np.int64), count - 1)
    level, side = np.abs(height) < SIDE[0], (height < -SIDE[0]) & (height > -SIDE[1])
    places: list[tuple[float, float]] = []
    for one in range(count):
        here = along[(number == one) & level]
        if len(here) < EDGE_FEWEST:
            continue
        below = along[(number == one) & side]
        below = below[np.abs(below - here.max()) < SIDE_NEAR]
        if len(below):
            places.append((low + (one + 0.5) * wide, float(np.median(below))))
    return places if len(places) >= EDGE_SEEN * count else None
