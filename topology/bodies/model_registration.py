"""Known models registered to what was seen of them: in any pose, one-sided, each fit with its residual.

What was seen is laid onto the model's surface (iterative closest points, mostly to its planes, far ones left
out). Most of a model was not seen, so the other way counts only where it contradicts: a point of the model
that a camera looked through, or that lies in what is fixed, is drawn to the nearest point that was seen. All
orientations are tried, since things in clutter lie anyhow, and many poses are followed at once. A model that
is turned onto itself lies as before: poses are told apart by where they put its surface.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from topple.topology.base.arrays import BoolArray, FloatArray, IntArray, lengths
from topple.topology.bodies.tolerances import (
    AGAINST,
    ALIKE,
    ALL_BUT_ENDS,
    CLOSE,
    FARTHEST_STEP,
    FEW,
    MOST_STARTS,
    OFF,
    ORIENTATIONS,
    SETTLED,
    SLIDES,
    SLIDING,
    STAGES,
    TOLD_APART_BY,
    TRIMMED,
)
from topple.topology.geometry.axes import perpendiculars
from topple.topology.kernels.neighbours import PointTree
from topple.topology.scene.model_fit import ModelFit

Excluded = Callable[[FloatArray], BoolArray]
"""Which of (N, 3) places [m] no part of an object can be at: seen to be empty, or inside of what is fixed."""


@dataclass(frozen=True, eq=False)
class Model:
    """The surface of a known object, in its own frame.

    Attributes:
        name: Of its file or folder.
        points: (N, 3) spread evenly over it [m].
        normals: (N, 3) unit vectors square to it there, of either sign.
    """

    name: str
    points: FloatArray
    normals: FloatArray


def register(model: Model, seen: FloatArray, excluded: Excluded, towards: FloatArray | None) -> ModelFit:
    """Register a model with what was seen of it.

    Args:
        model: The model.
        seen: (N, 3) points [m], strays dropped.
        excluded: Where nothing of it can be.
        towards: (3,) unit vector along which the cameras looked on average; None where nobody knows.

    Returns:
        The best fit, good or poor. Deterministic.
    """
    search = _Search(model, seen, excluded)
    starts = search.starts(towards)
    to_model, costs = search.settle(starts)
    if costs.min() > SETTLED:  # outlines misled: ends are hidden
        starts = search.slid(starts)
        wide, others = search.settle(
            starts[np.argsort(search.costs(starts, FEW), kind="stable")[:MOST_STARTS]]
        )
        to_model, costs = np.concatenate([to_model, wide]), np.concatenate([costs, others])
    best = to_model[costs.argmin()]
    to_model = np.concatenate([to_model, search.slid(best[None])])
    alike = to_model[search.costs(to_model, len(seen)) <= costs.min() + ALIKE]
    return search.fit_at(best, max(search.apart(best, other) for other in alike))


class _Search:
    """Poses of a model, many at once, as (K, 4, 4) transforms from the world into the model's frame."""

    def __init__(self, model: Model, seen: FloatArray, excluded: Excluded) -> None:
        rng = np.random.default_rng(0)
        self._model, self._excluded = model, excluded
        self._middle = (model.points.min(axis=0) + model.points.max(axis=0)) / 2.0
        self._points = model.points - self._middle
        self._near = PointTree(self._points)
        self._some = self._points[rng.permutation(len(self._points))]
        self._seen = seen[rng.permutation(len(seen))]
        self._near_seen = PointTree(self._seen)

    def starts(self, towards: FloatArray | None) -> FloatArray:
        """Every orientation, the model's front and its outline about where those of the seen points are."""
        turns = _orientations(ORIENTATIONS)
        axes = np.eye(3) if towards is None else np.stack([towards, *perpendiculars(towards)])
        model = self._some[:300] @ turns.transpose(0, 2, 1) @ axes.T
        least, most = model.min(axis=1), model.max(axis=1)
        flat = self._seen @ axes.T
        lower, upper = flat.min(axis=0), flat.max(axis=0)
        shift = (lower + upper - least - most) / 2.0
        if towards is not None:
            shift[:, 0] = lower[0] - least[:, 0]
        to_model = np.zeros((len(turns), 4, 4))
        to_model[:, :3, :3], to_model[:, 3, 3] = turns.transpose(0, 2, 1), 1.0
        to_model[:, :3, 3] = -np.einsum("kij,kj->ki", to_model[:, :3, :3], shift @ axes)
        return to_model

    def move_once(self, to_model: FloatArray, count: int, reach: float, contradicted: bool) -> FloatArray:
        """One round of matching and moving (Gauss-Newton, linear in small turns).

        Args:
            to_model: (K, 4, 4) poses.
            count: Points that are looked at, of either side.
            reach: From where on points are not matched [m].
            contradicted: Whether the model's points that cannot be there count.
        """
        here = _points_at(to_model, self._seen[:count])
        away, nearest = self._nearest(here, reach)
        offset, normals = here - self._points[nearest], self._model.normals[nearest]
        weight = np.square(np.maximum(1.0 - np.square(away / reach), 0.0))
        axes = np.broadcast_to(np.eye(3), (*here.shape, 3))
        ways = np.concatenate([normals[..., None, :], axes], axis=-2)
        weights = weight[..., None] * np.array([1.0 - SLIDING, SLIDING, SLIDING, SLIDING])
        rows, left = _equations(here, ways, offset, weights)
        if contradicted:
            model = self._some[:count]
            bad, drawn = self._refute(to_model, model)
            offset = drawn - model
            pull = AGAINST * bad * np.minimum(1.0, reach / np.maximum(np.linalg.norm(offset, axis=-1), 1e-9))
            axes = np.broadcast_to(np.eye(3), (*drawn.shape, 3))
            more, also = _equations(drawn, axes, offset, np.repeat(pull[..., None], 3, axis=-1))
            rows, left = np.concatenate([rows, more], axis=1), np.concatenate([left, also], axis=1)
        normal = rows.transpose(0, 2, 1) @ rows + 1e-9 * np.eye(6)
        step = -np.linalg.solve(normal, rows.transpose(0, 2, 1) @ left[..., None])[..., 0]
        step *= np.minimum(1.0, FARTHEST_STEP / np.maximum(np.abs(step).max(axis=1), 1e-12))[:, None]
        move = np.zeros_like(to_model)
        move[:, :3, :3] = Rotation.from_rotvec(step[:, :3]).as_matrix()
        move[:, :3, 3], move[:, 3, 3] = step[:, 3:], 1.0
        return move @ to_model

    def settle(self, to_model: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Where the best of some poses settle, and (K,) their costs."""
        for kept, points, rounds, reach, contradicted in STAGES:
            for _ in range(rounds):
                to_model = self.move_once(to_model, points, reach, contradicted)
            to_model = self.distinct(to_model, points, kept)
        return to_model, self.costs(to_model, len(self._seen))

    def slid(self, to_model: FloatArray) -> FloatArray:
        """The poses, and each shifted along the model's axes by shares of its extents."""
        extents = np.diag(np.ptp(self._points, axis=0))
        shifts = np.concatenate([np.zeros((1, 3)), *(share * extents for share in SLIDES)])
        moved = np.repeat(to_model, len(shifts), axis=0)
        moved[:, :3, 3] += np.tile(shifts, (len(to_model), 1))
        return moved

    def costs(self, to_model: FloatArray, count: int) -> FloatArray:
        """(K,) mean squared distances, none counted beyond `OFF`, in squares of it, and contradictions."""
        away, _ = self._nearest(_points_at(to_model, self._seen[:count]), OFF)
        model = self._some[:count]
        bad, drawn = self._refute(to_model, model)
        shown = np.linalg.norm(drawn - model, axis=-1) < OFF
        through = bad.sum(axis=1) / np.maximum((bad | shown).sum(axis=1), 1)
        return np.square(np.minimum(away / OFF, 1.0)).mean(axis=1) + AGAINST * through

    def distinct(self, to_model: FloatArray, count: int, most: int) -> FloatArray:
        """The best poses, none that puts the surface where a better one does."""
        order = np.argsort(self.costs(to_model, count), kind="stable")
        kept = [to_model[order[0]]]
        for pose in to_model[order[1 : TOLD_APART_BY * most]]:
            if len(kept) == most:
                break
            if min(self.apart(other, pose) for other in kept) > CLOSE:
                kept.append(pose)
        return np.stack(kept)

    def apart(self, one: FloatArray, other: FloatArray) -> float:
        """How far the surface at one pose is from that at another, all but a twentieth of it [m]."""
        there = _points_at((one @ np.linalg.inv(other))[None], self._some[:60])
        return float(np.quantile(self._near.query(there[0])[0], ALL_BUT_ENDS))

    def fit_at(self, to_model: FloatArray, ambiguity: float) -> ModelFit:
        """The fit at a pose, with its residual and shares."""
        here = _points_at(to_model[None], self._seen)[0]
        away, nearest = self._near.query(here)
        offset = here - self._points[nearest]
        off = np.abs(np.einsum("ni,ni->n", offset, self._model.normals[nearest]))
        beside = 2.0 * float(np.median(self._near.query(self._some[:300], k=2)[0][:, 1]))
        off = np.where(np.asarray(away) < max(CLOSE, beside), off, away)  # to the surface between its points
        best = np.sort(off)[: max(1, int(TRIMMED * len(off)))]
        bad, drawn = (each[0] for each in self._refute(to_model[None], self._some))
        shown = lengths(drawn - self._some) < OFF
        pose = np.asarray(np.linalg.inv(to_model), dtype=np.float64)
        pose[:3, 3] -= pose[:3, :3] @ self._middle
        return ModelFit(
            self._model.name,
            pose,
            residual=float(np.sqrt(np.mean(np.square(best)))),
            inliers=float((off < CLOSE).mean()),
            visible=float(shown.mean()),
            seen_through=float(bad.sum() / max((bad | shown).sum(), 1)),
            ambiguity=ambiguity,
            seen=self._seen,
        )

    def _nearest(self, places: FloatArray, reach: float) -> tuple[FloatArray, IntArray]:
        """(K, n) distances [m] and numbers of the model's points nearest to places (K, n, 3).

        Where none is within reach the distance is infinite, and the number any.
        """
        away, nearest = self._near.query(places.reshape(-1, 3), distance_upper_bound=reach)
        shape = places.shape[:2]
        return np.asarray(away).reshape(shape), np.asarray(nearest).reshape(shape) % len(self._points)

    def _refute(self, to_model: FloatArray, points: FloatArray) -> tuple[BoolArray, FloatArray]:
        """Which of the model's points cannot be where poses put them, and the seen points nearest to each."""
        there = _points_at(np.asarray(np.linalg.inv(to_model), dtype=np.float64), points)
        flat = there.reshape(-1, 3)
        nearest = self._seen[self._near_seen.query(flat)[1]].reshape(there.shape)
        turned = nearest @ to_model[:, :3, :3].transpose(0, 2, 1) + to_model[:, None, :3, 3]
        return self._excluded(flat).reshape(there.shape[:2]), turned


def _points_at(poses: FloatArray, points: FloatArray) -> FloatArray:
    """(K, n, 3) points (n, 3) at each of some poses (K, 4, 4)."""
    return points @ poses[:, :3, :3].transpose(0, 2, 1) + poses[:, None, :3, 3]


def _equations(
    points: FloatArray, ways: FloatArray, offset: FloatArray, weights: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Linearise the gaps along ways (K, n, d, 3) by a small turn and shift of points (K, n, 3)."""
    turning = np.cross(points[..., None, :], ways)
    scale = np.sqrt(weights)[..., None]
    rows = scale * np.concatenate([turning, ways], axis=-1)
    left = scale[..., 0] * np.einsum("kndi,kni->knd", ways, offset)
    return rows.reshape(len(points), -1, 6), left.reshape(len(points), -1)


def _orientations(count: int) -> FloatArray:
    """(count, 3, 3) rotations spread evenly: super-Fibonacci spirals (Alexa, CVPR 2022)."""
    share = (np.arange(count) + 0.5) / count
    one, other = (
        2.0 * np.pi * count * share / np.sqrt(2.0),
        2.0 * np.pi * count * share / 1.533751168755204288118041,
    )
    near, far = np.sqrt(share), np.sqrt(1.0 - share)
    quaternions = np.stack(
        [near * np.sin(one), near * np.cos(one), far * np.sin(other), far * np.cos(other)], axis=1
    )
    return np.asarray(Rotation.from_quat(quaternions).as_matrix())
