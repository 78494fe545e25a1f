"""The library of compiled kernels, where there is one; the numpy twins run elsewhere."""

import ctypes
import os
from functools import cache
from typing import TYPE_CHECKING, Any

from topple.topology.kernels.build import library

if TYPE_CHECKING:
    from numpy.typing import NDArray

VARIABLE = "TOPPLE_KERNELS"
"""Environment variable: `numpy` lets the twins run although there is a library."""

_ARRAY, _COUNT, _NUMBER = ctypes.c_void_p, ctypes.c_int64, ctypes.c_double
_PICTURE = (_ARRAY, _ARRAY, _ARRAY, _COUNT, _COUNT, _NUMBER)
_SIGNATURES = {
    "tree_sizes": (None, _COUNT, _ARRAY, _ARRAY),
    "tree_build": (None, _ARRAY, _COUNT, _ARRAY, _ARRAY),
    "tree_nearest": (
        None, _ARRAY, _ARRAY, _COUNT, _ARRAY, _ARRAY, _COUNT, _COUNT, _NUMBER, _ARRAY, _ARRAY,
    ),
    "tree_within": (_COUNT, _ARRAY, _ARRAY, _COUNT, _ARRAY, _COUNT, _NUMBER, _ARRAY, _ARRAY, _COUNT),
    "tree_around": (
        None, _ARRAY, _ARRAY, _COUNT, _ARRAY, _NUMBER, _ARRAY, _COUNT, _ARRAY, _ARRAY, _ARRAY,
    ),
    "pieces_of_links": (None, _ARRAY, _COUNT, _COUNT, _ARRAY),
    "cavity_walled": (
        None, _ARRAY, _COUNT, _ARRAY, _COUNT, _NUMBER, _NUMBER, _COUNT, _COUNT, _ARRAY,
    ),
    "cavity_roofed": (None, _ARRAY, _COUNT, _ARRAY, _COUNT, _NUMBER, _NUMBER, _ARRAY),
    "cells_bounds": (None, _ARRAY, _COUNT, _ARRAY, _ARRAY),
    "cells_sort": (_COUNT, _ARRAY, _COUNT, _ARRAY, _ARRAY, _ARRAY, _NUMBER, _ARRAY, _ARRAY),
    "cells_within": (None, _ARRAY, _COUNT, _ARRAY, _NUMBER, _ARRAY),
    "cells_means": (None, _ARRAY, _ARRAY, _ARRAY, _COUNT, _ARRAY),
    "chain_poses": (None, *[_ARRAY] * 2, _COUNT, _ARRAY, _COUNT, _ARRAY),
    "chain_solve": (
        _COUNT, *[_ARRAY] * 5, _COUNT, _ARRAY, _COUNT, _ARRAY, _COUNT, *[_ARRAY] * 2, _COUNT, _NUMBER,
        *[_ARRAY] * 2,
    ),
    "closest_places": (None, *[_ARRAY] * 5, _COUNT, _COUNT, _ARRAY, _ARRAY),
    "continued_planes": (None, *_PICTURE, _ARRAY, _COUNT, _ARRAY),
    "continued_surfaces": (
        None, *_PICTURE, _ARRAY, _COUNT, _COUNT, _NUMBER, _NUMBER, _COUNT, _COUNT, _COUNT, _ARRAY, _COUNT,
        _ARRAY, _ARRAY, _ARRAY,
    ),
    "heights_over": (None, _ARRAY, _COUNT, _ARRAY, _NUMBER, _ARRAY, _ARRAY, _NUMBER, _ARRAY),
    "hollow_hull": (_NUMBER, *[_ARRAY, _COUNT] * 4, *[_NUMBER] * 4, _COUNT, _ARRAY),
    "normal_sums": (None, *[_ARRAY] * 4, _COUNT, _COUNT, _ARRAY),
    "outline_corners": (_COUNT, _ARRAY, _COUNT, _ARRAY),
    "pinch_windows": (
        None, *[_ARRAY] * 2, _COUNT, *[_ARRAY] * 2, *[_COUNT] * 2, *[_ARRAY] * 2, _COUNT, _ARRAY, _COUNT,
        _ARRAY, _COUNT, _ARRAY, _COUNT, *[_ARRAY] * 4,
    ),
    "planes_of_patches": (None, _ARRAY, _COUNT, _COUNT, _ARRAY, _ARRAY, _ARRAY),
    "separation_gaps": (
        None, *[_ARRAY] * 2, *[_COUNT] * 2, *[_ARRAY] * 3, _COUNT, *[_ARRAY] * 2, _COUNT, _ARRAY,
    ),
    "separation_intervals": (
        None, *[_ARRAY] * 2, *[_COUNT] * 2, *[_ARRAY] * 6, _COUNT, _ARRAY, _COUNT, *[_ARRAY] * 2,
    ),
    "separation_open": (
        _COUNT, *[_ARRAY] * 2, *[_COUNT] * 2, *[_ARRAY] * 2, *[_COUNT] * 4, *[_ARRAY] * 3,
    ),
    "triangles_drawn": (
        None, _ARRAY, _COUNT, _ARRAY, _COUNT, _COUNT, _NUMBER, *[_ARRAY] * 4,
    ),
    "sphere_nearest": (_COUNT, _ARRAY, _COUNT, _COUNT, _COUNT, _NUMBER, _NUMBER, _ARRAY),
}  # fmt: skip
"""Name of a kernel -> what it gives and takes."""


def kernels() -> ctypes.CDLL | None:
    """The compiled kernels, which let other threads run; None where the twins are to run."""
    return None if os.environ.get(VARIABLE) == "numpy" else _library()


@cache
def _library() -> ctypes.CDLL | None:
    path = library()
    if not path.exists():
        return None
    try:
        found = ctypes.CDLL(str(path))
    except OSError:  # of another platform
        return None
    for name, (given, *taken) in _SIGNATURES.items():
        kernel = getattr(found, name)
        kernel.restype, kernel.argtypes = given, taken
    return found


def address(array: "NDArray[Any]") -> int:
    """Where the numbers of an array lie, which is C-contiguous and held by the caller meanwhile."""
    return array.__array_interface__["data"][0]


def path_in_words() -> str:
    """Which path runs, for `topple --version`."""
    if kernels() is not None:
        return "compiled kernels"
    why = f"{VARIABLE}=numpy" if _library() else "none compiled: python -m topple.topology.kernels.build"
    return f"numpy twins of the kernels ({why})"
