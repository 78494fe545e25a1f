"""What a hollow object holds: places inside its hull with its wall standing higher all around."""

from dataclasses import dataclass

import numpy as np

from topple.topology.arrays import BoolArray, FloatArray, frozen
from topple.topology.errors import InvalidInput
from topple.topology.geometry.axes import perpendiculars
from topple.topology.geometry.hull import Hull
from topple.topology.tolerances import TOLERANCES

AZIMUTHS = 24
"""Directions in which a wall is looked for: one of them is 2 cm of a 16 cm bowl."""
PROBES = 256
"""Places tried when a cavity is looked for: one that takes a twentieth of the hull meets a dozen."""
BLOCK = 1 << 14
"""Lines of sight looked along at once (1 MB): they stay in a core's own cache."""


def surrounded(places: FloatArray, wall: FloatArray, up: FloatArray, height: float) -> BoolArray:
    """Whether a wall stands higher than a place in nearly every direction around it.

    Args:
        places: (N, 3) places [m].
        wall: (M, 3) points of the wall [m].
        up: (3,) unit vector upward.
        height: How much higher the wall must stand [m]; noise alone reaches a deviation or two.

    Returns:
        (N,) True where the wall rises by `height` and by `wall_slope` in `wall_azimuths` of the directions.
    """
    axes = np.stack([*perpendiculars(up), up], axis=1)
    local, standing = places @ axes, wall @ axes
    found = np.zeros(len(places), dtype=np.bool_)
    step = max(1, BLOCK // max(len(wall), 1))
    for start in range(0, len(places), step):
        block = local[start : start + step]
        along = standing[:, 0] - block[:, None, 0]
        across = standing[:, 1] - block[:, None, 1]
        rise = standing[:, 2] - block[:, None, 2]
        place, point = np.nonzero(
            (rise >= height) & (rise * rise >= TOLERANCES.wall_slope**2 * (along * along + across * across))
        )
        turn = np.arctan2(across[place, point], along[place, point]) / (2 * np.pi) + 0.5
        seen = np.zeros((len(block), AZIMUTHS), dtype=np.bool_)
        seen[place, np.minimum((turn * AZIMUTHS).astype(np.int64), AZIMUTHS - 1)] = True
        found[start : start + step] = seen.mean(axis=1) >= TOLERANCES.wall_azimuths
    return found


def roofed(places: FloatArray, wall: FloatArray, up: FloatArray, height: float, aside: float) -> BoolArray:
    """Whether there is wall straight above a place.

    Args:
        places: (N, 3) places [m].
        wall: (M, 3) points of the wall [m].
        up: (3,) unit vector upward.
        height: How far above the place at least [m].
        aside: How far beside the vertical at most [m]; not less than the spacing of the points.

    Returns:
        (N,) True where a point of the wall is there.
    """
    found = np.zeros(len(places), dtype=np.bool_)
    step = max(1, BLOCK // max(len(wall), 1))
    for start in range(0, len(places), step):
        offset = wall[None] - places[start : start + step, None]
        rise = offset @ up
        beside = np.einsum("nmi,nmi->nm", offset, offset) - rise**2
        found[start : start + step] = ((rise > height) & (beside < aside**2)).any(axis=1)
    return found


@dataclass(frozen=True, eq=False)
class Cavity:
    """The hollow of a bowl, cup, plate or open box.

    Attributes:
        up: (3,) unit vector upward.
        rim: Height of the rim along `up` [m]: where the wall stands lower in an eighth of the directions.
        floor: Height of the lowest place found inside [m].
        centre: (3,) middle of the places found inside [m].
        opening: (K, 3) highest point of the wall in each direction around the centre [m].
        wall: (M, 3) points of the object [m].
        hull: Hull of the object.
        height: How much higher than a held place the wall stands [m].
    """

    up: FloatArray
    rim: float
    floor: float
    centre: FloatArray
    opening: FloatArray
    wall: FloatArray
    hull: Hull
    height: float

    def holds(self, points: FloatArray) -> BoolArray:
        """Which points lie in the cavity: inside the hull, below the rim, with the wall around them.

        Args:
            points: (N, 3) points [m].
        """
        inside = self.hull.facet_distance(points) <= 0
        inside[inside] = surrounded(points[inside], self.wall, self.up, self.height)
        return inside


def cavity(points: FloatArray, up: FloatArray, height: float = 0.004) -> Cavity | None:
    """Find the hollow of an object that is open upward.

    Args:
        points: (N, 3) points on the object's surface [m]; some thousands are enough.
        up: (3,) unit vector upward.
        height: How much higher than what it holds the wall must stand [m]; the default is twice the
            deviation of a depth camera.

    Returns:
        The cavity, or None where less than a twentieth of the hull is hollow or the mouth is closed.

    Raises:
        InvalidInput: `up` is no direction.
    """
    length = float(np.linalg.norm(up))
    if not np.isfinite(length) or length == 0:
        raise InvalidInput(f"up {np.asarray(up).tolist()} is no direction: give three numbers, not all zero")
    up = np.asarray(up, dtype=np.float64) / length
    wall = points[:: -(-len(points) // 4000)]
    hull = Hull.of(wall)
    if hull.dimension < 3:
        return None
    places = _places_inside(hull)
    held = places[surrounded(places, wall, up, height)]
    spread = float(np.ptp(wall, axis=0).max())
    held = held[~roofed(held, wall, up, 0.0, 0.04 * spread)]  # a closed box has no mouth
    if len(held) * 20 < len(places):
        return None
    centre = held.mean(axis=0)
    opening = _rim_points(wall, centre, up)
    return Cavity(
        up=frozen(up),
        rim=float(np.quantile(opening @ up, 0.125)),
        floor=float((held @ up).min()),
        centre=frozen(centre),
        opening=frozen(opening),
        wall=frozen(wall),
        hull=hull,
        height=height,
    )


def _places_inside(hull: Hull) -> FloatArray:
    """Places spread evenly over a hull, always the same for the same hull."""
    index = np.arange(1, 8 * PROBES)
    shares = (index[:, None] * np.array([0.8191725, 0.6710436, 0.5497005])) % 1  # R3 low-discrepancy sequence
    places = hull.lower + shares * (hull.upper - hull.lower)
    return places[hull.facet_distance(places) < 0][:PROBES]


def _rim_points(wall: FloatArray, centre: FloatArray, up: FloatArray) -> FloatArray:
    """The highest wall point in each direction around the centre."""
    first, second = perpendiculars(up)
    offset = wall - centre
    turn = np.arctan2(offset @ second, offset @ first) / (2 * np.pi) + 0.5
    azimuth = np.minimum((turn * AZIMUTHS).astype(np.int64), AZIMUTHS - 1)
    height = wall @ up
    best = [wall[chosen[np.argmax(height[chosen])]] for chosen in _groups(azimuth)]
    return np.array(best)


def _groups(labels: FloatArray | BoolArray | np.ndarray) -> list[np.ndarray]:
    return [np.flatnonzero(labels == label) for label in np.unique(labels)]
