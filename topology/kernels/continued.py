"""Which surfaces of a picture pixels continue: rays to the nearest insides, and the planes fitted there."""

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from topple.topology.kernels.compiled import address, kernels
from topple.topology.kernels.tolerances import AROUND, FAR, NARROW, NEAREST, NO_SURFACE, NOBODY, OFF, PATCH

if TYPE_CHECKING:
    from topple.topology.base.arrays import BoolArray, FloatArray, IntArray

_WAYS = np.array(AROUND, dtype=np.int64)


@dataclass(frozen=True, eq=False)
class Pixels:
    """A picture in rows one after the other, with a margin of `FAR` pixels, which no ray leaves.

    Attributes:
        inverse: (N,) 1 / depth [1/m], in which planes are linear; 0 where there is none.
        label: (N,) labels; those of the margin are nobody's.
        surface: (N,) labels of pixels of which a surface is continued, `NO_SURFACE` of others.
        width: Of a row.
    """

    inverse: "FloatArray"
    label: "IntArray"
    surface: "IntArray"
    width: int


def planes_around(pixels: Pixels, at: "IntArray") -> "FloatArray":
    """Fit planes to the patches around pixels.

    Args:
        pixels: The picture.
        at: (k,) pixels.

    Returns:
        (3, k) inverse depth [1/m] and its slopes down and right, of those pixels of each patch that are of
        the same mask's surface.
    """
    compiled = kernels()
    if compiled is not None:
        given, found = np.ascontiguousarray(at), np.empty((3, len(at)))
        compiled.continued_planes(*_arrays(pixels), address(given), len(given), address(found))
        return found
    down, right = np.indices((PATCH, PATCH)).reshape(2, -1).astype(np.float64) - PATCH // 2
    places = at[:, None] + (down * pixels.width + right).astype(np.int64)
    weight = (pixels.surface[places] == pixels.label[at][:, None]).astype(np.float64)
    count = weight.sum(axis=1)
    inverse = weight * pixels.inverse[places]
    moments = np.stack([down, right, down**2, right**2, down * right], axis=1)
    row, column, rows, columns, both = (weight @ moments / count[:, None]).T
    level = inverse.sum(axis=1) / count
    along_rows, along_columns = (inverse @ moments[:, :2] / count[:, None]).T
    rows, columns, both = rows - row**2 + NARROW, columns - column**2 + NARROW, both - row * column
    along_rows, along_columns = along_rows - level * row, along_columns - level * column
    area = rows * columns - both**2
    slope_down = (along_rows * columns - along_columns * both) / area
    slope_right = (along_columns * rows - along_rows * both) / area
    return np.stack([level - slope_down * row - slope_right * column, slope_down, slope_right])


def continue_surfaces(pixels: Pixels, at: "IntArray", own: bool) -> "tuple[IntArray, IntArray, BoolArray]":
    """Tell which surfaces pixels continue.

    From each rays go in eight directions to the nearest insides, and the plane there is continued.

    Args:
        pixels: The picture.
        at: (k,) pixels with depth.
        own: Whether of the pixel's own mask, or of others.

    Returns:
        (k,) pixels to the nearest such inside, more than `FAR` where none is met; labels of the first
        that is continued, or `NOBODY`; whether the pixel lies before all: a rim does, nothing that flies.
    """
    nearest, owner = np.full(len(at), FAR + 1), np.full(len(at), NOBODY)
    ahead, compiled = np.ones(len(at), dtype=np.bool_), kernels()
    if compiled is not None:
        given = np.ascontiguousarray(at)
        compiled.continued_surfaces(
            *_arrays(pixels), address(_WAYS), len(_WAYS), FAR, OFF, NEAREST, NO_SURFACE, NOBODY, own,
            address(given), len(given), address(nearest), address(owner), address(ahead),
        )  # fmt: skip
        return nearest, owner, ahead
    left = np.arange(len(at))
    for down, right in AROUND:
        found, place, steps = _ray(pixels, at[left], down * pixels.width + right, own)
        nearest[left[found]] = np.minimum(nearest[left[found]], steps)
        ends, which = np.unique(place, return_inverse=True)
        level, slope_down, slope_right = planes_around(pixels, ends)[:, which]
        depth = 1.0 / pixels.inverse[at[left[found]]]
        plane = level - steps * (down * slope_down + right * slope_right)
        behind, most = 1.0 / np.maximum(plane, NEAREST) - depth, OFF * np.maximum(1.0, depth) ** 2
        ahead[left[found]] &= behind > most
        close = np.abs(behind) <= most
        owner[left[found][close]] = pixels.label[place[close]]
        left = left[owner[left] == NOBODY]
    return nearest, owner, ahead


def _ray(pixels: Pixels, at: "IntArray", step: int, own: bool) -> "tuple[BoolArray, IntArray, IntArray]":
    """Where rays first meet an inside: which rays do (k,), at what pixel and after how many steps."""
    ends, steps = np.full(len(at), -1), np.zeros(len(at), dtype=np.int64)
    left, place, label = np.arange(len(at)), at, pixels.label[at]
    for number in range(1, FAR + 1):
        place = place + step
        seen = pixels.surface[place]
        hit = seen == label if own else (seen != NO_SURFACE) & (seen != label)
        ends[left[hit]], steps[left[hit]] = place[hit], number
        left, place, label = left[~hit], place[~hit], label[~hit]
    found = ends >= 0
    return found, ends[found], steps[found]


def _arrays(pixels: Pixels) -> tuple[int | float, ...]:
    """Arguments of both kernels about a picture."""
    arrays = (address(pixels.inverse), address(pixels.label), address(pixels.surface))
    return (*arrays, pixels.width, PATCH, NARROW)
