"""Grasp candidates of one object of a scene, best first."""

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from topple.planner.grasp.grasp import Grasp
from topple.planner.grasp.shape import Shape, Sought, coming_unseen, shapes_of
from topple.planner.grasp.surroundings import Dropped
from topple.planner.grasp.tolerances import GRASP_TOLERANCES
from topple.topology.base.arrays import FloatArray
from topple.topology.base.errors import InvalidInput, UnknownObject
from topple.topology.scene.scene import Scene
from topple.topology.situation.situation import Situation

if TYPE_CHECKING:
    from topple.robots.arm.arm import Arm


def grasp_candidates(
    name: str,
    scene: Scene | Situation,
    arm: "Arm | None" = None,
    *,
    tools: Sequence[Shape] | None = None,
    wide: bool = False,
    limit: int = 60,
    enough: float = np.inf,
    dropped: Dropped | None = None,
    out: FloatArray | None = None,
) -> list[Grasp]:
    """Find where an object can be taken hold of in its present surroundings.

    Pinches are looked for at points spread over the object, across its narrow sides, straight against its way
    out, which is mostly down, and tilted; suction on smooth patches that face up, and where that is sure to
    hold, no pinch is looked for. Hands that would meet the object, its neighbours or the table on the way in
    are left out; grasps that its weight, given or likely, would turn in the hand come last; there are none of
    what is given to be heavier than the hand can hold. What the arm can reach is not asked here.

    Args:
        name: The object.
        scene: Everything around it, with `up`, or the situation it was read as.
        arm: The arm whose tools are measured; or give these.
        tools: What to grasp with, what is spare last.
        wide: Come in with the fingers as far apart as there is room: the object is larger than it looks.
        limit: At most so many, spread over the object.
        enough: Once so many pinches are found that brush by nothing no further points of the object are
            tried: those around its centre of mass come first.
        dropped: Takes down what is left out and why, if given.
        out: (3,) unit vector against which fingers come in; the way out of the object where None.

    Returns:
        Grasps in the world, best first, those that come in through space that no camera saw to be empty after
        all others; empty where nothing can be held. Deterministic.

    Raises:
        UnknownObject: The scene has no such object.
        InvalidInput: The scene has no up direction, or the arm has no tool.
    """
    situation = Situation.of(scene)
    scene = situation.scene
    if name not in scene.clouds:
        raise UnknownObject(name, scene.names)
    if tools is None:
        tools = [] if arm is None else list(shapes_of(arm).values())
    if not tools:
        raise InvalidInput("nothing to grasp with: give an arm with tools, or tools")
    dropped = Dropped() if dropped is None else dropped
    sought = Sought.of(name, situation, dropped, enough, out)
    mass, friction = scene.masses.get(name), scene.friction.get(name)
    strong = list[Shape]()
    for shape in tools:
        if words := shape.too_heavy(mass, friction):
            dropped.note(words)
        else:
            strong.append(shape)
    found: list[Grasp] = []
    for shape in strong:
        sealed = sum(grasp.score >= GRASP_TOLERANCES.sure for grasp in found)
        if not shape.spare or sealed < GRASP_TOLERANCES.enough_sealed:
            found += shape.grasps(sought)
    unseen = coming_unseen(found, situation, {shape.tool.name: shape for shape in strong})
    found = [replace(grasp, unseen=hidden) for grasp, hidden in zip(found, unseen.tolist(), strict=True)]
    best = pick_varied(found, limit)
    for shape in strong if wide else ():
        best = shape.widened(best, sought)
    return best


def pick_varied(grasps: Sequence[Grasp], limit: int) -> list[Grasp]:
    """Pick the best of some grasps.

    Args:
        grasps: Of one object.
        limit: At most so many.

    Returns:
        Best first, those that come unseen last, without near copies (within 6 mm and 10 degrees of a better
        one of the same tool).
    """
    ordered = sorted(grasps, key=lambda grasp: (grasp.unseen, -grasp.score))
    if not ordered:
        return []
    poses = np.array([grasp.pose_tool_to_world for grasp in ordered])
    tools = np.array([grasp.tool for grasp in ordered])
    kept: list[int] = []
    for number in range(len(ordered)):
        offsets = poses[kept, :3, 3] - poses[number, :3, 3]
        near = (tools[kept] == tools[number]) & ((offsets * offsets).sum(axis=1) < 0.006**2)
        alike = np.einsum("kij,ij->k", poses[kept, :3, :3][near], poses[number, :3, :3])
        if not (alike > 1.0 + 2.0 * np.cos(0.17)).any():
            kept.append(number)
        if len(kept) >= limit:
            break
    return [ordered[number] for number in kept]
