"""Rearranging cubes of one size in layers: what must happen before what."""

from collections.abc import Iterable, Mapping
from itertools import permutations

import numpy as np

from topple.planner.building.prefixes import Falling, Names, aside
from topple.planner.rearranging.problem import Act, Pair, Problem
from topple.planner.rearranging.steady import brace
from topple.topology.base.arrays import FloatArray
from topple.topology.statics.contact import Contact
from topple.topology.statics.equilibrium import Weight
from topple.topology.statics.holding import deficits

HELD = 1e-6
"""Missing share of a weight that still counts as carried: what a solver leaves."""

TABLE = "\n"
"""Under all cubes; no object's name: names have printable characters only."""


def cubes_problem(start: Mapping[str, FloatArray], goal: Mapping[str, FloatArray], side: float) -> Problem:
    """What must happen before what, for upright cubes with parallel edges.

    A cube is lifted straight up, so what is over it goes first, and what is under its place in the goal comes
    first. What is anywhere under, in or over that place at the start is gone by then. Both arrangements stand
    as they are taken apart and put together: a counterweight comes before the load, and leaves after it.

    Args:
        start: name -> (3,) centre; any unit of length.
        goal: The same in the goal.
        side: Of every cube.
    """
    take, put = Act.TAKE, Act.PUT
    pairs: set[Pair] = {((take, a), (take, b)) for b, a in _built(start, side)}
    pairs |= {((put, a), (put, b)) for a, b in _built(goal, side)}
    pairs |= {((take, a), (put, b)) for a, b in permutations(start, 2) if _over(start[a], goal[b], side)}
    moving = tuple(name for name in start if (start[name] != goal[name]).any())
    return Problem(moving, tuple(name for name in start if name not in moving), frozenset(pairs))


def _built(places: Mapping[str, FloatArray], side: float) -> Iterable[tuple[str, str]]:
    """What has to be down before what."""
    return brace(places, _below(places, side), falling_cubes(places, side)).edges


def _below(places: Mapping[str, FloatArray], side: float) -> list[tuple[str, str]]:
    return [
        (a, b)
        for a, b in permutations(places, 2)
        if _over(places[a], places[b], side) and places[a][2] < places[b][2]
    ]


def falling_cubes(places: Mapping[str, FloatArray], side: float, off_centre: float = 0.0) -> Falling:
    """What does not stand of a part of an arrangement of cubes, by static equilibrium.

    Args:
        places: name -> (3,) centre; any unit of length.
        side: Of every cube.
        off_centre: How far all masses may be off the middles along either axis, everything standing.
    """
    shifts = aside(off_centre)[: 5 if off_centre else 1]
    touching = [*_below(places, side), *((TABLE, name) for name in places)]
    contacts = [c for a, b in touching if (c := _contact(a, b, places, side)) is not None]

    def falling(there: Names, held: Names) -> Names:
        near, found = [c for c in contacts if {c.a, c.b} <= {*there, TABLE}], set[str]()
        for shift in shifts:
            weights = {name: Weight(1.0, places[name] + shift, side / 2) for name in there - held}
            found |= {name for name, missing in deficits(weights, near).items() if missing > HELD}
        return frozenset(found)

    return falling


def _contact(a: str, b: str, places: Mapping[str, FloatArray], side: float) -> Contact | None:
    """The rectangle in which one cube, or the table, carries another; None where it does not."""
    half, foot = side / 2, places[b] - [0.0, 0.0, side / 2]
    if a != TABLE and abs(places[b][2] - places[a][2] - side) > 1e-6 * side:
        return None
    if a == TABLE and foot[2] > 1e-6 * side:
        return None
    low, high = places[b][:2] - half, places[b][:2] + half
    if a != TABLE:
        low, high = np.maximum(low, places[a][:2] - half), np.minimum(high, places[a][:2] + half)
    corners = np.array([[x, y, foot[2]] for x in (low[0], high[0]) for y in (low[1], high[1])])
    return Contact(a, b, corners, np.tile([0.0, 0.0, 1.0], (4, 1)), np.zeros(4), np.zeros(4))


def _over(a: FloatArray, b: FloatArray, side: float) -> bool:
    """Whether two cubes overlap seen from above."""
    return bool((abs(a - b)[:2] < side * (1 - 1e-6)).all())
