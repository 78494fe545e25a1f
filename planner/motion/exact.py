"""Last stage: python-fcl on the exact hulls, for the few pairs that nothing cheaper settled."""

from functools import lru_cache
from typing import Any

import numpy as np

from topple.planner.motion.model import CollisionModel
from topple.robots.convex import hull_of
from topple.topology.arrays import FloatArray


class ExactPhase:
    """Persistent fcl objects, one per part, moved to where they are asked about."""

    def __init__(self, model: CollisionModel) -> None:
        import fcl

        self._fcl: Any = fcl
        self._model = model
        self._objects: list[Any] = [fcl.CollisionObject(_convex(v.tobytes())) for v in model.vertices]
        self._request: Any = fcl.CollisionRequest()
        self._distance_request: Any = fcl.DistanceRequest()

    def place(self, frames: FloatArray, parts: set[int]) -> None:
        """Move parts to where they are in one state.

        Args:
            frames: (n + 1, 4, 4) poses of the chain frames in the base.
            parts: Indices of the parts.
        """
        for part in parts:
            frame = self._model.sets.frame[part]
            if frame > 0:
                pose = frames[frame]
                self._objects[part].setTransform(self._fcl.Transform(pose[:3, :3], pose[:3, 3]))

    def touches(self, a: int, b: int, margin: float = 0.0) -> bool:
        """Whether two placed parts touch or, with a margin, come closer than it."""
        if self._fcl.collide(self._objects[a], self._objects[b], self._request, self._fcl.CollisionResult()):
            return True
        return margin > 0 and self.distance(a, b) < margin

    def distance(self, a: int, b: int) -> float:
        """Distance of two placed parts in [m]; where they overlap, minus the depth."""
        result = self._fcl.DistanceResult()
        found = float(self._fcl.distance(self._objects[a], self._objects[b], self._distance_request, result))
        return found if found > 0 else -self._depth(a, b)

    def _depth(self, a: int, b: int) -> float:
        result = self._fcl.CollisionResult()
        request = self._fcl.CollisionRequest(num_max_contacts=1, enable_contact=True)
        self._fcl.collide(self._objects[a], self._objects[b], request, result)
        return max((float(contact.penetration_depth) for contact in result.contacts), default=0.0)


@lru_cache(maxsize=1024)
def _convex(data: bytes) -> Any:
    import fcl

    vertices, triangles = hull_of(np.frombuffer(data).reshape(-1, 3))
    faces = np.concatenate([np.full((len(triangles), 1), 3), triangles], axis=1).ravel()
    return fcl.Convex(vertices, len(triangles), faces)
