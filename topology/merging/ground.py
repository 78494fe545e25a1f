"""The ground of one view, and what stands on it."""

from dataclasses import dataclass

import numpy as np

from topple.topology.base.arrays import FloatArray
from topple.topology.base.errors import InvalidInput
from topple.topology.geometry.plane import fit_plane
from topple.topology.merging.tolerances import TOLERANCES
from topple.topology.views.image import DepthImage


@dataclass(frozen=True, eq=False)
class Ground:
    """The plane that carries what one camera saw.

    Attributes:
        plane: (n, d) with n up, towards the camera: n.x + d is the height of x [m].
        share: Share of the view's points in it.
        residual: Root mean square of their distances to it [m].
        points: (N, 3) those points [m].
        standing: (M, 3) the points above it [m].
    """

    plane: FloatArray
    share: float
    residual: float
    points: FloatArray
    standing: FloatArray

    @property
    def up(self) -> FloatArray:
        """(3,) unit normal, against gravity where the ground is level."""
        return self.plane[:3]


def ground_of(image: DepthImage, name: str = "the view") -> Ground:
    """Find the plane that most of a view's points lie in, and tell it from what stands on it.

    Args:
        image: What the camera saw.
        name: Of the view, for messages.

    Raises:
        InvalidInput: The view has no depth, no plane has enough of its points, or nothing stands there.
    """
    points = image.points().reshape(-1, 3)
    points = points[np.isfinite(points).all(axis=1)]
    if len(points) < TOLERANCES.fewest:
        raise InvalidInput(f"{name} has depth in {len(points)} pixels: expected a picture of a scene")
    plane, share = fit_plane(points)
    if share < TOLERANCES.level:
        raise InvalidInput(
            f"{name}: the plane of most points holds {share:.0%} of them, at least {TOLERANCES.level:.0%} "
            "needed to be sure of the ground: show more of the table"
        )
    if float(plane[:3] @ image.viewpoint + plane[3]) < 0.0:
        plane = -plane
    height = points @ plane[:3] + plane[3]
    on = np.abs(height) <= TOLERANCES.ground
    standing = points[(height > TOLERANCES.ground) & (height < TOLERANCES.highest)]
    if len(standing) < TOLERANCES.fewest:
        raise InvalidInput(f"{name}: nothing stands on the ground ({len(standing)} points above it)")
    middle = np.median(standing, axis=0)
    near = [
        part[np.linalg.norm(part - middle, axis=1) < TOLERANCES.around] for part in (points[on], standing)
    ]
    return Ground(plane, share, float(np.sqrt(np.mean(np.square(height[on])))), *near)
