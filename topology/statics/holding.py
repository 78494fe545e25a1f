"""Forces that hold everything: found without a programme where there are any, and proof enough of rest.

A programme of static equilibrium minimises what is left unexplained, or says how far things sink. Where
forces are known that leave nothing over there is nothing to minimise, and nothing sinks. Such forces are a
least-squares problem over forces that only push, which is solved in a fraction of the time; where it finds
none the programme decides, so that no answer hangs on it.
"""

from collections.abc import Mapping, Sequence

import numpy as np
from scipy.optimize import nnls
from scipy.sparse import csc_array

from topple.topology.arrays import FloatArray
from topple.topology.statics.contact import Contact
from topple.topology.statics.equilibrium import Weight, balance, demanded, force_columns, islands, rising
from topple.topology.statics.tolerances import STEPS

NOTHING = 1e-9
"""Share of the weights left over that is rounding."""

SMALL = 1 << 15
"""Numbers in the equations of an island up to which they are solved one force at a time (0.25 MB)."""

Duals = dict[str, FloatArray]
"""name -> (6,) dual variables, one for each force and torque on an object: what a search begins with."""


def deficits(weights: Mapping[str, Weight], contacts: Sequence[Contact]) -> dict[str, float]:
    """What forces at the contacts leave unexplained of each weight: the deficits of `balance` alone.

    Args:
        weights: The objects that can move.
        contacts: Patches between them and with anything fixed; a name without a weight is fixed.

    Returns:
        name -> missing force and torque as a fraction of the weight.
    """
    found: dict[str, float] = {}
    rose = rising(weights)
    for island in islands(rose, contacts):
        part = {name: weight for name, weight in rose.items() if name in island}
        near = [contact for contact in contacts if contact.a in island or contact.b in island]
        if not near:
            found |= dict.fromkeys(part, 1.0)
        elif is_held(part, near, NOTHING):
            found |= dict.fromkeys(part, 0.0)
        else:
            found |= balance(part, near).deficit
    return {name: found[name] for name in rose}


def is_held(
    weights: Mapping[str, Weight], contacts: Sequence[Contact], within: float, warm: Duals | None = None
) -> bool:
    """Whether forces at the contacts were found that hold an island still.

    Args:
        weights: The objects that can move.
        contacts: Patches between them and with anything fixed.
        within: Share of its weight that may be left over of any force or torque on an object.
        warm: Where the search begins on a large island; where it found forces is left there for the next.

    Returns:
        True where there are such forces; False where there are none, or none were found soon.
    """
    if not contacts:
        return False
    height = 6 * len(weights)
    rows, columns, values, count = force_columns(weights, contacts)
    if height * count > SMALL:
        matrix = csc_array((values, (rows, columns)), shape=(height, count))
        return _large_is_held(matrix, list(weights), within, {} if warm is None else warm)
    dense = np.zeros((height, count))
    dense[rows, columns] = values
    try:
        return bool(nnls(dense, demanded(height))[1] < within)
    except RuntimeError:  # it went round in circles
        return False


def _large_is_held(matrix: csc_array, names: Sequence[str], within: float, warm: Duals) -> bool:
    """Whether the least forces x >= 0 with matrix @ x = demand are found.

    They are the positive part of matrix.T @ p for the p that maximises demand @ p - |x|² / 2: a concave
    problem without bounds, which Newton's method solves with few of the forces at a time.
    """
    demand = demanded(6 * len(names))
    duals = np.concatenate([warm.get(name, np.zeros(6)) for name in names])
    value, forces = _pushed(matrix, demand, duals)
    for _ in range(STEPS):
        left = demand - matrix @ forces
        if np.abs(left).max() < within:
            warm.update(zip(names, duals.reshape(-1, 6), strict=True))
            return True
        pushing = matrix[:, np.flatnonzero(forces)] if forces.any() else matrix
        curvature = (pushing @ pushing.T).toarray()
        curvature += 1e-6 * np.trace(curvature) / len(demand) * np.eye(len(demand))
        step = np.linalg.solve(curvature, left)
        gain, length = float(left @ step), 1.0
        while length > 1e-4:
            further, more = _pushed(matrix, demand, duals + length * step)
            if further >= value + 1e-4 * length * gain:
                break
            length /= 2
        else:
            return False
        duals, value, forces = duals + length * step, further, more
    return False


def _pushed(matrix: csc_array, demand: FloatArray, duals: FloatArray) -> tuple[float, FloatArray]:
    """How good a p is, and the forces that belong to it."""
    forces = np.maximum(matrix.T @ duals, 0.0)
    return float(demand @ duals - forces @ forces / 2), forces
