"""What things stand on: the planes of the tops of fixed bodies, and what else of these can be touched."""

from dataclasses import dataclass, replace

import numpy as np

from topple.topology.base.arrays import BoolArray, FloatArray, bounds, freeze, median_of, middle_of
from topple.topology.base.remembered import remember
from topple.topology.bodies.tolerances import KEPT_FRAMES
from topple.topology.bodies.upright import Upright
from topple.topology.statics.tolerances import EDGE, FLAT, MARGIN


@dataclass(frozen=True, eq=False)
class Plane:
    """A flat fixed surface: `normal @ x + offset` is the height above it [m], `normal` points up.

    Attributes:
        normal: (3,) unit normal.
        offset: See above [m].
        lower: (3,) lowest corner of the box around what was seen of it [m].
        upper: (3,) highest corner [m].
        ends: Whether it ends there, as the boards of a shelf do; a table seen from above may just be cut off.
    """

    normal: FloatArray
    offset: float
    lower: FloatArray
    upper: FloatArray
    ends: bool = False

    @staticmethod
    @remember(KEPT_FRAMES)
    def of(points: FloatArray) -> "Plane | None":
        """Fit a plane to a cloud, robustly.

        Args:
            points: (N, 3) upright points [m].

        Returns:
            The plane, or None where the cloud is not flat or stands upright (a wall).
        """
        if len(points) < 3:
            return None
        centre, normal, spread = _fit(points, points)
        for _ in range(2):
            near = points[np.abs((points - centre) @ normal) < 3 * spread]
            centre, normal, spread = _fit(near if len(near) >= 3 else points, points)
        if spread > FLAT or abs(normal[2]) < 0.5:
            return None
        normal = normal if normal[2] > 0 else -normal
        return Plane(freeze(normal), -float(normal @ centre), *bounds(points))

    def heights(self, points: FloatArray) -> FloatArray:
        """(N,) heights of (N, 3) points above the plane [m]."""
        return points @ self.normal + self.offset

    def over(self, points: FloatArray) -> BoolArray:
        """Which of (N, 3) points [m] are over it, or over where it goes on behind the objects."""
        margin = EDGE if self.ends else MARGIN
        low, high = self.lower[:2] - margin, self.upper[:2] + margin
        return np.asarray(((points[:, :2] > low) & (points[:, :2] < high)).all(axis=1))


def planes_and_rest(upright: Upright, name: str) -> tuple[tuple[Plane, ...], FloatArray]:
    """Take a fixed body apart into the planes of its tops and what else can be touched of it.

    Args:
        upright: The upright scene.
        name: The body.

    Returns:
        One plane a top, the highest first, and (M, 3) points on none of them [m].
    """
    tops, rest, cloud = upright.tops[name], upright.rest[name], upright.clouds[name]
    if len(rest) == 0 or not tops:  # one surface, or what so few points show as one
        plane = Plane.of(cloud)
        return ((), cloud) if plane is None else ((plane,), np.empty((0, 3)))
    planes = [Plane.of(top) for top in tops]
    rough = [top for top, plane in zip(tops, planes, strict=True) if plane is None]
    ending = tuple(replace(plane, ends=True) for plane in planes if plane is not None)
    return ending, np.vstack([rest, *rough])


def _fit(kept: FloatArray, points: FloatArray) -> tuple[FloatArray, FloatArray, float]:
    """Centre and normal of the plane through `kept`, and the robust spread [m] of `points` about it."""
    centre = middle_of(kept)
    normal = np.linalg.eigh(np.cov((kept - centre).T))[1][:, 0]
    heights = (points - centre) @ normal
    return centre, normal, max(1.4826 * median_of(np.abs(heights)), 1e-4)
