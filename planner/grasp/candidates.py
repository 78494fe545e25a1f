"""Grasp candidates of one object of a scene, best first."""

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from topple.planner.grasp.fingers import coming_unseen, standing_in
from topple.planner.grasp.frames import frames
from topple.planner.grasp.grasp import Grasp, GraspKind
from topple.planner.grasp.hand import HandShape, hand_shape
from topple.planner.grasp.load import BY_CUP, BY_PADS, beyond_hand, chance_to_hold, cup_load, weight_of
from topple.planner.grasp.pinch import Pinch, pinches
from topple.planner.grasp.rims import rim_frames
from topple.planner.grasp.score import HOLD, score_of
from topple.planner.grasp.suction import CupShape, cup_shape, patches
from topple.planner.grasp.surface import Surface, surface_in
from topple.planner.grasp.surroundings import Dropped, Surroundings, surroundings
from topple.planner.grasp.tolerances import GRASP_TOLERANCES, GraspTolerances
from topple.planner.grasp.widen import widened
from topple.planner.rounded import rounded
from topple.robots.arm.gripper import ToolName
from topple.topology.base.arrays import FloatArray
from topple.topology.base.errors import InvalidInput, UnknownObject
from topple.topology.geometry.hull import Hull
from topple.topology.scene.scene import Scene
from topple.topology.situation.situation import Situation

if TYPE_CHECKING:
    from topple.robots.arm.arm import Arm

CUP_TURNS: tuple[FloatArray, ...] = tuple(
    np.array([[np.cos(a), -np.sin(a), 0, 0], [np.sin(a), np.cos(a), 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]])
    for a in (0.0, np.pi / 4, np.pi / 2, -np.pi / 4)
)
"""Turns (4, 4) of the hand about the cup's axis; the arm tries each with half a turn more as well."""


def grasp_candidates(
    name: str,
    scene: Scene | Situation,
    arm: "Arm | None" = None,
    *,
    hand: HandShape | None = None,
    cup: CupShape | None = None,
    wide: bool = False,
    limit: int = 60,
    enough: float = np.inf,
    tolerances: GraspTolerances = GRASP_TOLERANCES,
    dropped: Dropped | None = None,
) -> list[Grasp]:
    """Find where an object can be taken hold of in its present surroundings.

    Pinches are looked for at points spread over the object, across its narrow sides, straight down and
    tilted; suction on smooth patches that face up, and where that is sure to hold, no pinch is looked for.
    Hands that would meet the object, its neighbours or the table on the way in are left out; grasps that its
    weight, given or likely, would turn in the hand come last; there are none of what is given to be heavier
    than the hand can hold. What the arm can reach is not asked here.

    Args:
        name: The object.
        scene: Everything around it, with `up`, or the situation it was read as.
        arm: The arm whose tools are measured; or give `hand` and `cup`.
        hand: Fingers to grasp with; measured from the arm where not given.
        cup: Suction cup to grasp with; measured from the arm where not given.
        wide: Come in with the fingers as far apart as there is room: the object is larger than it looks.
        limit: At most so many, spread over the object.
        enough: Once so many pinches are found that brush by nothing no further points of the object are
            tried: those around its centre of mass come first.
        tolerances: Clearances and limits.
        dropped: Takes down what is left out and why, if given.

    Returns:
        Grasps in the world, best first, those that come in through space that no camera saw to be empty after
        all others; empty where nothing can be held. Deterministic.

    Raises:
        UnknownObject: The scene has no such object.
        InvalidInput: The scene has no up direction, or the arm has no tool.
    """
    situation = Situation.of(scene)
    scene, up = situation.scene, situation.up
    if name not in scene.clouds:
        raise UnknownObject(name, scene.names)
    if arm is not None:
        hand = hand_shape(arm) if hand is None and ToolName.FINGERS in arm.tools else hand
        cup = cup_shape(arm) if cup is None and ToolName.SUCTION in arm.tools else cup
    if hand is None and cup is None:
        raise InvalidInput("nothing to grasp with: give an arm with tools, a hand or a cup")
    around = surroundings(name, scene, up, tolerances)
    surface = surface_in(name, situation, around, tolerances)
    mass, friction = scene.masses.get(name), scene.friction.get(name)
    surface = replace(surface, mass=mass, centre=scene.centres.get(name, surface.centre))
    if friction is not None:  # pads of rubber have a coefficient of 1, and the product is the object's own
        tolerances = replace(tolerances, friction=friction)
    dropped = Dropped() if dropped is None else dropped
    if cup is not None and (words := beyond_hand(mass, 1.0, cup.max_force / 2.0, BY_CUP)):
        dropped.note(words)
        cup = None
    if hand is not None and (words := beyond_hand(mass, friction, hand.force, BY_PADS)):
        dropped.note(words)
        hand = None
    found: list[Grasp] = []
    if cup is not None:
        found += _suction_grasps(name, scene.clouds[name], surface, around, up, cup, tolerances, dropped)
    sealed = sum(grasp.score >= tolerances.sure for grasp in found)
    if hand is not None and sealed < tolerances.enough_sealed:
        pinched = _pinch_grasps(name, surface, around, up, hand, enough, tolerances, dropped)
        pierced = standing_in(pinched, hand, [Hull.of(part) for part in situation.solids[name]], tolerances)
        clear = [grasp for grasp, bad in zip(pinched, pierced, strict=True) if not bad]
        dropped.note("fingers would stand in what it fills", len(pinched) - len(clear))
        found += clear
    unseen = coming_unseen(found, situation, hand, cup, tolerances)
    found = [replace(grasp, unseen=hidden) for grasp, hidden in zip(found, unseen.tolist(), strict=True)]
    best = varied(found, limit)
    return widened(best, surface, around, up, hand, tolerances) if wide and hand is not None else best


def _pinch_grasps(
    name: str,
    surface: Surface,
    around: Surroundings,
    up: FloatArray,
    hand: HandShape,
    enough: float,
    tolerances: GraspTolerances,
    dropped: Dropped,
) -> list[Grasp]:
    found, roomy = list[Grasp](), 0
    for tilts in (tolerances.tilts, tolerances.steep_tilts):
        if len(found) >= tolerances.enough:
            break
        for directions in frames(surface, up, tilts):
            near = around.near(directions.origin, tolerances.reach)
            pinched = pinches(directions, surface, near, up, hand, tolerances, dropped)
            found += [_as_grasp(name, pinch) for pinch in pinched]
            roomy += sum(pinch.terms["clearance"] == 1.0 for pinch in pinched)
            if roomy >= enough:
                return found
    if len(found) >= tolerances.enough:
        return found
    for directions in rim_frames(surface, around.floor, up, hand, tolerances, dropped):
        near = around.near(directions.origin, tolerances.reach)
        pinched = pinches(directions, surface, near, up, hand, tolerances, dropped)
        found += [_as_grasp(name, pinch) for pinch in pinched]
    return found


def _in_words(load: float) -> str:
    return f"; its weight takes {100 * load:.0f} % of what surely holds it" if load > 1.0 else ""


def _as_grasp(name: str, pinch: Pinch) -> Grasp:
    kind = GraspKind.RIM if pinch.rim else GraspKind.PINCH
    terms = {**pinch.terms, HOLD: float(chance_to_hold(pinch.load, pinch.weighed))}
    score = score_of(kind, terms)
    reason = (
        f"{1e3 * pinch.width:.0f} mm between the pads, tips {rounded(1e3 * pinch.depth)} mm deep; "
        + ", ".join(f"{term} {value:.2f}" for term, value in pinch.terms.items())
        + _in_words(pinch.load)
    )
    return Grasp(name, kind, pinch.pose_tool_to_world, pinch.width, pinch.opening, score, reason, terms)


def _suction_grasps(
    name: str,
    cloud: FloatArray,
    surface: Surface,
    around: Surroundings,
    up: FloatArray,
    cup: CupShape,
    tolerances: GraspTolerances,
    dropped: Dropped,
) -> list[Grasp]:
    found: list[Grasp] = []
    for patch in patches(surface, cloud, around, up, cup, tolerances=tolerances, dropped=dropped):
        arm = surface.centre - patch.pose_tool_to_world[:3, 3]
        lever = float(np.linalg.norm(arm - up * float(arm @ up)))
        tilt = float(np.arccos(np.clip(-patch.pose_tool_to_world[:3, 2] @ up, -1.0, 1.0)))
        load = cup_load(lever, weight_of(surface.volume, surface.mass), cup, tilt)
        reason = f"seal within {1e3 * patch.residual:.1f} mm; " + ", ".join(
            f"{term} {value:.2f}" for term, value in patch.terms.items()
        )
        if score_of(GraspKind.SUCTION, patch.terms) < tolerances.least_seal:
            dropped.note("the seal would leak or peel off")
            continue
        terms = {**patch.terms, HOLD: float(chance_to_hold(load, surface.mass is not None))}
        score = score_of(GraspKind.SUCTION, terms)
        reason += _in_words(load)
        for turn in CUP_TURNS:  # a cup is round: how the hand is turned about it matters to the arm alone
            pose = patch.pose_tool_to_world @ turn
            found.append(Grasp(name, GraspKind.SUCTION, pose, 0.0, cup.opening, score, reason, terms))
    return found


def varied(grasps: Sequence[Grasp], limit: int) -> list[Grasp]:
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
