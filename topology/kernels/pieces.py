"""Pieces: what hangs together by links."""

from typing import TYPE_CHECKING

import numpy as np

from topple.topology.kernels.compiled import address, kernels

if TYPE_CHECKING:
    from topple.topology.base.arrays import IntArray


def pieces_of_links(links: "IntArray", count: int) -> "IntArray":
    """Number the pieces that links join.

    Args:
        links: (L, 2) rows that are joined, each below `count`.
        count: How many rows there are.

    Returns:
        (count,) number of each row's piece, from 0 on, in the order of their first rows.
    """
    compiled = kernels()
    if compiled is None:
        from scipy.sparse import coo_matrix
        from scipy.sparse.csgraph import connected_components

        graph = coo_matrix((np.ones(len(links)), (links[:, 0], links[:, 1])), shape=(count, count))
        return np.asarray(connected_components(graph, directed=False)[1], dtype=np.int64)
    given, numbers = np.ascontiguousarray(links, dtype=np.int64), np.empty(count, dtype=np.int64)
    compiled.pieces_of_links(address(given), len(given), count, address(numbers))
    return numbers
