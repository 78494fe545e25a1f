"""Which object seen now is which one remembered, where a segmentation keeps no names between looks."""

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import replace

import numpy as np
from scipy.optimize import linear_sum_assignment

from topple.planner.execution.tolerances import ELSEWHERE, GONE, LIKENESS, SEEN_THROUGH, SPACING, STAYED
from topple.topology.base.arrays import BoolArray, FloatArray
from topple.topology.geometry.thin import thinned
from topple.topology.kernels.neighbours import PointTree
from topple.topology.scene.scene import Scene
from topple.topology.views.image import DepthImage


def associate_names(
    images: Sequence[DepthImage], expected: Scene, rng: np.random.Generator
) -> tuple[DepthImage, ...]:
    """Name what images show by what is remembered, without regard to the names they come with.

    Args:
        images: Of one look; one object has one name in all of them. Names of what never moves are kept.
        expected: What is remembered, where it should be by now.
        rng: Shuffles the objects.

    Returns:
        The images with the names of `expected`. What is like nothing remembered is new and keeps its name,
        or, where that is taken by another object, gets a number behind it.
    """
    labels = sorted({name for image in images for name in image.names.values()} - expected.fixed)
    rng.shuffle(labels)
    pieces = [image.clouds() for image in images]
    clouds = {
        name: thinned(np.concatenate([piece[name] for piece in pieces if name in piece]), SPACING)
        for name in labels
        if any(name in piece for piece in pieces)
    }
    remembered = {name: thinned(expected.clouds[name], SPACING) for name in expected.movable}
    gone = [name for name, cloud in remembered.items() if seen_through(cloud, images).mean() > GONE]
    names = match_objects(clouds, remembered, gone)
    for label in labels:
        if label not in names:
            taken = {*expected.names, *names.values()}
            numbered = (f"{label} ({k})" for k in range(2, len(taken) + 3))
            names[label] = next(name for name in (label, *numbered) if name not in taken)
    return tuple(
        replace(image, names={k: names.get(name, name) for k, name in image.names.items()})
        for image in images
    )


def match_objects(
    seen: Mapping[str, FloatArray], remembered: Mapping[str, FloatArray], gone: Collection[str]
) -> dict[str, str]:
    """Match what is seen with what is remembered: first what stayed, then what lies elsewhere.

    Args:
        seen: Clouds (N, 3) in [m] by label.
        remembered: Clouds (N, 3) in [m] by name.
        gone: Names of which a camera sees through the place: only they can lie elsewhere, the others may be
            hidden where they were.

    Returns:
        Label -> name of what is matched, each name once.
    """
    names = _assign(seen, remembered, apart, STAYED)
    left = {label: cloud for label, cloud in seen.items() if label not in names}
    lost = {name: remembered[name] for name in gone if name not in names.values()}
    return names | _assign(left, lost, _unlike, ELSEWHERE)


def seen_through(cloud: FloatArray, images: Sequence[DepthImage]) -> BoolArray:
    """Which of (N, 3) points some camera sees something clearly behind."""
    return np.any([image.depth_past(cloud) > SEEN_THROUGH for image in images], axis=0)


def _assign(
    seen: Mapping[str, FloatArray],
    remembered: Mapping[str, FloatArray],
    cost: Callable[[FloatArray, FloatArray], float],
    most: float,
) -> dict[str, str]:
    """The cheapest one-to-one assignment (Hungarian method); a pair beyond `most` is none."""
    labels, names = list(seen), list(remembered)
    costs = np.array([[min(cost(seen[a], remembered[b]), most) for b in names] for a in labels])
    rows, columns = linear_sum_assignment(costs.reshape(len(labels), len(names)))
    return {labels[i]: names[j] for i, j in zip(rows, columns, strict=True) if costs[i, j] < most}


def middle(cloud: FloatArray) -> FloatArray:
    """(3,) centre of the box round a cloud (N, 3), in [m]: it does not hang on where the points are dense."""
    return (cloud.min(axis=0) + cloud.max(axis=0)) / 2.0


def apart(seen: FloatArray, remembered: FloatArray) -> float:
    """Distance between two clouds in [m]: the mean of the median ways from one to the other and back."""
    there, back = PointTree(remembered).query(seen)[0], PointTree(seen).query(remembered)[0]
    return float(np.median(there) + np.median(back)) / 2.0


def _unlike(seen: FloatArray, remembered: FloatArray) -> float:
    """How far apart two clouds are, and how unlike each other, in [m]."""
    way = np.linalg.norm(seen.mean(axis=0) - remembered.mean(axis=0))
    spread = [np.sqrt(np.linalg.eigvalsh(np.cov(cloud.T)).clip(0.0)) for cloud in (seen, remembered)]
    return float(way + LIKENESS * np.linalg.norm(spread[0] - spread[1]))
