"""Last stage: python-fcl on the exact hulls, for the few pairs that nothing cheaper settled."""

from functools import lru_cache
from typing import Any

import numpy as np

from topple.planner.motion.model import CollisionModel
from topple.robots.collision.fcl_bodies import fcl_convex
from topple.topology.base.arrays import FloatArray


class ExactPhase:
    """Persistent fcl objects, one per part, moved to where they are asked about."""

    def __init__(self, model: CollisionModel) -> None:
        import fcl

        self._fcl: Any = fcl
        self._model = model
        self._objects: list[Any] = [fcl.CollisionObject(_convex(v.tobytes())) for v in model.vertices]
        self._frames: list[int] = model.sets.frame.tolist()
        self._rotations: FloatArray = np.empty((0, 0, 3, 3))
        self._translations: FloatArray = np.empty((0, 0, 3))
        self._row: list[int] = []
        self._request: Any = fcl.CollisionRequest()
        self._distance_request: Any = fcl.DistanceRequest()

    def load(self, poses: FloatArray) -> None:
        """Take the states the next questions are about, one row a state.

        Args:
            poses: (n + 1, 3, 4, r) of the chain frames in the base, as `Chain.poses` gives them.
        """
        self._rotations = np.ascontiguousarray(poses[:, :, :3].transpose(3, 0, 1, 2))
        self._translations = np.ascontiguousarray(poses[:, :, 3].transpose(2, 0, 1))
        self._row = [-1] * len(self._objects)

    def place(self, row: int, *parts: int) -> None:
        """Move parts to where they are in a loaded state."""
        for part in parts:
            frame = self._frames[part]
            if frame > 0 and self._row[part] != row:
                self._objects[part].setRotation(self._rotations[row, frame])
                self._objects[part].setTranslation(self._translations[row, frame])
                self._row[part] = row

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


@lru_cache(maxsize=4096)
def _convex(data: bytes) -> Any:
    return fcl_convex(np.frombuffer(data).reshape(-1, 3))
