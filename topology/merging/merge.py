"""`merge_views`: one scene of several views whose poses are only roughly known."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike
from scipy.optimize import linear_sum_assignment

from topple.topology.base.arguments import checked_arguments
from topple.topology.base.arrays import FloatArray, IntArray, bounds
from topple.topology.base.errors import InvalidInput
from topple.topology.base.values import free_name
from topple.topology.geometry.plane import TABLE, table_by_name
from topple.topology.geometry.thin import cell_keys
from topple.topology.kernels.neighbours import PointTree
from topple.topology.merging.ground import Ground, ground_of
from topple.topology.merging.register import Registration, register
from topple.topology.merging.segments import outliers, segment_cloud
from topple.topology.merging.tolerances import TOLERANCES
from topple.topology.scene.scene import Scene
from topple.topology.views.image import DepthImage

FORMAT, FORMAT_VERSION = "topple.scene", 1


@dataclass(frozen=True, eq=False)
class MergedViews:
    """A scene made of several views, and how far each step can be trusted.

    Attributes:
        scene: The objects and the ground, in the frame of the first view.
        views: Names of the views.
        registrations: How each view but the first was laid over those before it.
        grounds: The ground of each view.
        outliers: Share of what stands on the ground that was dropped as outliers.
        masked: Whether the objects are those of masks; else they were cut out by their shape.
        loose: Share of what stands on the ground that is in no object.

    Examples:
        >>> with new_world() as world:
        ...     world.add(Body.of("table", [8 * corners * [1, 1, 0] - [0.4, 0.4, 0]]))
        ...     world.add(Body.of("crate", [corners]))
        ...     eyes, rng = around((0, 0, 0)), np.random.default_rng(0)
        ...     images = Observer(world, eyes, rng, ("table",)).look().images
        >>> merged = merge_views(images, ("front", "left", "right"))
        >>> merged.views, merged.masked
        (('front', 'left', 'right'), True)
    """

    scene: Scene
    views: tuple[str, ...]
    registrations: tuple[Registration, ...]
    grounds: tuple[Ground, ...]
    outliers: float
    masked: bool
    loose: float

    def to_json(self) -> dict[str, Any]:
        """The object that `topple scene --json` prints."""
        poses = [image.pose_camera_to_world.tolist() for image in self.scene.images]
        fits: list[Registration | None] = [None, *self.registrations]
        return {
            "format": FORMAT,
            "format_version": FORMAT_VERSION,
            "views": [
                {
                    "view": name,
                    "pose_camera_to_world": pose,
                    "registration": None if fit is None else _fit_json(fit),
                    "ground": {"share": ground.share, "residual": ground.residual},
                }
                for name, pose, fit, ground in zip(self.views, poses, fits, self.grounds, strict=True)
            ],
            "outliers": self.outliers,
            "masked": self.masked,
            "loose": self.loose,
            "objects": {name: len(cloud) for name, cloud in self.scene.clouds.items()},
            "fixed": sorted(self.scene.fixed),
            "assumptions": list(self.scene.assumptions),
        }


def _fit_json(fit: Registration) -> dict[str, float]:
    return {
        "shift": fit.shift,
        "turn": fit.turn,
        "common": fit.common,
        "residual": fit.residual,
        "conflict": fit.conflict,
    }


@checked_arguments
def merge_views(
    images: Sequence[DepthImage],
    names: Sequence[str] = (),
    *,
    up: ArrayLike | None = None,
    same_labels: bool = False,
) -> MergedViews:
    """Register views, find the ground, drop outliers, and tell the objects apart.

    Args:
        images: Two views or more of the same moment, at poses that are off by a few centimetres and degrees;
            labels 0 everywhere where there are no masks.
        names: Of the views, for messages.
        up: Direction (3,) against gravity in the frame of the first view; the ground's normal where None.
        same_labels: Whether a label means the same object in every view; else labels of different views are
            matched by the surface they share, and called as in the first view that shows it.

    Returns:
        The scene, whose table is the fixed object "table", and the residual of every step.

    Raises:
        InvalidInput: A step is not to be trusted; says which, by how much, and what may help.
        NotInstalled: small_gicp is missing.

    Examples:
        >>> with new_world() as world:
        ...     world.add(Body.of("table", [8 * corners * [1, 1, 0] - [0.4, 0.4, 0]]))
        ...     world.add(Body.of("crate", [corners]))
        ...     eyes, rng = around((0, 0, 0)), np.random.default_rng(0)
        ...     images = Observer(world, eyes, rng, ("table",)).look().images
        >>> merge_views(images, ("front", "left", "right")).scene.movable
        ('crate',)
    """
    views = tuple(names) or tuple(f"view {number}" for number in range(1, len(images) + 1))
    if len(images) < 2 or len(views) != len(images):
        raise InvalidInput(
            f"{len(images)} views and {len(views)} names: expected two views or more, each named"
        )
    masked = [bool((image.label > 0).any()) for image in images]
    if any(masked) != all(masked):
        without = ", ".join(name for name, has in zip(views, masked, strict=True) if not has)
        raise InvalidInput(f"{without} has no mask and others have one: give every view a mask, or none")
    grounds = [ground_of(image, name) for image, name in zip(images, views, strict=True)]
    placed, fits = register(images, grounds, views)
    cells = _Cells.of(placed, grounds[0])
    stray = outliers(cells.points)
    _check(float(stray.mean()), TOLERANCES.outliers, "of what stands on the ground are outliers")
    if all(masked):
        objects, called = _owner(placed, cells, same_labels)
    else:
        objects = np.full(len(cells.points), -1)
        objects[~stray] = segment_cloud(cells.points[~stray], cells.eyes[~stray])
        called = {number: f"object_{number + 1}" for number in np.unique(objects[objects >= 0]).tolist()}
        objects = objects[cells.cell]
    objects[stray[cells.cell]] = -1
    _without_crumbs(objects, called, cells)
    loose = float((objects < 0).mean())
    if not all(masked):
        _check(loose, TOLERANCES.crumbs, "of what stands on the ground are in no object")
    scene = _scene(placed, cells, objects, called, grounds[0], up, all(masked))
    return MergedViews(scene, views, fits, tuple(grounds), float(stray.mean()), all(masked), loose)


def _check(share: float, most: float, what: str) -> None:
    if share > most:
        raise InvalidInput(
            f"{share:.0%} {what}, at most {most:.0%} allowed: give masks, or views with less noise"
        )


@dataclass(frozen=True, eq=False)
class _Cells:
    """Every pixel that stands on the ground, and the cells of a grid that they fall into.

    Attributes:
        rows: Per view, rows and columns of its pixels.
        cell: (P,) cell of each pixel, all views one after the other.
        points: (C, 3) mean of each cell's points [m].
        eyes: (C, 3) from where a camera saw it [m].
    """

    rows: tuple[tuple[IntArray, IntArray], ...]
    cell: IntArray
    points: FloatArray
    eyes: FloatArray

    @staticmethod
    def of(images: Sequence[DepthImage], ground: Ground) -> "_Cells":
        rows: list[tuple[IntArray, IntArray]] = []
        clouds: list[FloatArray] = []
        middle = np.median(ground.standing, axis=0)
        for image in images:
            points = image.points()
            height = points @ ground.plane[:3] + ground.plane[3]
            near = np.linalg.norm(points - middle, axis=2) < TOLERANCES.around
            if (image.label > 0).any():
                # a spoon on the table is as flat as the noise, and its mask knows better
                standing = near & (image.label > 0)
                for label in _ground_labels(image, height):
                    standing &= image.label != label
            else:
                standing = near & (height > TOLERANCES.ground) & (height < TOLERANCES.highest)
            places = np.argwhere(standing)
            rows.append((places[:, 0], places[:, 1]))
            clouds.append(points[standing])
        every = np.concatenate(clouds)
        eyes = np.repeat([image.viewpoint for image in images], [len(cloud) for cloud in clouds], axis=0)
        _, first, cell, count = np.unique(
            cell_keys(every, *bounds(every), TOLERANCES.cell),
            return_index=True, return_inverse=True, return_counts=True,
        )  # fmt: skip
        sums = np.stack([np.bincount(cell, weights=every[:, k]) for k in range(3)], axis=1)
        return _Cells(tuple(rows), cell, sums / count[:, None], eyes[first])

    def of_views(self) -> list[slice]:
        """The pixels of each view among those of all."""
        ends = np.cumsum([len(rows) for rows, _ in self.rows])
        return [slice(int(end) - len(rows), int(end)) for end, (rows, _) in zip(ends, self.rows, strict=True)]


def _ground_labels(image: DepthImage, height: FloatArray) -> list[int]:
    """Labels of the ground: called so, or in its plane and larger than what is taken from it."""
    found: list[int] = []
    for label in np.unique(image.label[image.label > 0]).tolist():
        heights = height[(image.label == label) & (image.depth > 0)]
        flat = len(heights) and float((np.abs(heights) <= TOLERANCES.ground).mean()) > TOLERANCES.flat
        if table_by_name([image.name_of(label)]) or (
            flat and len(heights) > TOLERANCES.wide * image.depth.size
        ):
            found.append(label)
    return found


def _owner(images: Sequence[DepthImage], cells: _Cells, same_labels: bool) -> tuple[IntArray, dict[int, str]]:
    """Which object each pixel is of, by the masks; labels of different views are matched."""
    objects = np.full(len(cells.cell), -1, dtype=np.int64)
    called: dict[int, str] = {}
    for image, (rows, columns), part in zip(images, cells.rows, cells.of_views(), strict=True):
        labels = image.label[rows, columns]
        own = {int(label): image.name_of(int(label)) for label in np.unique(labels[labels > 0])}
        known = {name: number for number, name in called.items()}
        if same_labels or not called:
            meant = {label: known.get(name, -1) for label, name in own.items()}
        else:
            meant = _match_labels(cells, objects, labels, part, own)
        taken = set(called.values())
        for label, name in own.items():
            if meant.get(label, -1) < 0:
                meant[label] = len(called)
                called[len(called)] = free_name(name, taken)
                taken.add(called[meant[label]])
        found = np.full(len(labels), -1, dtype=np.int64)
        for label, number in meant.items():
            found[labels == label] = number
        objects[part] = found
    return objects, called


def _without_crumbs(objects: IntArray, called: dict[int, str], cells: _Cells) -> None:
    """Drop what is too small to be an object."""
    for number in list(called):
        mine = objects == number
        if len(np.unique(cells.cell[mine])) < TOLERANCES.smallest:
            objects[mine] = -1
            del called[number]


def _match_labels(
    cells: _Cells, objects: IntArray, labels: IntArray, part: slice, own: Mapping[int, str]
) -> dict[int, int]:
    """The object that each label of a view is, by the share of its surface that was seen before."""
    before = objects[: part.start]
    known = np.unique(before[before >= 0])
    trees = [PointTree(cells.points[np.unique(cells.cell[: part.start][before == k])]) for k in known]
    share = np.zeros((len(own), len(known)))
    for row, label in enumerate(own):
        seen = cells.points[np.unique(cells.cell[part][labels == label])]
        for column, tree in enumerate(trees):
            near = tree.query(seen, distance_upper_bound=TOLERANCES.link)[0]
            share[row, column] = np.isfinite(near).sum() / min(len(seen), len(tree.data))
    pairs = zip(*linear_sum_assignment(-share), strict=True)
    names = list(own)
    return {names[r]: int(known[c]) for r, c in pairs if share[r, c] >= TOLERANCES.shared}


def _scene(
    images: Sequence[DepthImage],
    cells: _Cells,
    objects: IntArray,
    called: Mapping[int, str],
    ground: Ground,
    up: ArrayLike | None,
    masked: bool,
) -> Scene:
    """The scene of relabelled images: label k + 2 for object k, 1 for the ground."""
    relabelled: list[DepthImage] = []
    names = {1: TABLE, **{number + 2: name for number, name in called.items()}}
    middle = np.median(ground.standing, axis=0)
    for image, (rows, columns), part in zip(images, cells.rows, cells.of_views(), strict=True):
        points = image.points()
        on = np.abs(points @ ground.plane[:3] + ground.plane[3]) <= TOLERANCES.ground
        on &= (image.label == 0) | np.isin(
            image.label, _ground_labels(image, points @ ground.plane[:3] + ground.plane[3])
        )
        label = (on & (np.linalg.norm(points - middle, axis=2) < TOLERANCES.around)).astype(np.int64)
        label[rows, columns] = np.where(objects[part] < 0, 0, objects[part] + 2)
        relabelled.append(replace(image, label=label, names=names))
    found = Scene.from_images(relabelled, fixed=[TABLE], up=ground.up if up is None else up, unnamed=False)
    if masked:  # outliers, which a mask named, are no matter
        found = found.with_unnamed(np.concatenate([image.background() for image in images]))
    notes = ["the table is the plane that holds most of each view"]
    notes += ["up is the normal of that plane"] if up is None else []
    if not masked:
        notes.append("there were no masks: things that touch without a bend inwards are one object")
    return Scene(
        found.clouds,
        found.fixed,
        found.up,
        found.viewpoints,
        found.images,
        assumptions=[*found.assumptions, *notes],
        matter=found.matter,
    )
