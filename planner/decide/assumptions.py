"""What an order takes for granted: said in sentences, since a scene rarely shows everything."""

from functools import cache
from typing import TYPE_CHECKING

import numpy as np

from topple.planner.decide.tolerances import BELOW, DEEP, LEAST, SHARE, SUNK
from topple.topology.base.arrays import FloatArray, bounds
from topple.topology.bodies.complete import is_hollow
from topple.topology.geometry.broadphase import near_both_ways
from topple.topology.geometry.sides import beyond, sides_of
from topple.topology.scene.tolerances import FRICTION
from topple.topology.statics.grounds import planes_and_rest
from topple.topology.statics.rest import Statics, volume_around
from topple.topology.statics.tolerances import DENSEST, DENSITY

if TYPE_CHECKING:
    from topple.topology.scene.scene import Scene


def assumptions(scene: "Scene", statics: Statics) -> tuple[str, ...]:
    """List the assumptions about gravity and bodies.

    Args:
        scene: The scene.
        statics: The scene at rest.

    Returns:
        Sentences: no fixed object, objects below the table, in it, or carried by nothing, overlapping clouds;
        weights and friction that were not given, and weights that cannot be true.
    """
    said = list(_nothing_fixed(scene))
    for name in statics.upright.movable:
        if statics.surfaces[name][:, 2].max() < statics.upright.floor - BELOW:
            said.append(f"{name} lies below the table's surface")
        elif statics.unexplained.get(name, 0.0) > 0.5:
            said.append(f"nothing seen carries {name}: it is taken to be held by something no camera saw")
    return (*said, *_sunk(statics), *_overlaps(statics), *_heavy(scene, statics), *_unknown_amounts(scene))


def _heavy(scene: "Scene", statics: Statics) -> tuple[str, ...]:
    """Masses beyond what any matter of that size has: grams or pounds are likely."""
    said: list[str] = []
    for name in (name for name in scene.movable if name in scene.masses):
        volume = volume_around(statics.surfaces[name])
        if scene.masses[name] > DENSEST * max(volume, LEAST):
            said.append(
                f"{name} was given {scene.masses[name]:g} kg in {1e3 * volume:.2g} litres, denser than any "
                "matter: it is taken so; masses are in kilograms"
            )
    return tuple(said)


def _unknown_amounts(scene: "Scene") -> tuple[str, ...]:
    """Weights and friction that were not given."""
    said: list[str] = []
    unweighed = [name for name in scene.movable if name not in scene.masses]
    untried = [name for name in scene.clouds if name not in scene.friction]
    if unweighed:
        left = "masses" if not scene.masses else f"the mass of {', '.join(unweighed)}"
        was = "were" if not scene.masses else "was"
        said.append(f"{left} {was} not given: {DENSITY:g} kg/m³ of what each fills is taken")
    if untried:
        left = "friction" if not scene.friction else f"the friction of {', '.join(untried)}"
        said.append(
            f"{left} was not given: two such surfaces are taken to have a coefficient of {FRICTION:g}"
        )
    return tuple(said)


def _sunk(statics: Statics) -> tuple[str, ...]:
    """Objects part of which is below a flat fixed surface under them, where nothing can be."""
    clouds, said = statics.upright.clouds, list[str]()
    planes = [
        (ground, plane)
        for ground in sorted(statics.upright.fixed)
        for plane in planes_and_rest(statics.upright, ground)[0]
    ]
    for ground, plane in planes:
        for name in statics.upright.movable:
            over = (clouds[name] > [*plane.lower[:2], -np.inf]) & (clouds[name] < [*plane.upper[:2], np.inf])
            if over.all():  # past the edge things may hang lower
                low, high = np.quantile(plane.heights(clouds[name]), (0.02, 0.98))
                if low < -SUNK and high > BELOW:
                    said.append(
                        f"{name} reaches {-100 * low:.0f} cm into {ground}, which no body can: where one of "
                        "them was seen is wrong by as much"
                    )
    return tuple(said)


def _nothing_fixed(scene: "Scene") -> tuple[str, ...]:
    if scene.fixed:
        return ()
    return ("no object is fixed: the lowest objects are taken to stand on a floor at their lowest point",)


def _overlaps(statics: Statics) -> tuple[str, ...]:
    """Pairs of which one lies within the other, which is not hollow: bodies cannot."""
    clouds = statics.upright.clouds
    boxes = {name: bounds(clouds[name]) for name in statics.upright.movable}
    said: list[str] = []
    hollow = cache(lambda name: is_hollow(clouds[name], statics.sight))  # one may have many within it
    sides = cache(lambda name: sides_of(clouds[name]))
    names = statics.upright.movable
    for i, j in near_both_ways([boxes[name] for name in names], DEEP):
        inner, outer = names[i], names[j]
        lower, upper = boxes[outer][0] + DEEP, boxes[outer][1] - DEEP
        if (boxes[inner][0] >= upper).any() or (boxes[inner][1] <= lower).any():
            continue
        boxed = clouds[inner][((clouds[inner] > lower) & (clouds[inner] < upper)).all(axis=1)]
        if len(boxed) <= SHARE * len(clouds[inner]):
            continue
        if _deep(boxed, sides(outer)) > SHARE * len(clouds[inner]) and not hollow(outer):
            said.append(f"the clouds of {inner} and {outer} overlap: both are taken to be where they seem")
    return tuple(said)


def _deep(points: FloatArray, sides: FloatArray | None) -> int:
    """Count the points that lie deep inside a hull; none lies in one without volume."""
    return 0 if sides is None else int(np.count_nonzero(beyond(sides, points) < -DEEP))
