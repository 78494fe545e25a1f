"""Why there is no place to put an object down: the base, the table, or what stands on it."""

import numpy as np

from topple.planner.placement.base import NoBase, choose_base
from topple.planner.placement.placement import Placement, placements
from topple.planner.placement.resting import PLACEMENT_TOLERANCES
from topple.robots.arm.arm import Arm
from topple.robots.arm.home import scale_of, workplace_of
from topple.topology.base.arrays import FloatArray
from topple.topology.bodies.tops import tops_of
from topple.topology.geometry.axes import level_axes
from topple.topology.situation.situation import Situation


def shortage(name: str, situation: Situation, arm: Arm, pose_base_to_world: FloatArray) -> str:
    """Say in a sentence why an object has no place to go.

    Args:
        name: The object.
        situation: Where everything is.
        arm: The arm.
        pose_base_to_world: (4, 4) where it stands.

    Returns:
        Whether there is no table, none large enough, none with room left (and what stands there), or only one
        out of reach (how far it is, and which base would do).
    """
    scene, up = situation.scene, situation.up
    tops = [(other, top) for other in sorted(scene.fixed) for top in tops_of(scene.clouds[other], up).tops]
    if not tops:
        return f"no fixed object has a level surface to put {name} on: name the table with --fixed NAME"
    if places := placements(name, situation):
        return _out_of_reach(name, places, situation, arm, pose_base_to_world)
    others = [other for other in scene.movable if other != name]
    if others and placements(name, situation.without(*others)):
        freeing = [other for other in others if placements(name, situation.without(other))]
        what = f"{' or '.join(freeing)} taken away" if freeing else f"all of {', '.join(others)} taken away"
        return f"every place that is large enough for {name} is taken: with {what} there would be room"
    axes = np.stack(level_axes(up), axis=1)
    sizes = {other: np.ptp(top.points @ axes, axis=0) for other, top in tops}
    widest = max(sizes, key=lambda other: float(np.prod(sizes[other])))
    own, around = np.ptp(scene.clouds[name] @ axes, axis=0), PLACEMENT_TOLERANCES
    least = own + 2.0 * max(around.gap, around.edge)
    return (
        f"no level surface is large enough for {name}: it takes {least[0]:.2f} x {least[1]:.2f} m with room "
        f"for fingers, and the largest, of {widest}, is {sizes[widest][0]:.2f} x {sizes[widest][1]:.2f} m"
    )


def _out_of_reach(
    name: str, places: list[Placement], situation: Situation, arm: Arm, pose_base_to_world: FloatArray
) -> str:
    """How far the nearest free place is, and which base would do."""
    near, far = PLACEMENT_TOLERANCES.reach
    middle = np.append(situation.scene.clouds[name].mean(axis=0), 1.0)
    spots = np.array([(place.pose_before_to_after @ middle)[:3] for place in places])
    distances = np.linalg.norm(spots - (pose_base_to_world @ workplace_of(arm))[:3, 3], axis=1)
    nearest = distances[int(np.argmin(np.maximum(distances - far, near - distances)))]
    words = (
        f"no free place for {name} within reach: the nearest is {nearest:.2f} m from the base, and "
        f"{arm.name} puts things down {near:.2f} to {far:.2f} m from it"
    )
    try:
        base = choose_base(situation, arm, (name,))
    except NoBase:
        return f"{words}; no base was found that reaches {name} at all"
    if not placements(name, situation, pose_base_to_world=base @ workplace_of(arm), scale=scale_of(arm)):
        return f"{words}; no base was found that reaches both {name} and a place for it"
    x, y, z = base[:3, 3]
    yaw = float(np.arctan2(base[1, 0], base[0, 0]))
    upright = base[2, 2] > 1.0 - 1e-9
    where = f"--base {x:.2f} {y:.2f} {z:.2f} {yaw:.2f}" if upright else f"a base at {x:.2f} {y:.2f} {z:.2f}"
    return f"{words}; {where} would do"
