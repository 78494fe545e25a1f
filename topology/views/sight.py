"""What the cameras saw to be empty: space in front of a surface that a camera looked at."""

from collections.abc import Sequence

import numpy as np
from scipy.spatial import KDTree

from topple.topology.arrays import BoolArray, FloatArray
from topple.topology.image import DepthImage

WIDTH = float(np.radians(1.0))
"""A ray speaks for directions this close [rad]: the spacing of a thinned surface seen from 50 cm."""

MARGIN = 0.012
"""A point is seen to be empty where the surface behind it is at least this much [m] further off."""

WITNESSES = 3
"""Rays that must agree: at an outline one neighbour alone may belong to the background."""


class Sight:
    """The depth each camera saw per direction, rebuilt from the clouds and the camera centres."""

    def __init__(
        self,
        points: FloatArray,
        viewpoints: FloatArray,
        images: Sequence[DepthImage] = (),
        rotation: FloatArray | None = None,
    ) -> None:
        """Index the surface points by their direction from every camera.

        Args:
            points: (N, 3) all points of the scene [m], thinned or not.
            viewpoints: (k, 3) camera centres [m], same frame.
            images: What each of them took, in their order: beyond a picture's edges it saw nothing.
            rotation: (3, 3) whose rows are the frame's axes in the images' world; the same frame if None.
        """
        self._images = tuple(images) if len(images) == len(viewpoints) else (None,) * len(viewpoints)
        self._rotation = np.eye(3) if rotation is None else rotation
        self._views: list[tuple[FloatArray, KDTree, FloatArray]] = []
        for centre in viewpoints:
            rays = points - centre
            ranges = np.linalg.norm(rays, axis=1)
            self._views.append((centre, KDTree(rays / ranges[:, None]), ranges))

    def empty(self, points: FloatArray) -> BoolArray:
        """Which points lie where a camera saw through.

        Args:
            points: (N, 3) points [m].

        Returns:
            (N,) True where at least one camera saw something further away in that direction, and
            nothing nearer; False where it is hidden or nobody looked.
        """
        found = np.zeros(len(points), dtype=np.bool_)
        if len(points) == 0:
            return found
        for (centre, tree, ranges), image in zip(self._views, self._images, strict=True):
            rays = points - centre
            far = np.linalg.norm(rays, axis=1)
            distance, index = tree.query(rays / far[:, None], k=WITNESSES, distance_upper_bound=WIDTH)
            near = np.asarray(distance) < np.inf
            index = np.asarray(index)
            seen = np.where(near, ranges[np.minimum(index, len(ranges) - 1)], -np.inf)
            through = near.all(axis=1) & (seen > far[:, None] + MARGIN).all(axis=1)
            found |= through if image is None else through & image.in_view(points @ self._rotation)
        return found

    def facing(self, points: FloatArray, outward: FloatArray) -> BoolArray:
        """Which points of a surface are on a side of it that a camera looks at.

        Args:
            points: (N, 3) points [m].
            outward: (N, 3) directions out of the body there.

        Returns:
            (N,) True where at least one camera is on the outer side.
        """
        found = np.zeros(len(points), dtype=np.bool_)
        for centre, _, _ in self._views:
            found |= ((centre - points) * outward).sum(axis=1) > 0.0
        return found
