"""Normal equations of sparse least squares."""

from typing import TYPE_CHECKING

import numpy as np

from topple.topology.kernels.compiled import address, kernels

if TYPE_CHECKING:
    from scipy.sparse import csc_array

    from topple.topology.base.arrays import FloatArray


def normal_sums(matrix: "csc_array", weights: "FloatArray") -> "FloatArray":
    """The product of some columns of a matrix with their transpose.

    Args:
        matrix: (n, m) sparse, of few entries a column.
        weights: (m,) which columns count: those above 0.

    Returns:
        (n, n) dense: the twin's to rounding.
    """
    compiled = kernels()
    if compiled is None:
        chosen = matrix[:, np.flatnonzero(weights > 0)]
        return (chosen @ chosen.T).toarray()
    sums = np.zeros((matrix.shape[0], matrix.shape[0]))
    sparse = [np.ascontiguousarray(each, dtype=np.int32) for each in (matrix.indptr, matrix.indices)]
    dense = [np.ascontiguousarray(each, dtype=np.float64) for each in (matrix.data, weights)]
    compiled.normal_sums(*map(address, sparse + dense), len(weights), len(sums), address(sums))
    return sums
