"""Whether the pictures of several cameras fit each other at the poses that they are said to have."""

from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import combinations, product

import numpy as np
from scipy.spatial.transform import Rotation

from topple.topology.base.arrays import FloatArray, bounds
from topple.topology.base.errors import InvalidInput
from topple.topology.base.tolerances import FARTHEST_DEPTH
from topple.topology.views.image import DepthImage
from topple.topology.views.tolerances import (
    AGREEING,
    FAR_APART,
    FEWEST_COMMON,
    ITERATIONS,
    LEAST_SINGULAR,
    MOST_CONFLICT,
    MOST_SHIFT,
    MOST_TURN,
    POSE_STEP,
    PROBES,
    SAME_SURFACE,
    SEARCH_STEPS,
)

_OPENGL = np.diag([1.0, -1.0, -1.0, 1.0])


@dataclass(frozen=True, eq=False)
class _Fit:
    """How a view lies to another one: where it fits best, and how well it does there.

    Attributes:
        shift: By how far its camera is then from where it is said to be, less what the turn explains [m].
        turn: By how much it is turned [rad].
        common: Points in sight of two cameras that both measured.
        conflict: Share of them that one camera looked through.
        apart: Whether hardly any are, and all objects that they share are elsewhere in the other one.
    """

    shift: float
    turn: float
    common: int
    conflict: float
    apart: bool

    def why_not(self) -> str | None:
        """Say why two pictures do not agree; None where they do, or nothing can be told."""
        if self.common < FEWEST_COMMON:
            return f"what they share is more than {FAR_APART:g} m apart" if self.apart else None
        if self.conflict > MOST_CONFLICT:
            return f"{self.conflict:.0%} of what they share lies where another camera looked through"
        if self.turn > MOST_TURN:
            return f"one would fit turned by {np.degrees(self.turn):.0f} degrees"
        return f"one would fit {100 * self.shift:.0f} cm aside" if self.shift > MOST_SHIFT else None


def check_views(images: Sequence[DepthImage], fixed: Collection[str] = ()) -> None:
    """Refuse pictures that disagree by more than noise and what calibrations are off by.

    Args:
        images: Pictures of one moment, each at its pose.
        fixed: Names of what never moves: tables are flat, and tell little.

    Raises:
        InvalidInput: Two disagree; names them, by how much, and what makes them agree.
    """
    probes = [_probes(image, fixed) for image in images] if len(images) > 1 else []
    for first, second in combinations(range(1, len(images) + 1), 2):
        one, other = images[first - 1], images[second - 1]
        why = _fit(one, other, probes[first - 1], probes[second - 1], fixed).why_not()
        if why is not None:
            known = (
                (said, _fit(a, b, _probes(a, fixed), _probes(b, fixed), fixed))
                for said, (a, b) in _cures(one, other)
            )
            fits = (said for said, fit in known if fit.common >= FEWEST_COMMON and fit.why_not() is None)
            cure = next(fits, "give each its own pose_camera_to_world, or topple scene (merge_views)")
            raise InvalidInput(f"views {first} and {second} disagree: {why}; {cure.format(first, second)}")


def _cures(one: DepthImage, other: DepthImage) -> Iterator[tuple[str, tuple[DepthImage, DepthImage]]]:
    """Try the usual mistakes in poses: for each, its cure in words and the two pictures with it."""
    a, b = one.pose_camera_to_world, other.pose_camera_to_world
    inverted = (np.asarray(np.linalg.inv(a), np.float64), np.asarray(np.linalg.inv(b), np.float64))
    for said, (c, d) in {
        "in OpenGL axes: give pose @ diag(1, -1, -1, 1)": (a @ _OPENGL, b @ _OPENGL),
        "inverted, world to camera: give numpy.linalg.inv(pose)": inverted,
        "inverted, in OpenGL axes: give inv(pose) @ diag(1, -1, -1, 1)": tuple(x @ _OPENGL for x in inverted),
    }.items():
        yield f"they agree if both poses are {said}", (_at(one, c), _at(other, d))
        yield f"they agree if the pose of view {{1}} is {said}", (one, _at(other, d))
        yield f"they agree if the pose of view {{0}} is {said}", (_at(one, c), other)
    yield "they agree if their poses are swapped", (_at(one, b), _at(other, a))


def _at(image: DepthImage, pose: FloatArray) -> DepthImage:
    return replace(image, pose_camera_to_world=pose)


def _fit(
    other: DepthImage, view: DepthImage, theirs: FloatArray, mine: FloatArray, fixed: Collection[str]
) -> _Fit:
    """How a picture lies to another one."""
    eye = view.viewpoint

    def past(move: FloatArray, around: bool = False) -> FloatArray:
        turn = np.asarray(Rotation.from_rotvec(move[3:]).as_matrix())
        there = other.depth_past((mine - eye) @ turn.T + eye + move[:3], around)
        back = view.depth_past((theirs - eye - move[:3]) @ turn + eye, around)
        return np.clip(np.concatenate([there, back]), -FARTHEST_DEPTH, FARTHEST_DEPTH)

    def agreement(move: FloatArray) -> float:
        off = past(move) / SAME_SURFACE
        return float(np.maximum(1.0 - np.square(off), 0.0).sum()) - 2.0 * int((off > 1.0).sum())

    best = np.zeros(6)
    each = past(best)
    found = each[each >= -SAME_SURFACE]  # what is hidden tells nothing
    if len(found) < FEWEST_COMMON or (found <= SAME_SURFACE).mean() < AGREEING:
        ways = np.array(sorted(product(range(-SEARCH_STEPS, SEARCH_STEPS + 1), repeat=3), key=np.linalg.norm))
        best = max(np.pad(SAME_SURFACE * ways, ((0, 0), (0, 3))), key=agreement)
        for _ in range(ITERATIONS):  # of Gauss and Newton, by differences
            each = past(best)
            steps = POSE_STEP * np.eye(6)
            slopes = np.stack([past(best + step) - past(best - step) for step in steps], axis=1) / 2.0
            near = (np.abs(each) < SAME_SURFACE) & (np.abs(slopes) < SAME_SURFACE).all(axis=1)
            if near.sum() >= FEWEST_COMMON:
                best = best - POSE_STEP * np.linalg.lstsq(slopes[near], each[near], rcond=LEAST_SINGULAR)[0]
    each, loose = past(best), past(best, around=True)
    fit, through = int((np.abs(each) <= SAME_SURFACE).sum()), int((loose > SAME_SURFACE).sum())
    turn, common = float(np.linalg.norm(best[3:])), fit + through
    explained = turn * float(np.linalg.norm(mine.mean(axis=0) - eye))
    apart = common < FEWEST_COMMON and _apart(other, view, fixed)
    return _Fit(float(np.linalg.norm(best[:3])) - explained, turn, common, through / max(common, 1), apart)


def _probes(image: DepthImage, fixed: Collection[str]) -> FloatArray:
    """Some points (N, 3) of a picture [m], the same ones each time: mostly of what moves."""
    names = {number: image.name_of(number) for number in np.unique(image.label).tolist() if number}
    moves = np.isin(image.label, [number for number, name in names.items() if name not in fixed])
    rng, found = np.random.default_rng(0), list[FloatArray]()
    for mask, count in ((moves, PROBES), (~moves, PROBES // 2)):
        places = np.flatnonzero(mask & (image.depth > 0))
        rows, columns = np.unravel_index(rng.permutation(places)[:count], image.depth.shape)
        found.append(image.lifted(rows, columns))
    return np.concatenate(found)


def _apart(one: DepthImage, other: DepthImage, fixed: Collection[str]) -> bool:
    """Whether all that two pictures show of what moves is elsewhere in one than in the other."""
    clouds, known = one.clouds(), other.clouds()
    both = [
        (bounds(clouds[name]), bounds(known[name])) for name in clouds if name in known and name not in fixed
    ]
    return bool(both) and all((np.maximum(a[0] - b[1], b[0] - a[1]) > FAR_APART).any() for a, b in both)
