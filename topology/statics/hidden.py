"""Contacts no camera saw, which there must be: what is at rest is carried by something."""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace

import numpy as np

from topple.topology.base.arrays import FloatArray, bounds
from topple.topology.bodies.upright import Upright
from topple.topology.geometry.tolerances import BEFORE
from topple.topology.kernels.heights import heights_over
from topple.topology.statics.contact import TOLERANCES, Contact, with_friction
from topple.topology.statics.equilibrium import Weight, balance
from topple.topology.statics.grounds import Plane, planes_and_rest
from topple.topology.statics.tolerances import CARRIED, DEEPEST, LEVEL, PLAN_CELL
from topple.topology.views.free_space import FreeSpace

PRICE = 1.0 / DEEPEST
"""Price per metre of gap: closing the largest one costs as much as carrying nothing."""


def hidden_contacts(
    upright: Upright,
    surfaces: Mapping[str, FloatArray],
    contacts: Sequence[Contact],
    weights: Mapping[str, Weight],
    wanting: Sequence[str],
    sight: FreeSpace | None,
    among: Collection[frozenset[str]] | None = None,
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
        among: The pairs that may meet; all of them where not given.

    Returns:
        New contacts, marked as inferred, with gaps counted from the loaded points.
    """
    candidates: list[Contact] = []
    for name in wanting:
        below = _below(name, surfaces[name], _Tops.under(name, upright, surfaces), sight)
        candidates += [
            with_friction(contact, upright.friction)
            for contact in below
            if among is None or frozenset((contact.a, contact.b)) in among
        ]
    if not candidates:
        return ()
    costs = [np.zeros(len(c.gaps)) for c in contacts] + [np.maximum(c.gaps, 0) * PRICE for c in candidates]
    loads = balance(weights, [*contacts, *candidates], costs=costs).loads[len(contacts) :]
    found: list[Contact] = []
    for candidate, load in zip(candidates, loads, strict=True):
        loaded = load > CARRIED * weights[candidate.b].litres
        if loaded.any():
            level = float(candidate.gaps[loaded].max())
            part = candidate.only(candidate.gaps <= level + LEVEL)
            if part is not None:
                gaps = np.maximum(part.gaps - level, 0.0)
                found.append(replace(part, gaps=gaps))
    return tuple(found)


class _Tops:
    """What stands highest over each plan cell: tables everywhere, other surfaces where they have points.

    Cells begin where the object does that is asked about: the same ones wherever it is, whatever else is.
    """

    @staticmethod
    def under(name: str, upright: Upright, surfaces: Mapping[str, FloatArray]) -> "_Tops":
        """Those of the surfaces that are over or under an object, or fixed."""
        lower, upper = (corner[:2] for corner in bounds(surfaces[name]))
        near: dict[str, FloatArray] = {}
        for other, points in surfaces.items():
            least, most = (corner[:2] for corner in bounds(points))
            if other in upright.fixed or ((least <= upper + PLAN_CELL) & (lower - PLAN_CELL <= most)).all():
                near[other] = points
        return _Tops(upright, near, lower - BEFORE)

    def __init__(self, upright: Upright, surfaces: Mapping[str, FloatArray], corner: FloatArray) -> None:
        self.corner = corner
        self._planes: list[tuple[int, str, Plane]] = []
        self._cells: dict[tuple[int, int], list[tuple[int, str, float]]] = {}
        for order, (name, points) in enumerate(surfaces.items()):
            planes, sides = planes_and_rest(upright, name) if name in upright.fixed else ((), points)
            self._planes += [(order, name, plane) for plane in planes]
            for cell, height in _plan(sides, True, corner).items():
                self._cells.setdefault(cell, []).append((order, name, height))

    def below(self, name: str, cell: tuple[int, int], spot: FloatArray) -> tuple[float, str] | None:
        """Height and name of what is highest below a spot (3,), other than the object itself."""
        options = self._cells.get(cell, []) + [
            (order, other, float(-(plane.offset + spot[:2] @ plane.normal[:2]) / plane.normal[2]))
            for order, other, plane in self._planes
            if not plane.ends or plane.over(spot[None])[0]
        ]
        fitting = [
            (top, -order, other)
            for order, other, top in options
            if other != name and top <= spot[2] + TOLERANCES.catch
        ]
        if not fitting:
            return None
        top, _, other = max(fitting)
        return top, other


def _below(name: str, surface: FloatArray, tops: _Tops, sight: FreeSpace | None) -> list[Contact]:
    """For each object under `name`, the cells in which its underside faces the highest top below it."""
    under = _plan(surface, False, tops.corner)
    x, y = tops.corner
    spots = np.array(
        [(x + (i + 0.5) * PLAN_CELL, y + (j + 0.5) * PLAN_CELL, z) for (i, j), z in under.items()]
    )
    facing: dict[str, list[tuple[FloatArray, float]]] = {}
    for spot, cell in zip(spots, under, strict=True):
        best = tops.below(name, cell, spot)
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


def _plan(points: FloatArray, highest: bool, corner: FloatArray) -> dict[tuple[int, int], float]:
    """Highest (or lowest) height per plan cell."""
    if len(points) == 0:
        return {}
    first, last = (np.floor((each[:2] - corner) / PLAN_CELL).astype(np.int64) for each in bounds(points))
    heights = heights_over(points, corner, PLAN_CELL, last - first + 1, highest, first)
    cells = np.argwhere(np.isfinite(heights))
    return dict(zip(map(tuple, (cells + first).tolist()), heights[tuple(cells.T)].tolist(), strict=True))
