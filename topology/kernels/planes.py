"""Local planes: the plane through a patch of neighbouring points."""

from typing import TYPE_CHECKING

import numpy as np

from topple.topology.kernels.compiled import address, kernels

if TYPE_CHECKING:
    from topple.topology.base.arrays import FloatArray


def patch_planes(patches: "FloatArray") -> "tuple[FloatArray, FloatArray, FloatArray]":
    """The plane through each of some patches, by least squares.

    Args:
        patches: (P, k, 3) points of each patch [m], k >= 1.

    Returns:
        (P, 3) middles [m], (P, 3) unit normals of either sign, and (P, 3) sums of squared distances from the
        middle along the normal and along the two axes of the patch, ascending [m²]: the twin's within 1e-14
        of the largest.
    """
    compiled = kernels()
    if compiled is None:
        middles = patches.mean(axis=1)
        centred = patches - middles[:, None]
        squares, axes = np.linalg.eigh(np.einsum("pki,pkj->pij", centred, centred))
        return middles, axes[:, :, 0], np.maximum(squares, 0.0)
    given = np.ascontiguousarray(patches, dtype=np.float64)
    middles, normals, squares = np.empty((3, len(given), 3))
    compiled.planes_of_patches(
        address(given), *given.shape[:2], address(middles), address(normals), address(squares)
    )
    return middles, normals, squares
