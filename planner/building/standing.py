"""What stands of a part of an arrangement, also where masses are not quite where they are taken to be."""

from dataclasses import replace
from functools import cache

import networkx as nx

from topple.planner.building.prefixes import Falling, Names, aside
from topple.planner.building.tolerances import OFF_CENTRE
from topple.topology.base.arrays import FloatArray
from topple.topology.base.values import FrozenDict
from topple.topology.bodies.complete import is_hollow
from topple.topology.statics.equilibrium import Weight
from topple.topology.statics.holding import deficits
from topple.topology.statics.rest import Statics, within_reach


def falling_in(statics: Statics) -> Falling:
    """Make the function that finds what falls of parts of an arrangement, each asked about once.

    A thing stands where contact forces hold it and it would not sink, with the masses where they seem to be
    and with all of them a little to either side; by how much more than in the whole arrangement, counts.

    Args:
        statics: The finished arrangement at rest.

    Returns:
        (placed, held) -> names.
    """
    every = frozenset(statics.upright.movable)
    centred = {n: replace(weight, centre=_centre(n, statics)) for n, weight in statics.weights.items()}
    shaken = [_with_weights(statics, centred, shift) for shift in aside(OFF_CENTRE)]

    @cache
    def falls(placed: Names, held: Names) -> Names:
        away = every - placed
        if not away:
            return frozenset()
        if sunk := shaken[0].fallen_without(away, held):
            return frozenset(sunk)
        return frozenset(name for each in shaken for name in each.unsteady_without(away, held))

    return falls


def meeting_in(statics: Statics) -> "nx.Graph[str]":
    """Which movable objects are in contact.

    Args:
        statics: The finished arrangement at rest.
    """
    movable = statics.upright.movable
    meeting: nx.Graph[str] = nx.Graph()
    meeting.add_nodes_from(movable)
    meeting.add_edges_from((c.a, c.b) for c in statics.contacts if {c.a, c.b} <= meeting.nodes)
    return meeting


def _centre(name: str, statics: Statics) -> FloatArray:
    """(3,) centre of mass [m]: as given, else that of a solid's hull, of the surface of a hollow thing."""
    if name in statics.upright.centres or is_hollow(statics.upright.clouds[name], statics.sight):
        return statics.weights[name].centre
    from topple.robots.world.bodies import Body  # an order that names no hands asks for none

    return Body.of(name, [statics.surfaces[name]], mass=1.0).centre_of_mass


def _with_weights(statics: Statics, weights: dict[str, Weight], shift: FloatArray) -> Statics:
    """The same with other weights, their centres shifted."""
    there = {name: replace(weight, centre=weight.centre + shift) for name, weight in weights.items()}
    left_open = deficits(there, within_reach(statics.contacts, there))
    return replace(statics, weights=FrozenDict(there), unexplained=FrozenDict(left_open))
