"""What hangs together of points on surfaces."""

from topple.topology.base.arrays import FloatArray
from topple.topology.geometry.thin import spacing_of
from topple.topology.geometry.tolerances import LINKED, PIECE_FEWEST, SPARSE
from topple.topology.kernels.neighbours import PointTree
from topple.topology.kernels.pieces import pieces_of_links


def surface_spacing(points: FloatArray, spacing: float) -> float:
    """Typical distance of neighbours on surfaces that may have fewer points than the whole they are of [m].

    Args:
        points: (N, 3) points [m].
        spacing: That of the whole [m].

    Returns:
        The larger of the two; that of points as sparse as strays counts for nothing.
    """
    own = spacing_of(points) if len(points) else 0.0
    return max(spacing, own) if own <= SPARSE else spacing


def pieces_of(points: FloatArray, spacing: float = 0.0, fewest: int = PIECE_FEWEST) -> list[FloatArray]:
    """Points that hang together; what is too small to be a thing is left out.

    Args:
        points: (N, 3) points [m].
        spacing: Typical distance of neighbours on a surface [m]; counts where that is sparse.
        fewest: Points of a piece at least.

    Returns:
        (M, 3) points of each piece [m].
    """
    return [piece for piece in _components(points, max(LINKED, 2.0 * spacing)) if len(piece) >= fewest]


def _components(points: FloatArray, reach: float) -> list[FloatArray]:
    """(N, 3) points [m] as those that hang together, each within reach of another."""
    if len(points) == 0:
        return []
    number = pieces_of_links(PointTree(points).query_pairs(reach), len(points))
    return [points[number == k] for k in range(int(number.max()) + 1)]
