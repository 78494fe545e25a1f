"""How far what stands is from falling: its weight aside, the ground tilted, a push at its top."""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np
from scipy.optimize import Bounds, LinearConstraint, milp  # as a linear programme: half the overhead
from scipy.sparse import block_diag, csc_array, hstack

from topple.planner.stability.footing import Footing
from topple.planner.stability.tolerances import FARTHEST, ROLLS_FROM, STEEPEST, STRONGEST, WAYS
from topple.planner.stability.verdicts import find_held, judge_fallen
from topple.robots.arm.tolerances import GRAVITY
from topple.topology.base.arrays import FloatArray
from topple.topology.geometry.axes import around
from topple.topology.geometry.sides import inset
from topple.topology.statics.contact import Contact
from topple.topology.statics.equilibrium import balance, by_height, demand_of, force_columns, islands
from topple.topology.statics.tolerances import CONE_EDGES, DENSITY

Direction = tuple[float, float, float]


@dataclass(frozen=True)
class Margins:
    """What an object at rest withstands.

    Attributes:
        centre: How far its centre of mass may be aside, in the worst level direction [m].
        tilt: By how much the ground may be tilted until something it stands with moves [rad].
        push: Least level push at the top of it, or of anything above it, that moves something [N].
        aside: (3,) the level direction in the world in which its centre may be aside least.
        pushed: (3,) the direction of the least push.
    """

    centre: float
    tilt: float
    push: float
    aside: Direction
    pushed: Direction


@dataclass(frozen=True)
class Carry:
    """What carries an object.

    Attributes:
        name: The carrier.
        force: Normal force on the object [N]; forces that are not determined are shared in some way.
        at: (3,) middle of the contact in the world [m].
        points: Corners of the contact.
        inferred: Whether no camera saw it.
    """

    name: str
    force: float
    at: Direction
    points: int
    inferred: bool


class Island:
    """Objects that hang together and stand, and the forces between them.

    Attributes:
        names: The objects, rising.
    """

    def __init__(self, footing: Footing, names: Collection[str], contacts: Sequence[Contact]) -> None:
        """Keep the equations of the objects; everything else is fixed."""
        self._footing = footing
        self.weights = by_height({name: footing.weights[name] for name in names})
        self.names = tuple(self.weights)
        self.contacts = [c for c in contacts if c.a in self.weights or c.b in self.weights]

    @cached_property
    def _matrix(self) -> csc_array:
        rows, columns, values, count = force_columns(self.weights, self.contacts)
        return csc_array((values, (rows, columns)), shape=(6 * len(self.names), count))

    @property
    def _count(self) -> int:
        return CONE_EDGES * sum(len(contact.gaps) for contact in self.contacts)

    def most(self, loads: Sequence[FloatArray], limit: float) -> FloatArray:
        """Find how much of each of some loads forces can give besides the weights: one programme for all.

        Args:
            loads: (6 n,) what one of a load demands, six an object, in weights.
            limit: Largest multiple looked for.

        Returns:
            (K,) the multiples; zeros where forces do not give the weights alone, as noise may have it.
        """
        return np.zeros(len(loads)) if (found := self._multiples(loads, limit, 1)) is None else found

    @cached_property
    def balanced(self) -> bool:
        """Whether forces give the weights as they are, with nothing conceded to noise."""
        return self._multiples([np.zeros(6 * len(self.names))], 0.0, 1) is not None

    def least(self, load: FloatArray, limit: float) -> float | None:
        """The least multiple of a load (6 n,) besides the weights that forces give; None where none."""
        found = self._multiples([load], limit, -1)
        return None if found is None else float(found[0])

    def _multiples(self, loads: Sequence[FloatArray], limit: float, sign: int) -> FloatArray | None:
        height, count = 6 * len(self.names), self._count
        each = [hstack([self._matrix, csc_array(-load[:, None])]) for load in loads]
        columns = block_diag(each, format="csc")
        price, upper = np.zeros(len(loads) * (count + 1)), np.full(len(loads) * (count + 1), np.inf)
        price[count :: count + 1], upper[count :: count + 1] = -sign, limit
        demand: Any = np.tile(demand_of(height), len(loads))
        bounds: Any = Bounds(0.0, upper)  # type: ignore[arg-type]
        equal = LinearConstraint(columns, demand, demand)
        found = milp(price, constraints=equal, bounds=bounds, options={"presolve": False})
        return None if found.x is None else np.asarray(found.x[count :: count + 1])

    def _rows(self, name: str) -> slice:
        start = 6 * self.names.index(name)
        return slice(start, start + 6)

    def centre_margin(self, name: str) -> tuple[float, Direction]:
        """How far the centre of mass of an object may be aside in the worst direction [m], and that."""
        ways = around(WAYS)
        reach = self.asides(name, ways)
        inner = inset(ways * reach[:, None], np.zeros((1, 2))) if reach.min() > 0 else np.zeros(1)
        return self._footing.unit * max(float(inner[0]), 0.0), self._direction(ways[reach.argmin()])

    def asides(self, name: str, ways: FloatArray) -> FloatArray:
        """How far (K,) the centre of mass of an object may be aside along ways (K, 2) [m]."""
        return self.most([self.aside(name, way) for way in ways], FARTHEST / self._footing.unit)

    def aside(self, name: str, way: FloatArray) -> FloatArray:
        """(6 n,) what forces have to give besides where a weight is a metre aside along (2,)."""
        direction = np.zeros(6 * len(self.names))
        size = self.weights[name].size
        direction[self._rows(name)] = np.array([0, 0, 0, way[1], -way[0], 0]) / size
        return direction

    def push_margin(self, name: str, top: float) -> tuple[float, Direction]:
        """Least level push at a height [m] over the centre of mass of an object [N], and where to."""
        ways = around(WAYS)
        most = self.pushes(name, top, ways)
        newton = float(most.min()) * self.weights[name].mass * self._footing.unit**3 * GRAVITY
        return newton, self._direction(ways[most.argmin()])

    def _direction(self, way: FloatArray) -> Direction:
        """A level direction (2,) of the frame of the contacts, in the world."""
        x, y, z = (np.append(way, 0.0) @ self._footing.rotation).tolist()
        return x, y, z

    def pushes(self, name: str, top: float, ways: FloatArray) -> FloatArray:
        """Most level pushes (K,) along ways (K, 2), `top` [m] over an object's centre, in its weights."""
        weight, pushes = self.weights[name], list[FloatArray]()
        for way in ways:
            force = np.append(way, 0.0)
            push = np.zeros(6 * len(self.names))
            push[self._rows(name)] = -np.append(force, np.cross([0.0, 0.0, top], force) / weight.size)
            pushes.append(push)
        return self.most(pushes, STRONGEST)

    @cached_property
    def tilt_margin(self) -> float:
        """By how much the ground may be tilted [rad]."""
        return float(np.arctan(self.slopes(around(WAYS)).min()))

    def slopes(self, ways: FloatArray) -> FloatArray:
        """Steepest slopes (K,) of the ground along ways (K, 2), as tangents."""
        slopes = np.zeros((len(ways), len(self.names), 6))
        slopes[..., :2] = ways[:, None]
        return self.most(list(slopes.reshape(len(ways), -1)), STEEPEST)

    def loads(self) -> Mapping[str, tuple[Carry, ...]]:
        """Carriers of each object: those below it, or those that hold it from beside where none is."""
        footing, below = self._footing, {name: list[Carry]() for name in self.names}
        beside = {name: list[Carry]() for name in self.names}
        loads = balance(self.weights, self.contacts).loads
        for contact, load in zip(self.contacts, loads, strict=True):
            force = float(load.sum())
            if force <= 1e-6 * min(w.litres for w in self.weights.values()):
                continue
            middle = load @ contact.points / force
            for name, other in ((contact.a, contact.b), (contact.b, contact.a)):
                if name in below:
                    where = below if footing.carries(contact, name) else beside
                    where[name].append(self.carry(other, contact, force, middle))
        return {name: tuple(below[name] or beside[name]) for name in self.names}

    def carry(self, carrier: str, contact: Contact, litres: float, middle: FloatArray) -> Carry:
        """Describe a carrier of so many litres of the usual matter at a point (3,) of the upright frame."""
        unit = self._footing.unit
        x, y, z = (middle @ self._footing.rotation * unit).tolist()
        newton = litres * DENSITY / 1e3 * unit**3 * GRAVITY
        return Carry(carrier, newton, (x, y, z), len(contact.gaps), contact.inferred)

    def by_friction(self, name: str) -> bool:
        """Whether an object stands by friction alone: on polished sides it would not."""
        smooth = [replace(c, friction=0.0) if name in (c.a, c.b) else c for c in self.contacts]
        return name not in find_held(self._footing, self.names, smooth)

    def falls_without(self, name: str) -> tuple[str, ...]:
        """Objects that do not stand where another is gone."""
        left = [contact for contact in self.contacts if name not in (contact.a, contact.b)]
        return tuple(judge_fallen(self._footing, [other for other in self.names if other != name], left))

    def above(self, name: str) -> frozenset[str]:
        """Objects that stand on an object, directly or not."""
        found: set[str] = set()
        border = [name]
        while border:
            low = border.pop()
            more = {n for n in self.names if low in self._carriers[n]} - found
            found |= more
            border += more
        return frozenset(found - {name})

    @cached_property
    def _carriers(self) -> Mapping[str, list[str]]:
        return {name: self._footing.carriers(name, self.contacts) for name in self.names}


def islands_of(footing: Footing, names: Collection[str], contacts: Sequence[Contact]) -> list[Island]:
    """The objects that stand, in sets that hang together."""
    weights = {name: footing.weights[name] for name in footing.weights if name in names}
    near = [c for c in contacts if c.a in weights or c.b in weights]
    return [Island(footing, island, near) for island in islands(weights, near)]


def beyond_support(
    footing: Footing, name: str, contacts: Sequence[Contact]
) -> tuple[FloatArray, float] | None:
    """The least level shift of an object's weight with which what is beside it would hold it.

    Args:
        footing: What holds the scene up.
        name: The object.
        contacts: What is there.

    Returns:
        (2,) direction in the upright frame, and how far [m]; None where none would.
    """
    alone = Island(footing, [name], contacts)
    best: tuple[FloatArray, float] | None = None
    for way in around(2 * WAYS):
        least = alone.least(alone.aside(name, way), FARTHEST / footing.unit)
        if least is not None and (best is None or least * footing.unit < best[1]):
            best = way, max(least * footing.unit, ROLLS_FROM)
    return best
