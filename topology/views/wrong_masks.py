"""Masks that are wrong in kind, told by depth: level with what carries them, split, merged, or named twice.

Depth that is exact says nothing of what a mask should be called, but much of what cannot be one object, or
two. A surface that goes on over the border of two masks without a step or a crease is one object's, unless
two stand flush. A mask that a step or an inward crease cuts in two is of two objects, unless it is hollow: in
the picture a convex body in front ends in a convex line, and the near rim of a bowl does not.
"""

from collections import Counter
from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass
from itertools import combinations, permutations
from typing import TYPE_CHECKING

import numpy as np
from scipy import ndimage

from topple.topology.base.arrays import BoolArray, FloatArray, IntArray
from topple.topology.base.values import Word
from topple.topology.geometry.sides import beyond, sides_of
from topple.topology.kernels.continued import planes_around
from topple.topology.kernels.tolerances import AROUND, FAR, NEAREST, OFF
from topple.topology.views.borders import Picture
from topple.topology.views.tolerances import (
    CHORD,
    COLUMNS,
    CREASE,
    EVEN,
    FEWEST,
    FLUSH,
    HELD,
    INWARDS,
    MEETS,
    MOSTLY,
    PIECE,
    SEAM,
    STEP,
)

if TYPE_CHECKING:
    from topple.topology.views.image import DepthImage


class MaskFault(Word):
    """How a mask can be wrong."""

    LEVEL = "is level with what carries it: there may be no object; take the mask away"
    SPLIT = "lie on one smooth surface: one object in two masks? join them"
    MERGED = "goes over two pieces, with a step or an inward crease between: two objects in one mask? part it"
    DUPLICATE = "are one surface by what the cameras see: one object under two names? give it one"


@dataclass(frozen=True)
class WrongMask:
    """A mask, or two, of which depth says that it is none of an object.

    Attributes:
        fault: How.
        names: Names of the objects, sorted.
        trusted: Whether it is taken as it is all the same.
    """

    fault: MaskFault
    names: tuple[str, ...]
    trusted: bool = False

    @property
    def refuses(self) -> bool:
        """Whether what hangs on it is refused; the other kinds are said of true masks, too."""
        return not self.trusted and self.fault in (MaskFault.LEVEL, MaskFault.DUPLICATE)

    def __str__(self) -> str:
        """The sentence: which masks, what is wrong, and what to do."""
        which = " and ".join(repr(name) for name in self.names)
        return f"the mask{'s' * (len(self.names) > 1)} of {which} {self.fault}"


def wrong_masks(images: "Sequence[DepthImage]", fixed: Collection[str]) -> tuple[WrongMask, ...]:
    """Find masks that are wrong in kind.

    Args:
        images: Depth images of the same moment.
        fixed: Names of what never moves: such masks are not asked about, and others may be level with them.

    Returns:
        What most of the images that have such masks show, and what two images contradict each other in.
    """
    votes = Counter(wrong for image in images for wrong in _in_image(image, fixed))
    shown = [frozenset(image.pixels()) for image in images] if votes else []
    found = [
        wrong
        for wrong, count in votes.items()
        if 2 * count > sum(each.issuperset(wrong.names) for each in shown)
    ]
    for one, other in permutations(images, 2):
        found += _duplicates(one, other, fixed)
    return tuple(dict.fromkeys(found))


def _in_image(image: "DepthImage", fixed: Collection[str]) -> Iterator[WrongMask]:
    """Find wrong masks in a single image, in a window around all that can move."""
    depth, owner, asked = _thin_picture(image, fixed)
    label = np.where(np.isin(owner, asked), owner, np.minimum(owner, 0))
    rows, columns = (np.flatnonzero((label > 0).any(axis=axis)) for axis in (1, 0))
    if not asked:
        return
    window = tuple(slice(max(at[0] - FAR, 0), at[-1] + FAR) for at in (rows, columns))
    picture = Picture.of(depth[window], label[window], 0)
    for pair in _smooth(picture):
        names = tuple(sorted(image.name_of(number) for number in pair if number > 0))
        yield WrongMask(MaskFault.SPLIT if len(names) > 1 else MaskFault.LEVEL, names)
    for number in _merged_labels(picture):
        yield WrongMask(MaskFault.MERGED, (image.name_of(number),))


def _thin_picture(image: "DepthImage", fixed: Collection[str]) -> tuple[FloatArray, IntArray, list[int]]:
    """Depth [m] and owners of every so manieth pixel (H, W), and the labels among them of what can move."""
    every = _every(image)
    label = image.label if image.borders.moved == (0, 0) else image.borders.owner
    depth, owner = image.depth[::every, ::every], label[::every, ::every]
    there = np.unique(owner[::4, ::4]).tolist()  # a mask without a pixel of these is too small to tell
    return depth, owner, [number for number in there if number > 0 and image.name_of(number) not in fixed]


def _every(image: "DepthImage") -> int:
    return max(1, round(image.depth.shape[1] / COLUMNS))


def _smooth(picture: Picture) -> Iterator[list[int]]:
    """Pairs of labels whose surfaces go on over the border between them, for most of its length.

    On either side of it planes are fitted to patches of the mask there, and each is continued to the other.
    """
    apart, pairs, goes_on, steps = 2 * INWARDS + 1, list[IntArray](), list[BoolArray](), list[FloatArray]()
    for step, axis in ((picture.width, 1), (1, 2)):
        own, beside = picture.label[:-step], picture.label[step:]
        at = np.flatnonzero((own != beside) & (np.minimum(own, beside) >= 0))[::2]  # one tells for the next
        ends = np.stack([at - INWARDS * step, at + (INWARDS + 1) * step])
        both = np.stack([own[at], beside[at]])
        whole = (picture.surface[ends] == both).all(axis=0)
        here, there = (planes_around(picture, end) for end in ends[:, whole])
        metres = np.square(1.0 / np.maximum(np.maximum(here[0], there[0]), NEAREST))
        between = there[0] - here[0]
        off = (apart * np.stack([here[axis], there[axis]]) - between) * metres
        step_of = np.zeros(len(whole))
        step_of[whole] = np.where(both[0] < both[1], 1.0, -1.0)[whole] * off.mean(axis=0)
        whole[whole] = np.abs(off).max(axis=0) <= FLUSH * np.maximum(1.0, metres)
        pairs.append(np.sort(both, axis=0))
        goes_on.append(whole)
        steps.append(np.where(whole, step_of, 0.0))
    numbers, codes = np.unique(np.concatenate(pairs, axis=1), return_inverse=True)
    first, second = codes.reshape(2, -1)
    code = first * len(numbers) + second
    length, smooth = np.bincount(code), np.bincount(code, weights=np.concatenate(goes_on))
    level = np.abs(np.bincount(code, weights=np.concatenate(steps))) <= EVEN * smooth
    for found in np.flatnonzero((length >= SEAM) & (smooth >= MOSTLY * length) & level).tolist():
        yield numbers[list(divmod(found, len(numbers)))].tolist()


def _merged_labels(picture: Picture) -> Iterator[int]:
    """Labels of which two pieces meet within the mask at a step or an inward crease, and are not hollow."""
    inverse, label = picture.inverse.reshape(-1, picture.width), picture.label.reshape(-1, picture.width)
    pieces = np.zeros(label.shape, dtype=np.int32)
    ndimage.label(_unbent(picture).reshape(label.shape), output=pieces)
    sizes = np.bincount(pieces.ravel())
    sizes[0] = 0  # what is of no piece
    of = np.zeros(len(sizes), dtype=np.int64)
    of[pieces] = label
    boxes: list[tuple[slice, slice]] = ndimage.find_objects(pieces)
    for number in np.unique(of[sizes >= FEWEST]).tolist():
        own = np.flatnonzero(of == number)
        large = own[sizes[own] >= max(FEWEST, PIECE * sizes[own].sum())]
        for pair in combinations(large.tolist(), 2):
            a, b = (boxes[each - 1] for each in pair)
            window = tuple(
                slice(min(x.start, y.start) - FAR, max(x.stop, y.stop) + FAR)
                for x, y in zip(a, b, strict=True)
            )
            one, other = (pieces[window] == each for each in pair)
            if _are_two(inverse[window], label[window] == number, one, other):
                yield number
                break


def _unbent(picture: Picture) -> BoolArray:
    """Pixels (N,) of masks that no step or inward crease, and no border of a mask, goes through.

    Where one does, the pixel lies behind the chord between two of its mask, one to either side.
    """
    inverse, label = picture.inverse, picture.label
    at = np.flatnonzero(picture.surface > 0)
    limit = 2.0 * (inverse[at] + CREASE * np.maximum(inverse[at] ** 2, 1.0))  # [1/m]
    free = np.ones(len(at), dtype=bool)
    for down, right in AROUND[::2]:
        ends = at + CHORD * (down * picture.width + right) * np.array([[-1], [1]])
        same = (picture.surface[ends] == label[at]).all(axis=0)
        free &= ~same | (inverse[ends].sum(axis=0) <= limit)
    for down, right in AROUND[:4]:
        free &= label[at + down * picture.width + right] == label[at]
    found = np.zeros(len(label), dtype=bool)
    found[at[free]] = True
    return found


def _are_two(inverse: FloatArray, mask: BoolArray, one: BoolArray, other: BoolArray) -> bool:
    """Whether two pieces of a mask meet within it, and the one in front does not hold the other."""
    away, nearest = ndimage.distance_transform_edt(~one, return_indices=True)  # type: ignore[misc]
    there = np.argwhere(other & (away <= FAR))
    here = nearest[:, there[:, 0], there[:, 1]].T
    meets = mask[tuple(((there + here) // 2).T)]
    there, here = there[meets], here[meets]
    if len(there) < FAR * MEETS * np.sqrt(min(np.count_nonzero(one), np.count_nonzero(other))):
        return False
    step = 1.0 / inverse[tuple(there.T)] - 1.0 / inverse[tuple(here.T)]
    behind, before = np.quantile(step, (0.9, 0.1))
    if max(behind, -before) <= STEP:
        return True
    front, held = (one, there) if behind > -before else (other, here)
    sides = sides_of(np.argwhere(front).astype(np.float64))
    return sides is None or float((beyond(sides, held.astype(np.float64)) < -0.5).mean()) < HELD


def _duplicates(one: "DepthImage", other: "DepthImage", fixed: Collection[str]) -> Iterator[WrongMask]:
    """Objects whose surface another camera sees, and calls otherwise."""
    depth, label, asked = _thin_picture(one, fixed)
    rows, columns = np.nonzero(np.isin(label, asked) & (depth > 0))
    every = _every(one)
    called = other.labels_at(one.lifted(every * rows, every * columns), OFF)
    for number in asked:
        mine = called[label[rows, columns] == number]
        numbers, counts = np.unique(mine[mine > 0], return_counts=True)
        for their, count in zip(numbers.tolist(), counts.tolist(), strict=True):
            names = one.name_of(number), other.name_of(their)
            if names[0] != names[1] and names[1] not in fixed and count >= max(20, 0.5 * counts.sum()):
                yield WrongMask(MaskFault.DUPLICATE, (min(names), max(names)))
