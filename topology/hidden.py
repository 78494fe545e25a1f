"""Contacts no camera saw, which there must be: what is at rest is carried by something."""

from collections.abc import Mapping, Sequence

import numpy as np

from topple.topology.arrays import FloatArray
from topple.topology.contact import TOLERANCES, Contact, Plane
from topple.topology.equilibrium import Weight, balance
from topple.topology.sight import Sight
from topple.topology.upright import Upright

CELL = 0.012
"""Edge [m] of the plan cells in which an underside is held against what lies below it."""

DEEPEST = 0.12
"""Largest gap [m] that is closed: the height of a cup, whose foot may be hidden all the way."""

PRICE = 1.0 / DEEPEST
"""Price per metre of gap: closing the largest one costs as much as carrying nothing."""

LEVEL = 0.006
"""Cells this much [m] further apart than the loaded ones belong to the same hidden contact."""

CARRIED = 0.01
"""Share of its weight from which a hidden point counts as carrying."""


def hidden_contacts(
    upright: Upright,
    surfaces: Mapping[str, FloatArray],
    contacts: Sequence[Contact],
    weights: Mapping[str, Weight],
    wanting: Sequence[str],
    sight: Sight | None,
) -> tuple[Contact, ...]:
    """The cheapest contacts that put everything at rest.

    Every gap between an unseen underside and what lies below it is a contact that may be there; a
    linear programme chooses forces that hold everything still and pays for each by its gap.

    Args:
        upright: The upright scene.
        surfaces: name -> (N, 3) whole surfaces.
        contacts: The contacts found, which cost nothing.
        weights: The movable objects.
        wanting: Objects that the contacts found do not hold.
        sight: What was seen to be empty, or None.

    Returns:
        New contacts, marked as inferred, with gaps counted from the loaded points.
    """
    tops = {name: _plan(points, np.maximum) for name, points in surfaces.items()}
    planes = {name: Plane.of(upright.clouds[name]) for name in upright.fixed}
    candidates: list[Contact] = []
    for name in wanting:
        candidates += _below(name, surfaces, tops, planes, sight)
    if not candidates:
        return ()
    costs = [np.zeros(len(c.gaps)) for c in contacts] + [np.maximum(c.gaps, 0) * PRICE for c in candidates]
    loads = balance(weights, [*contacts, *candidates], costs=costs).loads[len(contacts) :]
    found: list[Contact] = []
    for candidate, load in zip(candidates, loads, strict=True):
        loaded = load > CARRIED * weights[candidate.b].mass
        if loaded.any():
            level = float(candidate.gaps[loaded].max())
            part = candidate.only(candidate.gaps <= level + LEVEL)
            if part is not None:
                gaps = np.maximum(part.gaps - level, 0.0)
                found.append(
                    Contact(part.a, part.b, part.points, part.normals, gaps, part.turns, inferred=True)
                )
    return tuple(found)


def _below(
    name: str,
    surfaces: Mapping[str, FloatArray],
    tops: Mapping[str, dict[tuple[int, int], float]],
    planes: Mapping[str, Plane | None],
    sight: Sight | None,
) -> list[Contact]:
    """For each object under `name`, the cells in which its underside faces the highest top below it."""
    under = _plan(surfaces[name], np.minimum)
    spots = np.array([((i + 0.5) * CELL, (j + 0.5) * CELL, z) for (i, j), z in under.items()])
    facing: dict[str, list[tuple[FloatArray, float]]] = {}
    for spot, cell in zip(spots, under, strict=True):
        best: tuple[float, str] | None = None
        for other, plan in tops.items():
            if other == name:
                continue
            plane = planes.get(other)
            if plane is not None:
                top = float(-(plane.offset + spot[:2] @ plane.normal[:2]) / plane.normal[2])
            else:
                top = plan.get(cell, -np.inf)
            if top <= spot[2] + TOLERANCES.catch and (best is None or top > best[0]):
                best = top, other
        if best is not None and spot[2] - best[0] <= DEEPEST:
            facing.setdefault(best[1], []).append((spot, spot[2] - best[0]))
    found: list[Contact] = []
    for other, pairs in facing.items():
        points = np.array([p for p, _ in pairs])
        gaps = np.array([g for _, g in pairs])
        points[:, 2] -= np.maximum(gaps, 0)
        if sight is not None:
            middle = points + np.array([0.0, 0.0, 1.0]) * (gaps / 2)[:, None]
            keep = ~sight.empty(middle) | (gaps < TOLERANCES.catch)
            points, gaps = points[keep], gaps[keep]
        if len(points):
            up = np.tile([0.0, 0.0, 1.0], (len(points), 1))
            found.append(Contact(other, name, points, up, gaps, np.zeros(len(gaps)), inferred=True))
    return found


def _plan(points: FloatArray, extreme: np.ufunc) -> dict[tuple[int, int], float]:
    """Highest (or lowest) height per plan cell."""
    cells = np.floor(points[:, :2] / CELL).astype(np.int64)
    unique, inverse = np.unique(cells, axis=0, return_inverse=True)
    heights = np.full(len(unique), -np.inf if extreme is np.maximum else np.inf)
    extreme.at(heights, inverse.ravel(), points[:, 2])
    return {(int(i), int(j)): float(z) for (i, j), z in zip(unique, heights, strict=True)}
