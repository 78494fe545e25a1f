"""Whose surface each pixel at the border of a mask is of, by its depth.

A segmentation's edge wanders beside the object's, colour and depth are registered to a pixel or two, and at a
step of depth a camera measures something in between. Such pixels lift to points beside the object: on a
neighbour, where they look like a contact, or in the air, where they widen it. So a pixel near a border is its
mask's only where its depth continues the surface seen inside the mask; else it is of the mask beside it whose
surface it continues, or of none. Where all masks end a few pixels to one side of the steps, they are moved.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage

from topple.topology.base.arrays import BoolArray, FloatArray, IntArray
from topple.topology.kernels.continued import Pixels, continue_surfaces
from topple.topology.kernels.tolerances import AROUND, BORDER, FAR, NEAREST, NO_SURFACE, NOBODY, OFF
from topple.topology.views.tolerances import (
    CLEARLY,
    ENOUGH,
    IN_A_PART,
    OFF_BORDERS,
    OFF_REGISTERED,
    STEP,
    THIN,
)


@dataclass(frozen=True, eq=False)
class Borders:
    """What depth says of masks.

    Attributes:
        owner: (H, W) label whose surface each pixel is of; `NOBODY` for those that continue neither their own
            mask's inside nor another's. Pixels without depth, those whose mask has no inside in any direction
            and those of thin parts, a rim or a handle, keep their label.
        off: Pixels that are another's, for each with depth that lies beside a border.
        moved: Rows and columns by which all masks were moved to where the steps of depth are.
    """

    owner: IntArray
    off: float
    moved: tuple[int, int]

    def said(self) -> str | None:
        """A sentence where masks are off by a pixel or more; None where they are not."""
        if self.moved != (0, 0):
            sides = (("up", "down"), ("to the left", "to the right"))
            ways = [f"{abs(by)} px {way[by < 0]}" for by, way in zip(self.moved, sides, strict=True) if by]
            return (
                f"masks lie {' and '.join(ways)} of the depth, and are moved back: is it registered to them?"
            )
        if self.off > OFF_BORDERS:
            return (
                f"masks are off by a pixel or more: {100 * self.off:.0f} % of the pixels at their borders "
                "are by depth of what lies beside, and count as its own"
            )
        return None


def borders(depth: FloatArray, label: IntArray) -> Borders:
    """Tell whose surface each pixel is of.

    The inside of a mask is what lies further than `BORDER` pixels from its border; of what is too thin to
    have one, the middle. From every other pixel rays go in eight directions to the nearest insides, and the
    plane that fits such a place best is continued to the pixel.

    Args:
        depth: (H, W) [m], 0 where there is none.
        label: (H, W), 0 for what no mask names.
    """
    owner, off = _owners(depth, label)
    moved = _offset(depth, label) if off > OFF_REGISTERED else (0, 0)
    if moved != (0, 0):
        there = _owners(depth, ndimage.shift(label, moved, order=0, mode="nearest"))
        if there[1] < off / 2:
            return Borders(*there, moved)
    return Borders(owner, off, (0, 0))


def _owners(depth: FloatArray, label: IntArray) -> tuple[IntArray, float]:
    picture = Picture.of(depth, label)
    rim = np.flatnonzero((picture.inverse > 0) & (picture.surface == NO_SURFACE))
    steps, owner, ahead = continue_surfaces(picture, rim, own=True)
    thin = np.flatnonzero(steps > FAR)
    middle = picture.is_middle(rim[thin])
    picture.continue_from(rim[thin[middle]])
    left = thin[~middle]
    steps[left], owner[left], ahead[left] = continue_surfaces(picture, rim[left], own=True)
    for _ in range(BORDER):  # what bends away is followed from pixel to pixel
        picture.continue_from(rim[owner != NOBODY])
        left = np.flatnonzero((steps <= FAR) & (owner == NOBODY))
        _, owner[left], _ = continue_surfaces(picture, rim[left], own=True)
        if (owner[left] == NOBODY).all():
            break
    off = (steps <= FAR) & (owner == NOBODY)
    wrong = rim[off]
    _, owner, before = continue_surfaces(picture, wrong, own=False)
    found = picture.label.copy()
    found[wrong] = owner
    flying = owner == NOBODY
    thin = wrong[flying & ((steps[off] > BORDER + 1) | (ahead[off] & before))]
    thin = thin[picture.beside(thin) >= IN_A_PART]
    found[thin] = picture.label[thin]
    wide = picture.faces(wrong[flying])
    found[wide] = picture.label[wide]
    beside = int(np.count_nonzero((_from_border(label, 1) == 1) & (depth > 0)))
    share = np.count_nonzero(owner != NOBODY) / max(beside, 1)
    return found.reshape(-1, picture.width)[FAR:-FAR, FAR:-FAR], share


def _offset(depth: FloatArray, label: IntArray) -> tuple[int, int]:
    """Rows and columns by which masks are to be moved, so that most of their borders lie on steps of depth.

    A shift counts only where it beats both none and its opposite clearly: masks that are too wide, or ragged,
    lie off to all sides.
    """
    meet = np.zeros((2 * BORDER + 1, 2 * BORDER + 1))
    core = slice(BORDER, -BORDER)
    for axis in (0, 1):
        far = [np.delete(each, end, axis) for each in (depth, label) for end in (-1, 0)]
        step = np.abs(far[0] - far[1]) > STEP * np.maximum(1.0, np.maximum(far[0], far[1])) ** 2
        step &= (far[0] > 0) & (far[1] > 0)
        at = np.flatnonzero(np.pad((far[2] != far[3])[core, core], BORDER))
        at = at[:: 1 + len(at) // ENOUGH]
        flat, width = step.ravel(), step.shape[1]
        for row, column in np.ndindex(*meet.shape):
            meet[row, column] += flat[at + (row - BORDER) * width + column - BORDER].sum()
    best = np.unravel_index(int(meet.argmax()), meet.shape)
    others = max(meet[BORDER, BORDER], meet[tuple(2 * BORDER - each for each in best)], 1.0)
    if meet[best] < CLEARLY * others:
        return (0, 0)
    return int(best[0]) - BORDER, int(best[1]) - BORDER


@dataclass(frozen=True, eq=False)
class Picture(Pixels):
    """A picture that knows its masks' borders.

    Attributes:
        from_border: (N,) pixels to the nearest other mask, at most one more than `BORDER`.
    """

    from_border: NDArray[np.int8]

    @staticmethod
    def of(depth: FloatArray, label: IntArray, border: int = BORDER) -> "Picture":
        """A picture whose inside is further than some pixels from any border of a mask."""
        shape = tuple(size + 2 * FAR for size in depth.shape)
        near, inverse = np.zeros(shape, dtype=np.int8), np.zeros(shape)
        named, seen = np.full(shape, NOBODY), np.full(shape, NO_SURFACE)
        core = (slice(FAR, -FAR), slice(FAR, -FAR))
        near[core], named[core] = _from_border(label, border), label
        np.divide(1.0, np.maximum(depth, NEAREST), out=inverse[core], where=depth > 0)
        np.copyto(seen, named, where=(near > border) & (inverse > 0))
        return Picture(inverse.ravel(), named.ravel(), seen.ravel(), shape[1], near.ravel())

    def continue_from(self, at: IntArray) -> None:
        """Let surfaces be continued of pixels (k,) as well."""
        self.surface[at] = self.label[at]

    def is_middle(self, at: IntArray) -> BoolArray:
        """Which of pixels (k,) are as far from a border as all of their mask beside them."""
        found = np.ones(len(at), dtype=bool)
        for down, right in AROUND:
            beside = at + down * self.width + right
            same = self.label[beside] == self.label[at]
            found &= ~same | (self.from_border[beside] <= self.from_border[at])
        return found

    def beside(self, at: IntArray) -> IntArray:
        """How many of pixels (k,) lie close to each, itself counted, on a surface of the same mask."""
        number = np.full(len(self.label), -1)
        number[at] = np.arange(len(at))
        depth, found = 1.0 / self.inverse[at], np.zeros(len(at), dtype=np.int64)
        for down, right in np.ndindex(THIN, THIN):
            place = at + (down - THIN // 2) * self.width + right - THIN // 2
            near = np.abs(depth[number[place]] - depth) <= OFF * np.maximum(1.0, depth) ** 2
            found += near & (number[place] >= 0) & (self.label[place] == self.label[at])
        return found

    def faces(self, at: IntArray) -> IntArray:
        """Those of pixels (k,) that lie in squares of three by three of them, each flat and of one mask.

        A face turned away from the camera is as wide, at its mask's border; a line of flying pixels is not.
        """
        among, square = np.zeros(len(self.label), dtype=bool), np.array([(0, 0), *AROUND])
        among[at] = True
        squares = at[:, None] + np.array([down * self.width + right for down, right in square.tolist()])
        whole = (among[squares] & (self.label[squares] == self.label[at][:, None])).all(axis=1)
        squares = squares[whole]
        inverse = self.inverse[squares]
        level = inverse.mean(axis=1, keepdims=True)
        plane = level + inverse @ square / np.square(square).sum(axis=0) @ square.T
        off = np.abs(1.0 / plane - 1.0 / inverse).max(axis=1)
        return np.unique(squares[off <= OFF * np.maximum(1.0, 1.0 / level[:, 0]) ** 2])


def _from_border(label: IntArray, most: int = BORDER) -> NDArray[np.int8]:
    """Pixels (H, W) to the nearest other mask, one for those beside it, `most` + 1 where it is further."""
    near = np.zeros(label.shape, dtype=bool)
    down, right = label[1:] != label[:-1], label[:, 1:] != label[:, :-1]
    near[1:] |= down
    near[:-1] |= down
    near[:, 1:] |= right
    near[:, :-1] |= right
    found = np.full(label.shape, most + 1, dtype=np.int8)
    for _ in range(most):
        found -= near
        tall = near.copy()
        tall[1:] |= near[:-1]
        tall[:-1] |= near[1:]
        near = tall.copy()
        near[:, 1:] |= tall[:, :-1]
        near[:, :-1] |= tall[:, 1:]
    return found
