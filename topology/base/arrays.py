"""Array types of the package, and the read-only copies its frozen types hand out."""

from collections.abc import Iterable
from typing import Any, TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from topple.topology.base.tolerances import DECIMALS

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int64]
BoolArray = NDArray[np.bool_]
Bodies = Iterable[FloatArray]
"""Corners (V, 3) of each of some convex bodies [m]."""

AnyArray = TypeVar("AnyArray", FloatArray, IntArray)


def bounds(points: AnyArray) -> tuple[AnyArray, AnyArray]:
    """Least and greatest coordinates of points.

    Args:
        points: (N, 3) points, N >= 1.

    Returns:
        Two arrays (3,). Taken axis by axis from a copy: row by row numpy takes twenty times as long.
    """
    columns = points.T.copy()
    return columns.min(axis=1), columns.max(axis=1)


def median_of(values: FloatArray) -> float:
    """Median of numbers (N,), N >= 1 and none of them NaN: in a third of the time that numpy's takes."""
    half = len(values) // 2
    parted = np.partition(values, half)
    return float(parted[half] if len(values) % 2 else (parted[:half].max() + parted[half]) / 2)


def quantiles_of(values: FloatArray, *shares: float) -> list[float]:
    """Quantiles of numbers.

    Args:
        values: (N,) numbers, N >= 1 and none of them NaN.
        shares: Of the numbers that lie below each, 0..1.

    Returns:
        What `np.quantile(values, shares)` is to the last bit, in a tenth of its time.
    """
    last, found = len(values) - 1, list[float]()
    parted = np.partition(values, [min(int(last * share) + k, last) for share in shares for k in (0, 1)])
    for place in (last * share for share in shares):
        low, high, part = *parted[[int(place), min(int(place) + 1, last)]].tolist(), place % 1.0
        found.append(low + (high - low) * part if part < 0.5 else high - (high - low) * (1.0 - part))
    return found


def middle_of(points: FloatArray) -> FloatArray:
    """Mean of points.

    Args:
        points: (N, d) points, one after the other in memory.

    Returns:
        (d,) what `points.mean(axis=0)` is to the last bit, in a third of its time.
    """
    return np.einsum("ni->i", points) / len(points)


def cells_over(lower: FloatArray, upper: FloatArray, size: float) -> FloatArray:
    """Centres (N, 2) of square cells of a size over a rectangle, the second axis fastest."""
    ticks = [np.arange(low + size / 2, high + size / 2, size) for low, high in zip(lower, upper, strict=True)]
    return np.column_stack([each.ravel() for each in np.meshgrid(*ticks, indexing="ij")])


def lengths(vectors: FloatArray) -> FloatArray:
    """Lengths of vectors.

    Args:
        vectors: (N, 2) or (N, 3) vectors.

    Returns:
        (N,) what `np.linalg.norm(vectors, axis=1)` is to the last bit, in a fifth of its time.
    """
    return np.sqrt(sum_of_rows(vectors * vectors))


def sum_of_rows(values: FloatArray) -> FloatArray:
    """(N,) sums of rows (N, 2) or (N, 3): of rows as short as these numpy's take ten times as long."""
    total = values[:, 0] + values[:, 1]
    return total + values[:, 2] if values.shape[1] == 3 else total


def within_corners(points: FloatArray, lower: FloatArray, upper: FloatArray) -> BoolArray:
    """Which points lie in a box.

    Args:
        points: (N, d) points.
        lower: (d,) least corner.
        upper: (d,) greatest corner.

    Returns:
        (N,) True for those inside and on its sides. Compared axis by axis: row by row numpy takes nine times
        as long.
    """
    inside = np.ones(len(points), dtype=np.bool_)
    for axis, (least, most) in enumerate(zip(lower, upper, strict=True)):
        inside &= (points[:, axis] >= least) & (points[:, axis] <= most)
    return inside


def round_off(values: ArrayLike, decimals: int = DECIMALS) -> FloatArray:
    """Drop the last digits of lengths [m] and angles [rad] that decisions and simulations begin with.

    Linear algebra ends in other last bits on other processors: a simulation carries them on to millimetres,
    and what lies on the edge of a cell falls to either side. Rounded, the same seed is the same on all.

    Args:
        values: Numbers of any shape.
        decimals: How many are kept: of metres a nanometre.

    Returns:
        A float64 copy of the same shape, without negative zeros.
    """
    return np.asarray(np.round(np.asarray(values, dtype=np.float64), decimals) + 0.0)


def freeze(array: ArrayLike) -> FloatArray:
    """Copy an array into one nobody can write to.

    Args:
        array: Numbers of any shape.

    Returns:
        A C-contiguous float64 copy of the same shape, with writing switched off; an array that is
        already so is returned as it is, since nobody can change it under us.
    """
    given = np.asarray(array, dtype=np.float64)
    if not given.flags.writeable and given.flags.c_contiguous and given.base is None:
        return given
    copy = np.array(given, dtype=np.float64, order="C")
    copy.setflags(write=False)
    return copy


def frozen_int(array: ArrayLike) -> IntArray:
    """Copy an array of integers into one nobody can write to.

    Args:
        array: Integers of any shape.

    Returns:
        A C-contiguous int64 copy of the same shape, with writing switched off.
    """
    copy = np.array(array, dtype=np.int64, order="C")
    copy.setflags(write=False)
    return copy


def whole_numbers(array: NDArray[Any]) -> NDArray[Any]:
    """Take whole numbers that are stored as floats for what they are.

    Args:
        array: Numbers of any shape.

    Returns:
        The same as int64 where all of them are finite, whole and below 2**53, up to which floats tell
        them apart; else the array itself.
    """
    if array.dtype.kind != "f" or not np.isfinite(array).all():
        return array
    whole = (array == np.round(array)).all() and (np.abs(array) < 2.0**53).all()
    return array.astype(np.int64) if whole else array
