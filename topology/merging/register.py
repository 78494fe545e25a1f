"""Where cameras truly were: views laid over each other, each with how well it fits.

A table is flat, and registration of whole clouds slides along it. So the grounds are laid into each other;
then what stands there is moved about in their plane until most of it is where the other cameras saw a surface
and least of it is where they looked through; GICP does the rest, where that is better still.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import product
from types import ModuleType

import numpy as np
from scipy.spatial.transform import Rotation

from topple.topology.base.arrays import FloatArray
from topple.topology.base.errors import InvalidInput, NotInstalled
from topple.topology.geometry.axes import perpendiculars
from topple.topology.geometry.rigid import move_points, turned_to
from topple.topology.geometry.thin import voxel_means
from topple.topology.merging.ground import Ground
from topple.topology.merging.tolerances import MISPLACED, TOLERANCES
from topple.topology.views.image import DepthImage


@dataclass(frozen=True, eq=False)
class Registration:
    """How a view was laid over those before it.

    Attributes:
        pose_given_to_found: (4, 4) what its given pose was moved by, in the frame of the first view.
        shift: By how far that moved the middle of what it shows [m].
        turn: By how much it turned it [rad].
        common: Points that it has in common with the others, looked up both ways.
        residual: Root mean square of their distances [m].
        conflict: Share of the points in sight of both that one of them looked through.
    """

    pose_given_to_found: FloatArray
    shift: float
    turn: float
    common: int
    residual: float
    conflict: float

    def why_poor(self) -> str | None:
        """Say why it cannot be trusted; None where it can."""
        if self.common < TOLERANCES.fewest:
            return f"{self.common} points in common, at least {TOLERANCES.fewest} needed"
        if self.conflict > TOLERANCES.conflict:
            return (
                f"{self.conflict:.0%} of its points are where another camera looked through, at most "
                f"{TOLERANCES.conflict:.0%} allowed"
            )
        if self.residual > TOLERANCES.residual:
            return (
                f"residual {1e3 * self.residual:.1f} mm, at most {1e3 * TOLERANCES.residual:.1f} mm allowed"
            )
        return None


@dataclass(frozen=True, eq=False)
class _View:
    """A view as it is compared with others.

    Attributes:
        image: What its camera saw, at the pose that is believed.
        standing: (N, 3) thinned points of what stands there [m].
        ground: (M, 3) thinned points of the ground [m].
    """

    image: DepthImage
    standing: FloatArray
    ground: FloatArray

    def move(self, pose: FloatArray) -> "_View":
        """The view at another place: (4, 4) from where it is believed to be."""
        image = replace(self.image, pose_camera_to_world=pose @ self.image.pose_camera_to_world)
        return _View(image, move_points(self.standing, pose), move_points(self.ground, pose))

    def few(self) -> FloatArray:
        """Some of its standing points, the same ones each time."""
        rng = np.random.default_rng(0)
        return self.standing[rng.permutation(len(self.standing))[: TOLERANCES.probes]]


def register(
    images: Sequence[DepthImage], grounds: Sequence[Ground], names: Sequence[str]
) -> tuple[tuple[DepthImage, ...], tuple[Registration, ...]]:
    """Correct the poses of all cameras but the first.

    Args:
        images: The views, at poses that are off by no more than `TOLERANCES.reach` and `.turn`.
        grounds: The ground of each.
        names: Of the views, for messages.

    Returns:
        The views at corrected poses, in the frame of the first; and how each of them but the first fits.

    Raises:
        InvalidInput: A view does not fit: its residual and what may help.
        NotInstalled: small_gicp is missing.
    """
    gicp = _small_gicp()
    views = [
        _View(image, voxel_means(g.standing, TOLERANCES.fine), voxel_means(g.points, TOLERANCES.coarse))
        for image, g in zip(images, grounds, strict=True)
    ]
    placed, found = [views[0]], list[Registration]()
    for view, ground, name in zip(views[1:], grounds[1:], names[1:], strict=True):
        level = _level_onto(ground, grounds[0], view.standing.mean(axis=0), name)
        pose = _refine(gicp, placed, view, _search_in_plane(placed, view, level, grounds[0].up))
        fit = _fit(placed, view, pose)
        if (why := fit.why_poor()) is not None:
            raise InvalidInput(
                f"{name} does not fit the views before it: {why}; give a pose_camera_to_world closer than "
                f"{100 * TOLERANCES.reach:.0f} cm, or a view that shares more with the others"
            )
        placed.append(view.move(pose))
        found.append(fit)
    return tuple(view.image for view in placed), tuple(found)


def _small_gicp() -> ModuleType:
    try:
        import small_gicp
    except ModuleNotFoundError as error:
        raise NotInstalled("registering views needs small_gicp", "views") from error
    return small_gicp


def _level_onto(ground: Ground, wanted: Ground, about: FloatArray, name: str) -> FloatArray:
    """The pose (4, 4) that lays a ground into another one, turning about a point (3,) [m]."""
    axis, cosine = np.cross(ground.up, wanted.up), float(ground.up @ wanted.up)
    angle = float(np.arctan2(np.linalg.norm(axis), cosine))
    if angle > TOLERANCES.tilt:
        raise InvalidInput(
            f"{name}: its ground is tilted by {np.degrees(angle):.0f} degrees against the first view's, at "
            f"most {np.degrees(TOLERANCES.tilt):.0f} expected: give its pose_camera_to_world"
        )
    pose = turned_to(_rotation(axis * (angle / max(float(np.linalg.norm(axis)), 1e-12))), about, about)
    foot = about - (float(about @ ground.up) + ground.plane[3]) * ground.up
    height = float(move_points(foot[None], pose)[0] @ wanted.up) + wanted.plane[3]
    pose[:3, 3] -= height * wanted.up
    return pose


def _search_in_plane(placed: Sequence[_View], view: _View, level: FloatArray, up: FloatArray) -> FloatArray:
    """The best pose (4, 4) among those that move a levelled view in its ground's plane."""
    across = perpendiculars(up)
    middle = move_points(view.standing.mean(axis=0), level)

    def pose(place: tuple[float, ...]) -> FloatArray:
        moved = turned_to(_rotation(place[2] * up), middle, middle)
        moved[:3, 3] += place[0] * across[0] + place[1] * across[1]
        return moved @ level

    probes, targets = view.few(), [other.few() for other in placed]

    def agreement(place: tuple[float, ...], same: float, through: float) -> float:
        moved = pose(place)
        past = [other.image.depth_past(move_points(probes, moved)) for other in placed]
        back = np.asarray(np.linalg.inv(moved), dtype=np.float64)
        past += [view.image.depth_past(move_points(points, back)) for points in targets]
        each = np.concatenate(past)
        fits = np.maximum(1.0 - np.square(each[np.isfinite(each)] / same), 0.0).sum()
        return float(fits) - MISPLACED * int((each > through).sum())

    best = (0.0, 0.0, 0.0)
    for step, angle, count, same, through in TOLERANCES.steps:
        around = range(-count, count + 1)
        tried = [
            (best[0] + i * step, best[1] + j * step, best[2] + k * angle)
            for i, j, k in product(around, repeat=3)
        ]
        best = max(tried, key=lambda place: agreement(place, same, through))
    return pose(best)


def _refine(gicp: ModuleType, placed: Sequence[_View], view: _View, pose: FloatArray) -> FloatArray:
    """The pose (4, 4) after GICP in all six directions; as it was where that fits less well."""
    target = np.concatenate([part for other in placed for part in (other.standing, other.ground)])
    source = move_points(np.concatenate([view.standing, view.ground]), pose)
    found = gicp.align(
        target,
        source,
        downsampling_resolution=TOLERANCES.fine,
        max_correspondence_distance=TOLERANCES.match,
        max_iterations=50,
        rotation_epsilon=1e-5,
        translation_epsilon=1e-5,
    )
    finer = np.asarray(found.T_target_source) @ pose
    before, after = _fit(placed, view, pose), _fit(placed, view, finer)
    better = after.conflict <= before.conflict and after.common >= before.common
    return finer if better else pose


def _fit(placed: Sequence[_View], view: _View, pose: FloatArray) -> Registration:
    """How well a view at a pose (4, 4) fits those that are placed."""
    moved = view.move(pose)
    ways = [(other.image, moved.standing) for other in placed]
    ways += [(moved.image, other.standing) for other in placed]
    each = np.concatenate([image.depth_past(points) for image, points in ways])
    same = each[np.abs(each) < TOLERANCES.same]
    past = np.concatenate([image.depth_past(points, around=True) for image, points in ways])
    through = int((past > TOLERANCES.through).sum())
    middle = view.standing.mean(axis=0)
    return Registration(
        pose_given_to_found=pose,
        shift=float(np.linalg.norm(move_points(middle[None], pose)[0] - middle)),
        turn=float(np.linalg.norm(Rotation.from_matrix(pose[:3, :3]).as_rotvec())),
        common=len(same),
        residual=float(np.sqrt(np.mean(np.square(same)))) if len(same) else float("inf"),
        conflict=through / max(len(same) + through, 1),
    )


def _rotation(turn: FloatArray) -> FloatArray:
    """(3, 3) of a rotation vector (3,) [rad]."""
    return np.asarray(Rotation.from_rotvec(turn).as_matrix())
