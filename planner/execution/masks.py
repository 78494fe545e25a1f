"""Masks that go by a wrong name, told from things that moved by what was there before."""

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
from scipy.optimize import linear_sum_assignment

from topple.planner.execution.associate import apart, middle
from topple.planner.execution.tolerances import AGAIN, ALIKE, MOVED, PIECE, SEAM, STAYED, SWAPPED
from topple.topology.base.arrays import FloatArray
from topple.topology.geometry.hull import Hull
from topple.topology.kernels.neighbours import PointTree
from topple.topology.scene.scene import Scene
from topple.topology.views.image import DepthImage


def name_faults(seen: Scene, expected: Scene) -> tuple[dict[str, str], dict[str, str]]:
    """Find masks that have each other's names, and objects whose mask is in pieces.

    Things that changed places are told from names that did by what is expected: it holds what the arm did.

    Args:
        seen: What is seen, by the names that masks came with.
        expected: What is remembered, where it should be by now.

    Returns:
        The names to put right, name -> what it should be; and what was wrong, in sentences by the right name.
    """
    swapped = _swapped_names(seen, expected)
    said = {
        right: f"the mask of {right} was named {name}: names are swapped" for name, right in swapped.items()
    }
    named = {swapped.get(name, name): cloud for name, cloud in seen.clouds.items()}
    pieces = _pieces(named, expected)
    for name, whole in pieces.items():
        said[whole] = f"the mask of {whole} is split: {name} is a piece of it"
    return swapped | pieces, said


def rename(image: DepthImage, names: Mapping[str, str]) -> DepthImage:
    """An image with other names; masks that come to share one are joined.

    Args:
        image: The image.
        names: Name -> another.
    """
    numbers: dict[str, int] = {}
    label = image.label
    for number, name in image.names.items():
        first = numbers.setdefault(names.get(name, name), number)
        if first != number:
            label = np.where(label == number, first, label)
    return replace(image, label=label, names={number: name for name, number in numbers.items()})


def _swapped_names(seen: Scene, expected: Scene) -> dict[str, str]:
    """Names of which each is seen where and as what another of them was."""
    moved = [
        name
        for name, cloud in seen.clouds.items()
        if name in expected.movable and np.linalg.norm(middle(cloud) - middle(expected.clouds[name])) > MOVED
    ]
    if len(moved) < 2:
        return {}
    costs = np.array([[apart(seen.clouds[a], expected.clouds[b]) for b in moved] for a in moved])
    rows, columns = linear_sum_assignment(costs)
    return {
        moved[i]: moved[j]
        for i, j in zip(rows, columns, strict=True)
        if i != j and costs[i, j] < min(STAYED, SWAPPED * costs[i, i])
    }


def _pieces(seen: Mapping[str, FloatArray], expected: Scene) -> dict[str, str]:
    """New names of what lies where the surface of a remembered object was seen, and the object's."""
    new = [name for name in seen if name not in expected.names]
    found: dict[str, str] = {}
    for name in new:
        for whole in expected.movable:
            if _is_piece(seen[name], [seen[whole]] if whole in seen else [], expected.clouds[whole]):
                found[name] = whole
                break
    return found


def _is_piece(piece: FloatArray, rest: Sequence[FloatArray], whole: FloatArray) -> bool:
    """Whether a cloud lies on a remembered one, and covers much of what was seen of it.

    Where something stood on it nothing was seen of it before: there it ends where its hull does. A thing that
    comes to light on another one stands out from that hull, or covers little that was seen of the other.
    """
    shift = middle(np.concatenate([piece, *rest])) - middle(whole)  # it was put down there, or nearly
    if np.linalg.norm(shift) > STAYED:
        return False
    there = whole + shift
    seen = PointTree(there).query(piece, distance_upper_bound=SEAM)[0] < SEAM
    at_its_end = np.abs(Hull.of(there).signed_distance(piece)) < SEAM
    on = (seen | at_its_end).mean()
    covered = (PointTree(piece).query(there, distance_upper_bound=SEAM)[0] < SEAM).mean()
    return bool(on > ALIKE and seen.mean() > AGAIN and covered > PIECE)
