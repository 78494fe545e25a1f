"""The circle or sphere nearest to points."""

from typing import TYPE_CHECKING

import numpy as np

from topple.topology.kernels.compiled import address, kernels
from topple.topology.kernels.tolerances import ROUNDS, STILL

if TYPE_CHECKING:
    from topple.topology.base.arrays import FloatArray


def sphere_through(points: "FloatArray") -> "tuple[FloatArray, float] | None":
    """The sphere through points, by least squares of the squared distances: a linear problem.

    Args:
        points: (N, d) points [m]; a circle for d = 2.

    Returns:
        (d,) centre and radius [m]; None where the points lie in a plane (on a line).
    """
    size = points.shape[1]
    middle = points.mean(axis=0)
    local = points - middle
    # |p|^2 = 2 c.p + r^2 - |c|^2 is linear in c and in what remains.
    system = np.column_stack([2.0 * local, np.ones(len(local))])
    solution, _, rank, _ = np.linalg.lstsq(system, (local * local).sum(axis=1), rcond=None)
    if rank <= size:
        return None
    centre = solution[:size]
    return centre + middle, float(np.sqrt(max(solution[size] + centre @ centre, 1e-12)))


def sphere_nearest(points: "FloatArray", largest: float) -> "tuple[FloatArray, float] | None":
    """The sphere nearest to points, by least squares of the distances.

    Args:
        points: (N, d) points [m], N >= 1; a circle for d = 2.
        largest: Radius [m] beyond which none is looked for.

    Returns:
        (d,) centre and radius [m], the twin's within `STILL` where the points show the round; None where none
        fits, as where so little is seen of a round that any radius does.
    """
    compiled = kernels()
    if compiled is None:
        return _sphere_nearest(points, largest)
    fit = np.empty(points.shape[1] + 1)
    given = np.ascontiguousarray(points, dtype=np.float64)
    if not compiled.sphere_nearest(
        address(given), *given.shape, ROUNDS, STILL, largest, address(fit)
    ):  # fmt: skip
        return None
    return fit[:-1], float(fit[-1])


def _sphere_nearest(points: "FloatArray", largest: float) -> "tuple[FloatArray, float] | None":
    """The twin of `sphere_nearest`."""
    first = sphere_through(points)
    if first is None:
        return None
    size = points.shape[1]
    middle = points.mean(axis=0)
    centre, radius = first[0] - middle, first[1]
    for _ in range(ROUNDS):
        rays = points - middle - centre
        far = np.maximum(np.sqrt((rays * rays).sum(axis=1)), 1e-9)
        system = np.column_stack([rays / far[:, None], np.ones(len(points))])
        try:
            step = np.linalg.solve(system.T @ system, system.T @ (far - radius))
        except np.linalg.LinAlgError:
            return None  # all rays alike
        centre, radius = centre + step[:size], radius + float(step[size])
        if not np.isfinite(radius) or abs(radius) > largest:
            return None
        if np.abs(step).max() < STILL:
            break
    return (centre + middle, radius) if radius > 0.0 else None
