"""Local planes: the plane through a patch of neighbouring points."""

import numpy as np

from topple.topology.arrays import FloatArray


def patch_planes(patches: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """The plane through each of some patches, by least squares.

    Args:
        patches: (P, k, 3) points of each patch [m].

    Returns:
        (P, 3) middles [m], (P, 3) unit normals of either sign, and (P, 3) sums of squared distances from the
        middle along the normal and along the two axes of the patch, ascending [m²].
    """
    middles = patches.mean(axis=1)
    centred = patches - middles[:, None]
    squares, axes = np.linalg.eigh(np.einsum("pki,pkj->pij", centred, centred))
    return middles, axes[:, :, 0], np.maximum(squares, 0.0)
