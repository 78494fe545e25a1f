"""Forces that hold everything: found without a programme where there are any, and proof enough of rest.

A programme of static equilibrium minimises what is left unexplained, or says how far things sink. Where
forces are known that leave nothing over there is nothing to minimise, and nothing sinks. Such forces are a
least-squares problem over forces that only push, which is solved in a fraction of the time; where it finds
none the programme decides, so that no answer hangs on it.
"""

from collections.abc import Collection, Mapping, Sequence
from itertools import pairwise

import numpy as np
from scipy.optimize import nnls
from scipy.sparse import csc_array

from topple.topology.base.arrays import FloatArray, IntArray
from topple.topology.statics.contact import Contact
from topple.topology.statics.equilibrium import Weight, balance, demanded, force_columns, islands, rising
from topple.topology.statics.tolerances import CONE_EDGES, STEPS

NOTHING = 1e-9
"""Share of the weights left over that is rounding."""

SMALL = 1 << 15
"""Numbers in the equations of an island up to which they are solved one force at a time (0.25 MB)."""


class Search:
    """What searches for forces leave for the next ones: it changes no answer.

    Attributes:
        duals: name -> (6,) dual variables, one for each force and torque on an object: where a search begins.
    """

    def __init__(self) -> None:
        """Nothing is known yet."""
        self.duals: dict[str, FloatArray] = {}
        self._held: list[_Held] = []

    def keep(self, held: "_Held") -> None:
        """Keep the forces that hold an island while everything is in place."""
        self._held.append(held)

    def holds_without(self, island: frozenset[str], away: Collection[str], within: float) -> bool | None:
        """Whether what is left of an island is held by the forces kept, of which some have to change.

        Args:
            island: Names of the objects that are left.
            away: Names of those that are gone.
            within: As for `is_held`.

        Returns:
            Whether such forces were found; None where none are kept that held it.
        """
        kept = next((held for held in self._held if island <= held.names), None)
        return None if kept is None else kept.without(island, away, within)


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
    weights: Mapping[str, Weight],
    contacts: Sequence[Contact],
    within: float,
    search: Search | None = None,
    whole: bool = False,
) -> bool:
    """Whether forces at the contacts were found that hold an island still.

    Args:
        weights: The objects that can move.
        contacts: Patches between them and with anything fixed.
        within: Share of its weight that may be left over of any force or torque on an object.
        search: What earlier searches on large islands left; this one leaves more there.
        whole: Whether everything is in place: the forces are then kept for when something is gone.

    Returns:
        True where there are such forces; False where there are none, or none were found soon.
    """
    if not contacts:
        return False
    height = 6 * len(weights)
    rows, columns, values, count = force_columns(weights, contacts)
    if height * count > SMALL:
        matrix = csc_array((values, (rows, columns)), shape=(height, count))
        return _large_is_held(matrix, weights, contacts, within, search, whole)
    dense = np.zeros((height, count))
    dense[rows, columns] = values
    try:
        return bool(nnls(dense, demanded(height))[1] < within)
    except RuntimeError:  # it went round in circles
        return False


def _large_is_held(
    matrix: csc_array,
    weights: Mapping[str, Weight],
    contacts: Sequence[Contact],
    within: float,
    search: Search | None,
    whole: bool,
) -> bool:
    """Whether forces are found that hold a large island."""
    search = Search() if search is None else search
    duals = np.concatenate([search.duals.get(name, np.zeros(6)) for name in weights])
    found = _least_forces(matrix, demanded(6 * len(weights)), duals, within)
    if found is None:
        return False
    duals, forces = found
    search.duals.update(zip(weights, duals.reshape(-1, 6), strict=True))
    if whole:
        search.keep(_Held(tuple(weights), contacts, matrix, forces, duals.reshape(-1, 6)))
    return True


def holds_besides(
    weights: Mapping[str, Weight],
    contacts: Sequence[Contact],
    pressing: Sequence[tuple[Contact, FloatArray]],
    within: float,
    search: Search,
) -> bool:
    """Whether forces were found that hold objects on which others press with known forces.

    Args:
        weights: The objects that can move.
        contacts: Patches between them and with anything fixed.
        pressing: Other patches, and (k * edges,) what is pressed with along each edge of their pyramids.
        within: As for `is_held`.
        search: Where the search begins.
    """
    rows, columns, values, count = force_columns(weights, contacts)
    demand = demanded(6 * len(weights))
    if pressing:
        there, which, weight, _ = force_columns(weights, [contact for contact, _ in pressing])
        forces = np.concatenate([each for _, each in pressing])
        demand = demand - np.bincount(there, weights=weight * forces[which], minlength=len(demand))
    if not count:
        return bool(np.abs(demand).max(initial=0.0) < within)
    matrix = csc_array((values, (rows, columns)), shape=(len(demand), count))
    duals = np.concatenate([search.duals.get(name, np.zeros(6)) for name in weights])
    return _least_forces(matrix, demand, duals, within) is not None


class _Held:
    """An island with forces that hold it.

    What is taken away leaves some others without the forces it had on them. Where other forces are found that
    hold these and what is around them, all else keeps those it has: for a proof no more has to be solved.
    """

    def __init__(
        self,
        names: tuple[str, ...],
        contacts: Sequence[Contact],
        matrix: csc_array,
        forces: FloatArray,
        duals: FloatArray,
    ) -> None:
        """Keep the equations of an island, see `force_columns`, and what solves them."""
        self.names = frozenset(names)
        self._place = {name: i for i, name in enumerate(names)}
        self._matrix, self._forces, self._duals = matrix, forces, duals
        ends = np.cumsum([CONE_EDGES * len(contact.gaps) for contact in contacts])
        self._columns = [np.arange(*span) for span in pairwise([0, *ends.tolist()])]
        self._sides = [(contact.a, contact.b) for contact in contacts]
        self._meeting: dict[str, set[str]] = {name: set() for name in names}
        self._pushing: dict[str, list[int]] = {name: [] for name in names}
        for number, (a, b) in enumerate(self._sides):
            for one, other in ((a, b), (b, a)):
                if one in self._place:
                    self._meeting[one].add(other)
                    self._pushing[one].append(number)

    def without(self, island: frozenset[str], away: Collection[str], within: float) -> bool:
        """Whether what is left of it is held: see `Search.holds_without`."""
        near = {name for name in island if not self._meeting[name].isdisjoint(away)}
        if not near:
            return True  # no force is gone
        near |= set[str]().union(*(self._meeting[name] for name in near)) & island
        border = list(near)
        while border:  # what was carried weighs on all that is below no more
            name = border.pop()
            below = {n for n in self._meeting[name] & island if self._place[n] < self._place[name]} - near
            near |= below
            border += below
        return self._balanced_anew(near, island, away, within)

    def _balanced_anew(
        self, near: Collection[str], island: frozenset[str], away: Collection[str], within: float
    ) -> bool:
        """Whether other forces hold some of what is left, while those on all the rest stay as they are."""
        names = sorted(near, key=self._place.__getitem__)
        free: list[IntArray] = []
        kept: list[IntArray] = []
        for number in sorted(set[int]().union(*(self._pushing[name] for name in names))):
            sides = self._sides[number]
            if not any(side in away for side in sides):
                outside = any(side in island and side not in near for side in sides)
                (kept if outside else free).append(self._columns[number])
        if not free:
            return False
        places = np.array([self._place[name] for name in names])
        rows = (6 * places[:, None] + np.arange(6)).ravel()
        demand = demanded(len(rows))
        if kept:
            columns = np.concatenate(kept)
            demand -= (self._matrix[:, columns] @ self._forces[columns])[rows]
        matrix = csc_array(self._matrix[:, np.concatenate(free)].tocsr()[rows])
        return _least_forces(matrix, demand, self._duals[places].ravel(), within) is not None


def _least_forces(
    matrix: csc_array, demand: FloatArray, duals: FloatArray, within: float
) -> tuple[FloatArray, FloatArray] | None:
    """The least forces x >= 0 with matrix @ x = demand and the p they belong to, if they are found.

    They are the positive part of matrix.T @ p for the p that maximises demand @ p - |x|² / 2: a concave
    problem without bounds, which Newton's method solves with few of the forces at a time.

    Args:
        matrix: (6 n, forces) what each force does.
        demand: (6 n,) what they have to give.
        duals: (6 n,) the p to begin with.
        within: How much of any demand may be left over.
    """
    value, forces = _pushed(matrix, demand, duals)
    for _ in range(STEPS):
        left = demand - matrix @ forces
        if np.abs(left).max() < within:
            return duals, forces
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
            return None
        duals, value, forces = duals + length * step, further, more
    return None


def _pushed(matrix: csc_array, demand: FloatArray, duals: FloatArray) -> tuple[float, FloatArray]:
    """How good a p is, and the forces that belong to it."""
    forces = np.maximum(matrix.T @ duals, 0.0)
    return float(demand @ duals - forces @ forces / 2), forces
