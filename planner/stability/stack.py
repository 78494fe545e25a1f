"""Stacks: islands in which each object stands on one other, level. What they withstand needs no programme.

All that is above a contact weighs on it as one, so its common centre of mass has to stay over that contact's
outline and its common weight sets the friction there: forces are determined.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from topple.planner.stability.footing import Footing
from topple.planner.stability.margins import Carry, Island
from topple.planner.stability.tolerances import FARTHEST, LEVEL, STEEPEST, STRONGEST
from topple.topology.base.arrays import FloatArray
from topple.topology.geometry.sides import beyond, sides_of
from topple.topology.statics.contact import Contact
from topple.topology.statics.equilibrium import Weight


@dataclass(frozen=True, eq=False)
class _Base:
    """What an object stands on with all that is above it.

    Attributes:
        carried: The object.
        contact: With what carries it.
        sides: (F, 3) outward sides of the contact.
        height: Of it [m].
        litres: Weight of all that it carries, as the litres that weigh as much.
        centre: (3,) common centre of mass of that [m].
    """

    carried: str
    contact: Contact
    sides: FloatArray
    height: float
    litres: float
    centre: FloatArray

    @property
    def carrier(self) -> str:
        """Name of the body below."""
        return self.contact.a if self.contact.b == self.carried else self.contact.b

    @property
    def overhang(self) -> float:
        """How far the common centre of mass is beyond the outline [m], negative inside."""
        return float(beyond(self.sides, self.centre[:2]))

    def reach(self, ways: FloatArray) -> FloatArray:
        """How far the common centre of mass may go along ways (K, 2) [m]."""
        apart = -(self.sides[:, :2] @ self.centre[:2] + self.sides[:, 2])[:, None]
        closing = self.sides[:, :2] @ ways.T
        return np.where(closing > 1e-9, apart / np.maximum(closing, 1e-9), np.inf).min(axis=0)


class Stack(Island):
    """An island of which each object stands on one other one, level."""

    def __init__(self, footing: Footing, island: Island, bases: Mapping[str, _Base]) -> None:
        """Keep what each object stands on; see `as_stack`."""
        super().__init__(footing, island.names, island.contacts)
        self._bases = bases
        self.balanced = True  # type: ignore[misc]  # that is what `as_stack` saw to

    def _below(self, name: str) -> list[_Base]:
        """Bases below an object, from its own down."""
        found: list[_Base] = []
        while name in self._bases:
            found.append(self._bases[name])
            name = found[-1].carrier
        return found

    def asides(self, name: str, ways: FloatArray) -> FloatArray:
        """How far (K,) the centre of mass of an object may be aside along ways (K, 2) [m]."""
        own = self.weights[name].litres
        reach = np.min([base.reach(ways) * (base.litres / own) for base in self._below(name)], axis=0)
        return np.minimum(reach, FARTHEST / self._footing.unit)

    def pushes(self, name: str, top: float, ways: FloatArray) -> FloatArray:
        """Most level pushes (K,) along ways (K, 2), `top` [m] over an object's centre, in its weights."""
        own, height = self.weights[name].litres, self.weights[name].centre[2] + top
        most = np.full(len(ways), STRONGEST)
        for base in self._below(name):
            tips = base.reach(ways) / max(height - base.height, 1e-9)
            most = np.minimum(most, np.minimum(tips, base.contact.friction) * (base.litres / own))
        return most

    def slopes(self, ways: FloatArray) -> FloatArray:
        """Steepest slopes (K,) of the ground along ways (K, 2), as tangents."""
        most = np.full(len(ways), STEEPEST)
        for base in self._bases.values():
            tips = base.reach(ways) / max(float(base.centre[2]) - base.height, 1e-9)
            most = np.minimum(most, np.minimum(tips, base.contact.friction))
        return most

    def loads(self) -> Mapping[str, tuple[Carry, ...]]:
        """Carrier of each object."""
        middles = {name: np.append(base.centre[:2], base.height) for name, base in self._bases.items()}
        return {
            name: (self.carry(base.carrier, base.contact, base.litres, middles[name]),)
            for name, base in self._bases.items()
        }

    def by_friction(self, name: str) -> bool:
        """Never: what is level needs none."""
        return False

    def falls_without(self, name: str) -> tuple[str, ...]:
        """Objects above it, and those it was the counterweight of."""
        gone = {name, *self.above(name)}
        for lower in [each.carried for each in self._below(name)][1:]:
            every = {lower, *self.above(lower)}
            left = [self.weights[each] for each in every - gone]
            if _base(self._bases[lower].contact, self._bases[lower].sides, lower, left).overhang > 0:
                gone |= every
        return tuple(other for other in self._footing.weights if other in gone - {name})


def as_stack(footing: Footing, island: Island) -> Island:
    """The island as a stack, if it is one whose weights are over their contacts; else as it is."""
    under: dict[str, Contact] = {}
    for contact in island.contacts:
        up = float(contact.normals[0, 2])
        upper = contact.b if up > 0 else contact.a
        level = np.abs(contact.normals[:, 2]).min() >= LEVEL and np.ptp(np.sign(contact.normals[:, 2])) == 0
        if not level or upper in under or upper not in island.weights:
            return island
        under[upper] = contact
    if under.keys() != island.weights.keys():
        return island
    bases: dict[str, _Base] = {}
    for name, contact in under.items():
        sides = sides_of(contact.points[:, :2])
        loaded = [island.weights[each] for each in (name, *island.above(name))]
        base = None if sides is None else _base(contact, sides, name, loaded)
        if base is None or base.overhang > 0:
            return island
        bases[name] = base
    return Stack(footing, island, bases)


def _base(contact: Contact, sides: FloatArray, name: str, loaded: list[Weight]) -> _Base:
    litres = np.array([weight.litres for weight in loaded])
    centre = litres @ np.array([weight.centre for weight in loaded]) / litres.sum()
    return _Base(name, contact, sides, float(contact.points[:, 2].mean()), float(litres.sum()), centre)
