"""Forces that hold everything: found without a programme where there are any, and proof enough of rest.

A programme of static equilibrium minimises what is left unexplained, or says how far things sink. Where
forces are known that leave nothing over there is nothing to minimise, and nothing sinks. Such forces are a
least-squares problem over forces that only push, which is solved in a fraction of the time; where it finds
none the programme decides, so that no answer hangs on it.
"""

from collections.abc import Collection, Mapping, Sequence
from itertools import pairwise

import numpy as np
from scipy.linalg import solveh_banded
from scipy.optimize import brentq, nnls
from scipy.sparse import csc_array

from topple.topology.base.arrays import FloatArray, IntArray
from topple.topology.kernels.compiled import address, kernels
from topple.topology.statics.contact import Contact
from topple.topology.statics.equilibrium import Weight, balance, by_height, demand_of, force_columns, islands
from topple.topology.statics.tolerances import CONE_EDGES, STEPS

NOTHING = 1e-9
"""Share of the weights left over that is rounding."""

DAMPED = 1e-8
"""Damping, as a share of the mean curvature: with more, what is only just held takes hundreds of steps."""

SMALL = 1 << 15
"""Numbers in the equations of an island up to which they are solved one force at a time (0.25 MB)."""


Pressing = Sequence[tuple[Contact, FloatArray]]
"""Patches, and (k * edges,) what is pressed with along each edge of their friction pyramids."""


class Search:
    """What searches for forces leave for the next ones: it changes no answer.

    Attributes:
        duals: name -> (6,) dual variables, one for each force and torque on an object: where a search begins.
        held: Forces that hold islands while everything is in place.
    """

    def __init__(self) -> None:
        """Nothing is known yet."""
        self.duals: dict[str, FloatArray] = {}
        self.held: list[_Held] = []

    def kept(self, left: frozenset[str]) -> "_Held | None":
        """The forces kept that held the island of which some objects are left; None where there are none."""
        return next((held for held in self.held if left <= held.names), None)


def deficits(weights: Mapping[str, Weight], contacts: Sequence[Contact]) -> dict[str, float]:
    """Measure the part of each weight that contact forces do not explain: the deficits of `balance`.

    Args:
        weights: The objects that can move.
        contacts: Patches between them and with anything fixed; a name without a weight is fixed.

    Returns:
        name -> missing force and torque as a fraction of the weight.
    """
    found: dict[str, float] = {}
    rose = by_height(weights)
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
        return bool(nnls(dense, demand_of(height))[1] < within)
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
    duals, forces, left = _least_forces(matrix, demand_of(6 * len(weights)), duals, within)
    if np.abs(left).max() >= within:
        return False
    search.duals.update(zip(weights, duals.reshape(-1, 6), strict=True))
    if whole:
        search.held.append(_Held(weights, contacts, matrix, forces, duals.reshape(-1, 6)))
    return True


class _Held:
    """An island with forces that hold it.

    What is taken away leaves some others without the forces it had on them. Where other forces are found that
    hold these and what is around them, all else keeps those it has: for a proof no more has to be solved.
    """

    def __init__(
        self,
        weights: Mapping[str, Weight],
        contacts: Sequence[Contact],
        matrix: csc_array,
        forces: FloatArray,
        duals: FloatArray,
    ) -> None:
        """Keep the equations of an island, see `force_columns`, and what solves them."""
        self.names = frozenset(weights)
        self._weights = weights
        self._place = {name: i for i, name in enumerate(weights)}
        self._matrix, self._forces, self._duals = matrix, forces, duals
        ends = np.cumsum([CONE_EDGES * len(contact.gaps) for contact in contacts])
        self._columns = [np.arange(*span) for span in pairwise([0, *ends.tolist()])]
        self._sides = [(contact.a, contact.b) for contact in contacts]
        self._meeting: dict[str, set[str]] = {name: set() for name in weights}
        self._pushing: dict[str, list[int]] = {name: [] for name in weights}
        for number, (a, b) in enumerate(self._sides):
            for one, other in ((a, b), (b, a)):
                if one in self._place:
                    self._meeting[one].add(other)
                    self._pushing[one].append(number)

    def find_unheld(
        self, left: frozenset[str], away: Collection[str], within: float, pressing: Pressing, wide: bool
    ) -> frozenset[str]:
        """Which of what is left the forces kept do not hold, of which some have to change.

        Args:
            left: Names of the objects that are left.
            away: Names of those that are gone, or sink.
            within: As for `is_held`.
            pressing: What those that sink press on the others with.
            wide: Whether all forces may change; else those around what is gone and below.
        """
        names = sorted(left if wide else self._near(left, away, pressing), key=self._place.__getitem__)
        over = self._left_over(names, left, away, within, pressing).reshape(-1, 6)
        return frozenset(names[i] for i in np.flatnonzero(np.abs(over).max(axis=1) >= within))

    def _near(self, left: frozenset[str], away: Collection[str], pressing: Pressing) -> set[str]:
        """Objects that meet one that is gone or presses, those that meet these, and all below them."""
        near = {name for name in left if not self._meeting[name].isdisjoint(away)}
        near |= {name for contact, _ in pressing for name in (contact.a, contact.b) if name in left}
        near |= set[str]().union(*(self._meeting[name] for name in near)) & left
        border = list(near)
        while border:  # what was carried weighs on all that is below no more
            name = border.pop()
            below = {n for n in self._meeting[name] & left if self._place[n] < self._place[name]} - near
            near |= below
            border += below
        return near

    def _left_over(
        self,
        names: Sequence[str],
        left: frozenset[str],
        away: Collection[str],
        within: float,
        pressing: Pressing,
    ) -> FloatArray:
        """Residual of forces on some of the objects left, while those on all the rest stay as they are."""
        inside, free = set(names), list[IntArray]()
        kept: list[IntArray] = []
        for number in sorted(set[int]().union(*(self._pushing[name] for name in names))):
            sides = self._sides[number]
            if not any(side in away for side in sides):
                outside = any(side in left and side not in inside for side in sides)
                (kept if outside else free).append(self._columns[number])
        places = np.array([self._place[name] for name in names])
        rows = (6 * places[:, None] + np.arange(6)).ravel()
        demand = demand_of(len(rows))
        if kept:
            columns = np.concatenate(kept)
            demand -= (self._matrix[:, columns] @ self._forces[columns])[rows]
        demand -= _wrench_of({name: self._weights[name] for name in names}, pressing)
        if not free:  # nothing is gone that met any, or nothing carries them
            return demand
        matrix = csc_array(self._matrix[:, np.concatenate(free)].tocsr()[rows])
        return _least_forces(matrix, demand, self._duals[places].ravel(), within)[2]


def _wrench_of(weights: Mapping[str, Weight], pressing: Pressing) -> FloatArray:
    """(6 n,) what known forces do to some objects."""
    rows, columns, values, _ = force_columns(weights, [contact for contact, _ in pressing])
    forces = np.concatenate([np.zeros(0), *(each for _, each in pressing)])
    done = np.bincount(rows, weights=values * forces[columns], minlength=6 * len(weights))
    return np.asarray(done, dtype=np.float64)


def _least_forces(
    matrix: csc_array, demand: FloatArray, duals: FloatArray, within: float
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """The least forces x >= 0 with matrix @ x = demand and the p they belong to, as far as they are found.

    They are the positive part of matrix.T @ p for the p that maximises demand @ p - |x|² / 2: a concave
    problem without bounds, which Newton's method solves with few of the forces at a time. Where no forces
    give what is demanded p grows without end, and what is left over settles on the objects that sink.

    Args:
        matrix: (6 n, forces) what each force does.
        demand: (6 n,) what they have to give.
        duals: (6 n,) the p to begin with.
        within: How much of any demand may be left over.

    Returns:
        The p, the forces and (6 n,) what they leave over.
    """
    pushes = matrix.T @ duals
    forces = np.maximum(pushes, 0.0)
    left = demand - matrix @ forces
    first, last = (each.reduceat(matrix.indices, matrix.indptr[:-1]) for each in (np.minimum, np.maximum))
    width = int((last - first).max()) + 1  # of the products of columns nothing is further from the diagonal
    for _ in range(STEPS):
        most = np.abs(left).max()
        if most < within:
            break
        curvature = normal_sums(matrix, width, forces if forces.any() else np.ones(len(forces)))
        curvature[:, 0] += DAMPED * curvature[:, 0].mean()
        step = solveh_banded(curvature.T, left, overwrite_ab=True, lower=True, check_finite=False)
        gains = matrix.T @ step
        length = _length(pushes, gains, float(demand @ step))
        duals, pushes = duals + length * step, pushes + length * gains
        forces, before = np.maximum(pushes, 0.0), left
        left = demand - matrix @ forces
        if np.abs(left - before).max() < 1e-3 * length * most:
            break  # no more forces are found
    return duals, forces, left


def _length(pushes: FloatArray, gains: FloatArray, gain: float) -> float:
    """Choose how much of a step to take: all, or the best where it loses at the end more than it gains first.

    Args:
        pushes: (forces,) matrix.T @ p before it.
        gains: (forces,) what it adds to them.
        gain: What it adds to demand @ p.
    """

    def loss(length: float) -> float:
        return float(np.maximum(pushes + length * gains, 0.0) @ gains) - gain

    first = loss(0.0)
    return float(brentq(loss, 0.0, 1.0, rtol=1e-3)) if first < 0.0 < loss(1.0) + first else 1.0


def normal_sums(matrix: csc_array, width: int, weights: FloatArray) -> FloatArray:
    """The product of some columns of a matrix with their transpose, near its diagonal.

    Args:
        matrix: (n, m) sparse, of few entries a column, whose rows rise.
        width: How many entries of each column of the product are kept, the diagonal and those below it.
        weights: (m,) which columns count: those above 0.

    Returns:
        (n, width) of each column of the product: the twin's to rounding.
    """
    compiled = kernels()
    sums = np.zeros((matrix.shape[0], width))
    if compiled is None:
        chosen = csc_array(matrix[:, np.flatnonzero(weights > 0)])
        product = csc_array(chosen @ chosen.T)
        for below in range(width):
            sums[: len(sums) - below, below] = product.diagonal(-below)
        return sums
    sparse = [np.ascontiguousarray(each, dtype=np.int32) for each in (matrix.indptr, matrix.indices)]
    dense = [np.ascontiguousarray(each, dtype=np.float64) for each in (matrix.data, weights)]
    compiled.normal_sums(*map(address, sparse + dense), len(weights), width, address(sums))
    return sums
