"""What the cameras saw to be empty: where a line of sight went on to something further away.

A camera is known by its depth image, or only by where it stood: then its lines of sight are those to the
points of the clouds. Either way it knows nothing of a direction from which nothing came back, nor of what is
beside its picture: glass, soot and the sky return nothing, and so does a wall out of range.
"""

from collections.abc import Mapping, Sequence
from copy import copy
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from topple.topology.base.arrays import BoolArray, FloatArray, lengths
from topple.topology.kernels.neighbours import PointTree
from topple.topology.views.image import DepthImage
from topple.topology.views.tolerances import MARGIN, WIDTH, WITNESSES


@dataclass(frozen=True, eq=False)
class _Rays:
    """Directions in which a camera has points before it, and how far away they are [m]."""

    centre: FloatArray
    directions: PointTree
    ranges: FloatArray

    @staticmethod
    def of(points: FloatArray, centre: FloatArray) -> "_Rays":
        rays = points - centre
        ranges = lengths(rays)
        return _Rays(centre, PointTree(rays / np.maximum(ranges, 1e-12)[:, None]), ranges)

    def past(self, places: FloatArray, any_of: bool = False) -> FloatArray:
        """(N,) how much further than places (N, 3) all or any witnesses reach [m], NaN where too few are."""
        if len(self.ranges) < WITNESSES:
            return np.full(len(places), np.nan)
        rays = places - self.centre
        far = lengths(rays)
        nearest = self.directions.query(
            rays / np.maximum(far, 1e-12)[:, None], k=WITNESSES, distance_upper_bound=WIDTH
        )
        distance, index = np.asarray(nearest[0]), np.asarray(nearest[1])
        reached = self.ranges[np.minimum(index, len(self.ranges) - 1)]
        reach = reached.max(axis=1) if any_of else reached.min(axis=1)
        return np.where(np.isfinite(distance).all(axis=1), reach - far, np.nan)


class FreeSpace:
    """The free space of a scene, from its depth images or, without them, from clouds and camera centres."""

    def __init__(
        self,
        clouds: Mapping[str, FloatArray],
        viewpoints: FloatArray,
        images: Sequence[DepthImage] = (),
        rotation: FloatArray | None = None,
    ) -> None:
        """Take in what is known of the cameras.

        Args:
            clouds: Points (N, 3) [m] by name.
            viewpoints: (k, 3) camera centres [m], same frame.
            images: What they took; where there are any, they replace the camera centres.
            rotation: (3, 3) whose rows are the frame's axes in the images' world; the same frame if None.
        """
        self._images = tuple(images)
        self._rotation = np.eye(3) if rotation is None else rotation
        centres = np.array([image.viewpoint for image in images]) @ self._rotation.T if images else viewpoints
        self.viewpoints: FloatArray = np.asarray(centres).reshape(-1, 3)
        """(k, 3) centres of all cameras [m]."""
        self._clouds = dict(clouds)

    def with_clouds(self, clouds: Mapping[str, FloatArray]) -> "FreeSpace":
        """The free space once some objects have other clouds; images stay what they are.

        Args:
            clouds: Their new points (N, 3) [m] by name.
        """
        changed = copy(self)
        changed._clouds = {**self._clouds, **clouds}
        changed._shown_by_cloud = {
            **self._shown_by_cloud,
            **{name: self._news(cloud) for name, cloud in clouds.items()},
        }
        changed.__dict__.pop("_rays", None)
        return changed

    @property
    def known(self) -> bool:
        """Whether any camera is known."""
        return len(self.viewpoints) > 0

    def empty(self, places: FloatArray, margin: float = MARGIN) -> BoolArray:
        """Which places lie where a camera saw through.

        Args:
            places: (N, 3) places [m].
            margin: How much further off the surface behind a place must be at least [m].

        Returns:
            (N,) True where at least one camera saw something further away in that direction, and nothing
            nearer; False where it is hidden, where nothing came back, or nobody looked.
        """
        found = np.zeros(len(places), dtype=np.bool_)
        if len(places) == 0:
            return found
        for number, rays in enumerate(self._rays):
            past = rays.past(places)
            if self._images:
                blocked = past <= margin
                seen = self._images[number].depth_past(places @ self._rotation, around=True)
                found |= (seen > margin) & ~blocked
            else:
                found |= past > margin
        return found

    def shows(self, places: FloatArray, slack: float) -> BoolArray:
        """Which places a camera saw, or a surface there: what is hidden by less than noise is not.

        Args:
            places: (N, 3) places [m].
            slack: How far behind what was seen a place may be at most [m].

        Returns:
            (N,) True where at least one camera saw as far in that direction, or in the one beside it. One of
            which only the place is known looks everywhere: it saw what nothing nearer hides.
        """
        found = np.zeros(len(places), dtype=np.bool_)
        for image in self._images:
            found |= image.shows(places @ self._rotation, slack)
        for rays in () if self._images else self._rays:
            found |= ~(
                rays.past(places, any_of=True) < -slack
            )  # clouds say nothing where they have no points
        return found

    def faces(self, places: FloatArray, outward: FloatArray) -> BoolArray:
        """Which places of a surface are on a side of it that a camera looks at.

        Args:
            places: (N, 3) places [m].
            outward: (N, 3) directions out of the body there.

        Returns:
            (N,) True where at least one camera is on the outer side.
        """
        return (np.einsum("vpi,pi->vp", self.viewpoints[:, None] - places, outward) > 0.0).any(axis=0)

    def _news(self, cloud: FloatArray) -> tuple[FloatArray, ...]:
        """Points of a cloud that tell each camera more than its picture: all but those it pictured.

        Points in space that a picture shows empty have come there since: they end its lines of sight.
        """
        if not self._images:
            return (cloud,) * len(self.viewpoints)
        world = cloud @ self._rotation
        return tuple(cloud[image.depth_past(world) > MARGIN] for image in self._images)

    @cached_property
    def _shown_by_cloud(self) -> dict[str, tuple[FloatArray, ...]]:
        """Points that each cloud adds, by camera."""
        return {name: self._news(cloud) for name, cloud in self._clouds.items()}

    @cached_property
    def _rays(self) -> list[_Rays]:
        """The lines of sight of each camera to the points of the clouds that count for it."""
        return [
            _Rays.of(np.concatenate([news[number] for news in self._shown_by_cloud.values()]), centre)
            for number, centre in enumerate(self.viewpoints)
        ]
