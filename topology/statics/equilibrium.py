"""Static equilibrium with dry friction: a linear programme over contact forces."""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.optimize import linprog
from scipy.sparse import coo_array, csr_array

from topple.topology.base.arrays import BoolArray, FloatArray
from topple.topology.geometry.axes import cross
from topple.topology.statics.contact import Contact
from topple.topology.statics.tolerances import CONE_EDGES, DENSITY


@dataclass(frozen=True, eq=False)
class Weight:
    """What gravity pulls on.

    Attributes:
        litres: Volume [l] of matter of the usual `DENSITY` that is as heavy: only ratios matter here.
        centre: (3,) centre of mass [m], upright frame.
        size: Length [m] that turns a torque into a force one can compare with the weight.
    """

    litres: float
    centre: FloatArray
    size: float

    @property
    def mass(self) -> float:
        """In [kg]."""
        return self.litres * DENSITY / 1e3


@dataclass(frozen=True, eq=False)
class Balance:
    """Answer of the programme.

    Attributes:
        deficit: name -> force and torque that nobody supplies, as a fraction of the weight; 0 for
            what stays in equilibrium.
        loads: Per contact (k,) normal forces, as the litres that weigh as much.
    """

    deficit: Mapping[str, float]
    loads: tuple[FloatArray, ...]


def balance(
    weights: Mapping[str, Weight], contacts: Sequence[Contact], costs: Sequence[FloatArray] | None = None
) -> Balance:
    """Find contact forces that hold every object still, leaving as little unexplained as possible.

    Minimises the sum over objects of the missing wrench divided by the weight, over forces inside
    the friction pyramids. Zero for all means an equilibrium exists: rigid bodies at rest need one.

    Args:
        weights: The objects that can move.
        contacts: Patches between them and with anything fixed; a name without a weight is fixed.
        costs: Per contact (k,) price of a unit of normal force at each point, in deficits per
            weight; nothing costs anything where it is not given.

    Returns:
        The deficits and the loads of one optimal solution.
    """
    priced = [np.zeros(len(contact.gaps)) for contact in contacts] if costs is None else list(costs)
    loads = [np.zeros(len(contact.gaps)) for contact in contacts]
    deficit: dict[str, float] = {}
    weights = by_height(weights)
    for island in islands(weights, contacts):
        part = {name: weight for name, weight in weights.items() if name in island}
        concerned = [k for k, contact in enumerate(contacts) if contact.a in island or contact.b in island]
        held = _balance_island(part, [contacts[k] for k in concerned], [priced[k] for k in concerned])
        deficit |= held.deficit
        for k, load in zip(concerned, held.loads, strict=True):
            loads[k] = load
    return Balance({name: deficit[name] for name in weights}, tuple(loads))


def _balance_island(
    weights: Mapping[str, Weight], contacts: Sequence[Contact], costs: Sequence[FloatArray]
) -> Balance:
    """The balance of one island."""
    names = list(weights)
    matrix, demand, count = equations(weights, contacts)
    price = np.concatenate([_prices(contacts, costs, weights), np.ones(12 * len(names))])
    solution = linprog(
        price, A_eq=matrix, b_eq=demand, bounds=(0, None), method="highs", options={"presolve": False}
    )
    if solution.x is None:  # the slacks make every instance feasible and bounded: a solver failure
        return Balance(dict.fromkeys(names, 1.0), tuple(np.zeros(len(c.gaps)) for c in contacts))
    slack = solution.x[count:].reshape(len(names), 12).sum(axis=1)
    forces = solution.x[:count].reshape(-1, CONE_EDGES).sum(axis=1)
    ends = np.cumsum([len(c.gaps) for c in contacts])[:-1]
    loads = np.split(forces, ends) if len(contacts) else []
    return Balance({name: float(s) for name, s in zip(names, slack, strict=True)}, tuple(loads))


def by_height(weights: Mapping[str, Weight]) -> Mapping[str, Weight]:
    """Some weights, the lowest centre of mass first.

    Where several answers are as good, which one a programme finds hangs on the order of its equations: it
    shall not be the order in which objects happen to be named.

    Args:
        weights: The objects that can move.
    """
    return dict(sorted(weights.items(), key=lambda item: float(item[1].centre[2])))


def islands(
    names: Collection[str], contacts: Sequence[Contact], beside: Collection[str] | None = None
) -> list[frozenset[str]]:
    """Sets of names that contacts join: what holds one set, or how it sinks, does not depend on any other.

    Args:
        names: The objects that can move.
        contacts: Patches; those with anything else join nothing.
        beside: Only the sets that hold one of these; all of them where not given.
    """
    meeting: dict[str, set[str]] = {}
    for contact in contacts:
        if contact.a in names and contact.b in names:
            meeting.setdefault(contact.a, set()).add(contact.b)
            meeting.setdefault(contact.b, set()).add(contact.a)
    found: list[frozenset[str]] = []
    seen: set[str] = set()
    for name in names if beside is None else [name for name in beside if name in names]:
        if name in seen:
            continue
        island, border = {name}, [name]
        while border:
            more = meeting.get(border.pop(), set()) - island
            island |= more
            border += more
        seen |= island
        found.append(frozenset(island))
    return found


def equations(
    weights: Mapping[str, Weight], contacts: Sequence[Contact]
) -> tuple[csr_array, FloatArray, int]:
    """The equations of equilibrium, with slack forces and torques that nobody supplies.

    Args:
        weights: The objects that can move, six equations each, divided by the weight.
        contacts: Patches between them and with anything fixed; a name without a weight is fixed.

    Returns:
        The matrix, what it has to give, and the number of its first columns that are forces along the
        edges of friction pyramids; two slacks per equation, up and down, follow.
    """
    height = 6 * len(weights)
    rows, cols, values, count = force_columns(weights, contacts)
    slack_rows = np.repeat(np.arange(height), 2)
    slack_cols = count + np.arange(2 * height)
    slack_values = np.tile([1.0, -1.0], height)
    matrix = coo_array(
        (
            np.concatenate([values, slack_values]),
            (np.concatenate([rows, slack_rows]), np.concatenate([cols, slack_cols])),
        ),
        shape=(height, count + 2 * height),
    ).tocsr()
    return matrix, demand_of(height), count


def demand_of(height: int) -> FloatArray:
    """Forces and torques asked of contacts: each object's weight, no torque; (height,), six an object."""
    demand = np.zeros(height)
    demand[2::6] = 1.0
    return demand


def _prices(
    contacts: Sequence[Contact], costs: Sequence[FloatArray], weights: Mapping[str, Weight]
) -> FloatArray:
    """Price of each force variable."""
    parts = [np.zeros(0)]
    for contact, cost in zip(contacts, costs, strict=True):
        carried = weights.get(contact.b) or weights[contact.a]
        parts.append(np.repeat(np.asarray(cost, dtype=np.float64) / carried.litres, CONE_EDGES))
    return np.concatenate(parts)


def force_columns(
    weights: Mapping[str, Weight], contacts: Sequence[Contact]
) -> tuple[np.ndarray, np.ndarray, np.ndarray, int]:
    """Find the wrench that each edge of the friction pyramids puts on the two objects it acts between.

    Args:
        weights: The objects that can move, six rows each, divided by the weight.
        contacts: Patches between them and with anything fixed; a name without a weight is fixed.

    Returns:
        Rows, columns and values of the matrix where it is not zero, and the number of its columns.
    """
    if not contacts:
        empty = np.zeros(0, dtype=np.int64)
        return empty, empty, np.zeros(0), 0
    friction = np.repeat([c.friction for c in contacts], [len(c.gaps) for c in contacts])
    exact = np.repeat([c.exact for c in contacts], [len(c.gaps) for c in contacts])
    forces = cone_edges(np.concatenate([c.normals for c in contacts]), friction, exact).reshape(-1, 3)
    points = np.repeat(np.concatenate([c.points for c in contacts]), CONE_EDGES, axis=0)
    each = [CONE_EDGES * len(c.gaps) for c in contacts]
    place = {name: i for i, name in enumerate(weights)}
    centres = np.array([weight.centre for weight in weights.values()])
    sizes = np.array([weight.size for weight in weights.values()])
    litres = np.array([weight.litres for weight in weights.values()])
    rows: list[np.ndarray] = []
    cols: list[np.ndarray] = []
    values: list[np.ndarray] = []
    for side, sign in (([c.a for c in contacts], -1.0), ([c.b for c in contacts], 1.0)):
        pushed = np.repeat([place.get(name, -1) for name in side], each)
        columns = np.flatnonzero(pushed >= 0)
        body = pushed[columns]
        arms, force = points[columns] - centres[body], forces[columns]
        torque = cross(arms, force) / sizes[body, None]
        wrench = sign * np.concatenate([force, torque], axis=1) / litres[body, None]
        rows.append((6 * body[:, None] + np.arange(6)).ravel())
        cols.append(np.repeat(columns, 6))
        values.append(wrench.ravel())
    return np.concatenate(rows), np.concatenate(cols), np.concatenate(values), len(points)


def cone_edges(normals: FloatArray, friction: FloatArray, exact: BoolArray) -> FloatArray:
    """Find the edges of the friction pyramids.

    Of an exact contact one is up the slope, along which most friction is asked for. Where normals are read
    off points the level ones are: corners that noise turns would grip what lies on them.

    Args:
        normals: (k, 3) unit normals into the pushed object.
        friction: (k,) coefficients of friction.
        exact: (k,) which normals are exact.

    Returns:
        (k, E, 3) forces with unit normal part.
    """
    steep = np.abs(normals[:, 2]) < np.where(exact, 0.999, 0.9)
    level = cross(normals, np.where(steep[:, None], [[0.0, 0.0, 1.0]], [[1.0, 0.0, 0.0]]))
    level /= np.linalg.norm(level, axis=1, keepdims=True)
    across = cross(normals, level)
    first = np.where(exact[:, None], across, level)
    second = np.where(exact[:, None], level, across)
    angles = 2 * np.pi * np.arange(CONE_EDGES) / CONE_EDGES
    sideways = first[:, None] * np.cos(angles)[:, None] + second[:, None] * np.sin(angles)[:, None]
    return normals[:, None] + friction[:, None, None] * sideways
