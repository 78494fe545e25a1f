"""First stage: bounding spheres of moving parts against boxes of standing ones and against each other."""

import numpy as np

from topple.planner.motion.model import CollisionModel
from topple.robots.collision.separation import Candidates, Float32Array, Frames
from topple.topology.base.arrays import IntArray


class BroadPhase:
    """Finds the pairs of parts that bounding volumes cannot tell apart, in many states at once."""

    def __init__(self, model: CollisionModel) -> None:
        sets, moving, standing = model.sets, model.moving, model.standing
        self._model = model
        self._frame = sets.frame[moving]
        self._centre = sets.centre[moving]
        # coordinates first, states last: the arrays stay contiguous
        self._middle = ((sets.lower + sets.upper) / 2)[standing].T[:, None, :, None].copy()
        self._half = ((sets.upper - sets.lower) / 2)[standing].T[:, None, :, None].copy()
        margin = model.margin.astype(np.float32)
        reach = sets.radius[moving][:, None] + margin[standing][None, :]
        self._squared = np.where(model.standing_pairs, reach**2, -1.0).astype(np.float32)[:, :, None]
        self._margin = margin
        first, second = model.moving_pairs.T
        position = np.full(len(sets.frame), -1)
        position[moving] = np.arange(len(moving))
        self._first, self._second = position[first], position[second]
        self._apart = ((sets.radius[first] + sets.radius[second]) ** 2).astype(np.float32)[:, None]

    def candidates(self, frames: Frames) -> Candidates:
        """The pairs to look at more closely.

        Args:
            frames: Where the frames are in m states.

        Returns:
            Pairs with standing parts, then pairs of moving ones.
        """
        model = self._model
        centres = frames.points(self._frame, self._centre)
        count = centres.shape[2]
        offset: Float32Array = np.subtract(centres[:, :, None, :], self._middle)
        beyond = np.abs(offset)
        beyond -= self._half
        np.maximum(beyond, 0, out=beyond)
        beyond *= beyond
        near = np.flatnonzero(beyond[0] + beyond[1] + beyond[2] <= self._squared)
        both, state = np.divmod(near, count)
        m, s = np.divmod(both, len(model.standing))
        apart = centres.take(self._first, axis=1) - centres.take(self._second, axis=1)
        x, y, z = apart
        pair = np.flatnonzero(x * x + y * y + z * z <= self._apart)
        k, pair_state = np.divmod(pair, count)
        direction = self._direction(offset.reshape(3, -1).take(near, axis=1), s)
        part = model.standing[s]
        return Candidates(
            np.concatenate([state, pair_state]),
            np.concatenate([model.moving[m], model.moving_pairs[k, 0]]),
            np.concatenate([part, model.moving_pairs[k, 1]]),
            np.concatenate([direction, apart.reshape(3, -1).take(pair, axis=1).T]),
            np.concatenate([self._margin[part], np.zeros(len(k), dtype=np.float32)]),
        )

    def _direction(self, offset: Float32Array, s: IntArray) -> Float32Array:
        """From the nearest point of the box to the centre; from inside, out through the nearest face."""
        half = self._half[:, 0, s, 0]
        outside: Float32Array = np.subtract(offset, np.clip(offset, -half, half), dtype=np.float32)
        inside = np.flatnonzero(~outside.any(axis=0))
        if len(inside):
            axis = np.argmin(half[:, inside] - np.abs(offset[:, inside]), axis=0)
            sign = np.sign(offset[axis, inside])
            outside[axis, inside] = np.where(sign == 0, 1, sign)
        return outside.T
