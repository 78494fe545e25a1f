"""Masks as segmentations give them: shifted, dilated, eroded, ragged; missing, split, merged, on nothing."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np
from scipy import ndimage

from topple.robots.world.camera import roughen
from topple.topology.base.arrays import BoolArray, IntArray

INACCURATE = tuple(
    f"{how} {pixels}" for how, pixels in product(("shifted", "dilated", "eroded", "ragged"), (1, 2, 3))
)
"""How masks are off, and by how many pixels."""

WRONG = ("missing", "split", "merged", "ghost")
"""How one mask in ten is wrong in kind."""

FEWEST = 60  # pixels of a mask that is made wrong in kind: fewer are hidden all but a sliver
GHOST = 8  # [pixel] radius of a mask on nothing: an object of 3 cm


@dataclass(frozen=True, eq=False)
class MaskFaults:
    """What is wrong with the masks of a scene.

    Attributes:
        without: Objects that no mask names.
        wrong: Masks that are wrong in kind.
    """

    without: tuple[str, ...] = ()
    wrong: tuple[str, ...] = ()


NO_FAULTS = MaskFaults()
"""Masks right in kind; pixels at their borders may be off."""


def corrupt(
    label: IntArray, names: Sequence[str], how: str, support: str, rng: np.random.Generator
) -> tuple[IntArray, list[str], MaskFaults]:
    """Corrupt the masks of a picture.

    Args:
        label: (H, W) numbers of objects, k + 1 for the k-th name.
        names: Of the objects.
        how: One of `INACCURATE` or `WRONG`.
        support: Name of what carries all: its mask is what the others leave.
        rng: Of directions, and of which masks are wrong.

    Returns:
        The masks, the names with those of masks split off or on nothing, and what is wrong.
    """
    what, _, pixels = how.partition(" ")
    ground = list(names).index(support) + 1 if support in names else 0
    if pixels:
        return _inaccurate(label, what, int(pixels), ground, rng), list(names), NO_FAULTS
    present, counts = np.unique(label, return_counts=True)
    there = present[(counts >= FEWEST) & (present > 0) & (present != ground)]
    chosen = [int(number) for number in rng.permutation(there)[: max(1, round(len(there) / 10))]]
    found, given, wrong = label.copy(), list(names), list[str]()
    for number in chosen:
        name, mask = given[number - 1], label == number
        if what == "missing":
            found[mask] = 0
        elif what == "merged":
            other = _neighbour(label, number, ground)
            if other is not None:
                found[mask] = other
                wrong.append(given[other - 1])
        else:
            given.append(f"{len(given) + 1}")
            found[mask & _half(mask, rng) if what == "split" else _disc(label == ground, rng)] = len(given)
            wrong += [name, given[-1]] if what == "split" else [given[-1]]
    without = [given[number - 1] for number in chosen] if what == "missing" else []
    return found, given, MaskFaults(tuple(without), tuple(wrong))


def _inaccurate(label: IntArray, what: str, pixels: int, ground: int, rng: np.random.Generator) -> IntArray:
    """Masks off by pixels, at the cost of what is behind or beside."""
    if what == "ragged":
        return roughen(label, float(pixels), rng)
    if what == "shifted":
        return np.roll(label, rng.choice([-pixels, pixels]), rng.integers(2))
    size = 2 * pixels + 1
    objects = np.where(label == ground, 0, label)
    if what == "dilated":
        grown = ndimage.grey_dilation(objects, size=size)
        return np.where(grown > 0, grown, label)
    borders = ndimage.grey_erosion(label, size=size) != ndimage.grey_dilation(label, size=size)
    return np.where((objects > 0) & borders, ground, label)


def _half(mask: BoolArray, rng: np.random.Generator) -> BoolArray:
    """(H, W) one side of a line through the middle of a mask."""
    rows, columns = np.nonzero(mask)
    down, right = np.indices(mask.shape)
    angle = rng.uniform(0, 2 * np.pi)
    return (down - rows.mean()) * np.sin(angle) + (right - columns.mean()) * np.cos(angle) > 0


def _disc(free: BoolArray, rng: np.random.Generator) -> BoolArray:
    """(H, W) a round mask anywhere where it is free all around."""
    down, right = np.indices((2 * GHOST + 1,) * 2) - GHOST
    disc = np.hypot(down, right) <= GHOST
    places = np.argwhere(ndimage.binary_erosion(free, disc))
    found = np.zeros(free.shape, dtype=bool)
    if len(places):
        row, column = rng.choice(places)
        found[row - GHOST : row + GHOST + 1, column - GHOST : column + GHOST + 1] = disc
    return found


def _neighbour(label: IntArray, number: int, ground: int) -> int | None:
    """Of which other object most pixels are beside a mask."""
    beside = label[ndimage.binary_dilation(label == number) & (label != number)]
    others, counts = np.unique(beside[(beside > 0) & (beside != ground)], return_counts=True)
    return int(others[counts.argmax()]) if len(others) else None
