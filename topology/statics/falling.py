"""How far things fall when something is gone: the other side of the programme of static equilibrium.

Force equilibrium asks for contact forces that hold every weight. The dual of that linear programme asks how
far the bodies can sink: it lowers the common potential energy by small displacements and turns that close no
gap further than it is wide. A body that is held does not move; one that is not sinks until it meets what lies
below it: an answer in metres and radians, as the question "did it move?" wants it. Friction appears as in the
forces' pyramids: to slide, a contact has to open by the friction angle (associated flow), which is exact for
what stays at rest.
"""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.optimize import linprog
from scipy.sparse import eye_array, hstack, kron
from scipy.spatial import ConvexHull, QhullError

from topple.topology.base.arrays import FloatArray
from topple.topology.statics.contact import Contact
from topple.topology.statics.equilibrium import Weight, by_height, equations, islands
from topple.topology.statics.holding import Pressing, Search, is_held
from topple.topology.statics.tolerances import (
    CONE_EDGES,
    FARTHEST,
    FREE,
    ROLL,
    SEATED,
    SUNK,
    TILTED,
    TURNED,
)


@dataclass(frozen=True)
class Fall:
    """How far a body sinks.

    Attributes:
        distance: Displacement of the centre of mass [m], at most about `FARTHEST` along each axis.
        angle: Turn [rad], at most about `TURNED` about each axis.
    """

    distance: float
    angle: float

    def beyond(self, before: "Fall") -> float:
        """How far it fell more than `before`, 1 where that just counts as a fall."""
        return max((self.distance - before.distance) / SUNK, (self.angle - before.angle) / TILTED)


def catchers(contacts: Sequence[Contact]) -> tuple[Contact, ...]:
    """The parts of contacts that can stop a body that sinks.

    Args:
        contacts: Patches between bodies, gaps up to `REACH`.

    Returns:
        What is left of them: round things roll no further than `ROLL`, and of a flat patch those points
        whose gaps no others imply.
    """
    level = (contact.only(contact.turns <= ROLL) for contact in contacts)
    return tuple(_outline(contact) for contact in level if contact is not None)


def _outline(contact: Contact) -> Contact:
    """The points of a flat patch that matter.

    A small motion closes gaps linearly across a plane: a gap no smaller than what its neighbours' gaps
    interpolate to never closes first. What is left is the lower convex hull of the gaps over the plane.
    """
    if len(contact.gaps) < 5 or np.ptp(contact.normals, axis=0).max() > 1e-9:
        return contact
    normal = contact.normals[0]
    flat = contact.points - np.outer(contact.points @ normal, normal)
    gaps = np.maximum(contact.gaps - SEATED, 0.0)
    raised = flat + gaps[:, None] * normal
    try:
        # One point far above makes the body's upper side empty, and keeps a level patch from being flat.
        hull = ConvexHull(np.vstack([raised, flat.mean(axis=0) + normal]))
    except QhullError:  # all in one line
        return contact
    keep = np.zeros(len(contact.gaps), dtype=np.bool_)
    keep[hull.vertices[hull.vertices < len(keep)]] = True
    return contact.only(keep) or contact


def falls(
    weights: Mapping[str, Weight],
    contacts: Sequence[Contact],
    beside: Collection[str] | None = None,
    without: Collection[str] = (),
    search: Search | None = None,
) -> dict[str, Fall]:
    """How far every body sinks, all together.

    Args:
        weights: The objects that can move.
        contacts: Patches between them and with anything fixed, from `catchers`.
        beside: Only what hangs together with one of these is asked about; everything where not given.
        without: Names that are gone.
        search: As for `is_held`: what earlier questions about the same contacts left.

    Returns:
        name -> fall, for all that are left and asked about.
    """
    left = {name: weight for name, weight in by_height(weights).items() if name not in without}
    near = [c for c in contacts if c.a not in without and c.b not in without]
    found: dict[str, Fall] = {}
    for island in islands(left, near, beside):
        bodies = {name: weight for name, weight in left.items() if name in island}
        holding = [c for c in near if c.a in island or c.b in island]
        found |= _falls_of_island(bodies, holding, without, search)
    return {name: found[name] for name in weights if name in found}


def _falls_of_island(
    bodies: Mapping[str, Weight], contacts: Sequence[Contact], without: Collection[str], search: Search | None
) -> dict[str, Fall]:
    """How far the bodies of an island sink, from which something may have been taken away.

    What falls is what forces do not hold. How far it sinks a programme says in which all others are fixed, as
    long as these are most: it grows with the cube of the bodies. Where forces hold these that leave less
    than half of the free share over, pressed as they are by what sinks, no motion of theirs is part of a best
    answer: the programme of all has the same ones. Where they do not, what is not held falls as well.

    Args:
        bodies: The objects that are left, rising.
        contacts: Patches between them and with anything fixed.
        without: Names that are gone.
        search: Where searches for forces begin, and what holds an island of which nothing is gone.
    """
    names, falling = frozenset(bodies), frozenset[str]()
    alone: tuple[dict[str, Fall], Pressing] = {}, ()
    kept = search.kept(names) if without and search is not None else None
    wide = False
    while kept is not None:
        # Within half of what is free every motion costs more than it gains.
        more = kept.find_unheld(names - falling, {*without, *falling}, FREE / 2, alone[1], wide)
        if not more:
            return alone[0] | dict.fromkeys(names - falling, Fall(0.0, 0.0))
        if 2 * len(falling | more) <= len(names):
            tried = _sunk_alone(falling | more, bodies, contacts)
            if sinking := frozenset(name for name in more if tried[0][name] != Fall(0.0, 0.0)):
                falling, wide = falling | sinking, False
                alone = tried if sinking == more else _sunk_alone(falling, bodies, contacts)
                continue
        if wide:
            break
        wide = True  # others carry them, with forces that change further away
    seated = [part for c in contacts if (part := c.only(c.gaps <= SEATED)) is not None]
    if kept is None and is_held(bodies, seated, FREE / 2, search, whole=not without):
        return dict.fromkeys(bodies, Fall(0.0, 0.0))
    return _sunk(bodies, contacts)[0]


def _sunk_alone(
    falling: Collection[str], bodies: Mapping[str, Weight], contacts: Sequence[Contact]
) -> tuple[dict[str, Fall], list[tuple[Contact, FloatArray]]]:
    """How far some bodies sink while the others are fixed, and with what forces they press on these."""
    concerned = [c for c in contacts if c.a in falling or c.b in falling]
    found, forces = _sunk({name: w for name, w in bodies.items() if name in falling}, concerned)
    each = np.split(forces, np.cumsum([CONE_EDGES * len(c.gaps) for c in concerned])[:-1])
    pairs = zip(concerned, each, strict=True)
    return found, [(c, f) for c, f in pairs if {c.a, c.b} & bodies.keys() - set(falling)]


def _sunk(left: Mapping[str, Weight], near: Sequence[Contact]) -> tuple[dict[str, Fall], FloatArray]:
    """How far the bodies of an island sink, and the forces along the edges of the contacts' pyramids."""
    matrix, demand, count = equations(left, near)
    litres = np.array([weight.litres for weight in left.values()])
    share = litres / litres.mean()
    size = np.array([weight.size for weight in left.values()])
    # What a missing force costs bounds the displacement it would do work on, and so for torques and turns.
    bound = np.empty((len(left), 6, 2))
    bound[:, :3] = (FARTHEST * share)[:, None, None]
    bound[:, 3:] = (TURNED * share * size)[:, None, None]
    gaps = np.concatenate([np.repeat(c.gaps, CONE_EDGES) for c in near]) if near else np.zeros(count)
    price = np.concatenate([(gaps - SEATED).clip(0.0) / litres.mean(), bound.ravel(), np.zeros(bound.size)])
    free = kron(eye_array(len(demand)), np.array([[1.0, -1.0]]))
    most = np.concatenate([np.full(count + bound.size, np.inf), np.full(bound.size, FREE)])
    solution = linprog(
        price,
        A_eq=hstack([matrix, free], format="csr"),
        b_eq=demand,
        bounds=np.stack([np.zeros_like(most), most], axis=1),
        method="highs",
        options={"presolve": False},  # it takes longer than it saves on programmes this small
    )
    if solution.x is None:  # feasible and bounded by construction: a solver failure
        return dict.fromkeys(left, Fall(0.0, 0.0)), np.zeros(count)
    moved: FloatArray = np.asarray(solution.eqlin.marginals).reshape(-1, 6)
    shifts = np.linalg.norm(moved[:, :3], axis=1) / share
    turns = np.linalg.norm(moved[:, 3:], axis=1) / (share * size)
    falls_of = zip(left, shifts, turns, strict=True)
    return {name: Fall(float(s), float(t)) for name, s, t in falls_of}, np.asarray(solution.x[:count])
