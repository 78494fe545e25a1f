"""Grasp candidates of one object of a scene, best first."""

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from topple.planner.grasp.frames import frames
from topple.planner.grasp.grasp import Grasp
from topple.planner.grasp.hand import HandShape, hand_shape
from topple.planner.grasp.pinch import Pinch, pinches
from topple.planner.grasp.suction import CupShape, cup_shape, patches, seal_score
from topple.planner.grasp.surface import Surface, surface_of
from topple.planner.grasp.tolerances import GRASP_TOLERANCES, GraspTolerances
from topple.planner.samples import voxel_means
from topple.planner.solids import parts_of
from topple.topology.arrays import FloatArray
from topple.topology.errors import InvalidInput, UnknownObject
from topple.topology.hull import Hull
from topple.topology.scene import Scene

if TYPE_CHECKING:
    from topple.robots.arm import Arm

WEIGHTS = {"antipodality": 0.3, "balance": 0.3, "clearance": 0.15, "depth": 0.15, "upright": 0.1}
"""Exponents of a pinch's terms: one that is nil spoils the grasp alone."""

CUP_TURNS: tuple[FloatArray, ...] = tuple(
    np.array([[np.cos(a), -np.sin(a), 0, 0], [np.sin(a), np.cos(a), 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]])
    for a in (0.0, np.pi / 4, np.pi / 2, -np.pi / 4)
)
"""Turns (4, 4) of the hand about the cup's axis; the arm tries each with half a turn more as well."""


def grasp_candidates(
    name: str,
    scene: Scene,
    arm: "Arm | None" = None,
    *,
    hand: HandShape | None = None,
    cup: CupShape | None = None,
    solids: Mapping[str, Sequence[FloatArray]] | None = None,
    limit: int = 60,
    tolerances: GraspTolerances = GRASP_TOLERANCES,
) -> list[Grasp]:
    """Find where an object can be taken hold of in its present surroundings.

    Pinches are looked for at points spread over the object, across its narrow sides, straight down and
    tilted; suction on smooth patches that face up, and where that is sure to hold, no pinch is looked for.
    Hands that would meet the object, its neighbours or the table on the way in are left out; what the arm
    can reach is not asked here.

    Args:
        name: The object.
        scene: Everything around it, with `up`.
        arm: The arm whose tools are measured; or give `hand` and `cup`.
        hand: Fingers to grasp with; measured from the arm where not given.
        cup: Suction cup to grasp with; measured from the arm where not given.
        solids: Convex parts of the objects in the world, for the centre of mass.
        limit: At most so many, spread over the object.
        tolerances: Clearances and limits.

    Returns:
        Grasps in the world, best first; empty where nothing can be held. Deterministic.

    Raises:
        UnknownObject: The scene has no such object.
        InvalidInput: The scene has no up direction, or the arm has no tool.
    """
    if name not in scene.clouds:
        raise UnknownObject(name, scene.names)
    if scene.up is None:
        raise InvalidInput("grasps need to know where up is: give --up X Y Z or a fixed table")
    if arm is not None:
        hand = hand_shape(arm) if hand is None and "fingers" in arm.tools else hand
        cup = cup_shape(arm) if cup is None and "suction" in arm.tools else cup
    if hand is None and cup is None:
        raise InvalidInput("nothing to grasp with: give an arm with tools, a hand or a cup")
    up = np.asarray(scene.up, dtype=np.float64)
    solid = parts_of(scene.clouds[name], scene) if solids is None else solids.get(name, ())
    others, floor = surroundings(name, scene, up, tolerances)
    surface = surface_of(scene.clouds[name], up, scene.viewpoints, solid, others, tolerances)
    found: list[Grasp] = []
    if cup is not None:
        found += _suction_grasps(name, scene.clouds[name], surface, others, up, cup, tolerances)
    sealed = sum(grasp.score >= tolerances.sure for grasp in found)
    if hand is not None and sealed < tolerances.enough_sealed:
        pinched = _pinch_grasps(name, surface, others, floor, up, hand, tolerances)
        hulls = [Hull.of(part) for part in solid]
        found += [grasp for grasp in pinched if not _pierces(grasp, hand, hulls, tolerances)]
    return _varied(found, limit)


def surroundings(
    name: str, scene: Scene, up: FloatArray, tolerances: GraspTolerances = GRASP_TOLERANCES
) -> tuple[FloatArray, float]:
    """Everything a hand could meet around an object.

    Args:
        name: The object.
        scene: The scene.
        up: (3,) unit vector against gravity.
        tolerances: Reach and spacing.

    Returns:
        (M, 3) points of the others within reach [m], and the height of the fixed ground along `up` [m], -inf
        where nothing is fixed.
    """
    own = scene.clouds[name]
    lower, upper = own.min(axis=0) - tolerances.reach, own.max(axis=0) + tolerances.reach
    near: list[FloatArray] = []
    floor = -np.inf
    for other, cloud in scene.clouds.items():
        if other == name:
            continue
        within = cloud[np.all((cloud > lower) & (cloud < upper), axis=1)]
        if len(within) > 0:
            near.append(voxel_means(within, tolerances.spacing))
            if other in scene.fixed:
                below = within @ up
                floor = max(floor, float(np.quantile(below, 0.1)))
    return (np.vstack(near) if near else np.empty((0, 3))), floor


def _pinch_grasps(
    name: str,
    surface: Surface,
    others: FloatArray,
    floor: float,
    up: FloatArray,
    hand: HandShape,
    tolerances: GraspTolerances,
) -> list[Grasp]:
    found: list[Grasp] = []
    for tilts in (tolerances.tilts, tolerances.steep_tilts):
        if len(found) >= tolerances.enough:
            break
        for directions in frames(surface, up, tilts):
            near = others[np.linalg.norm(others - directions.origin, axis=1) < tolerances.reach]
            pinched = pinches(directions, surface, near, floor, up, hand, tolerances)
            found += [_as_grasp(name, pinch) for pinch in pinched]
    return found


def _pierces(grasp: Grasp, hand: HandShape, hulls: Sequence[Hull], tolerances: GraspTolerances) -> bool:
    """Whether the open fingers would stand in the object: its cloud may have a hole where it has none."""
    corners: list[FloatArray] = []
    for x0, x1, y0, y1, front in hand.footprints(grasp.opening)[: 2 * len(hand.finger)]:
        grid = np.meshgrid(
            np.linspace(x0, x1, 3), np.linspace(y0, y1, 3), front - np.linspace(0.0, hand.pad_length, 3)
        )
        corners.append(np.column_stack([axis.ravel() for axis in grid]))
    pose = grasp.pose_tool_to_world
    points = np.vstack(corners) @ pose[:3, :3].T + pose[:3, 3]
    inside = (points @ hull.normals.T + hull.offsets < -tolerances.into_solid for hull in hulls)
    return any(bool(deep.all(axis=1).any()) for deep in inside)


def _as_grasp(name: str, pinch: Pinch) -> Grasp:
    score = float(np.prod([value ** WEIGHTS[term] for term, value in pinch.terms.items()]))
    reason = (
        f"{1e3 * pinch.width:.0f} mm between the pads, tips {1e3 * pinch.depth:.0f} mm deep; "
        + ", ".join(f"{term} {value:.2f}" for term, value in pinch.terms.items())
    )
    kind = "rim" if pinch.rim else "pinch"
    return Grasp(name, kind, pinch.pose_tool_to_world, pinch.width, pinch.opening, score, reason, pinch.terms)


def _suction_grasps(
    name: str,
    cloud: FloatArray,
    surface: Surface,
    others: FloatArray,
    up: FloatArray,
    cup: CupShape,
    tolerances: GraspTolerances,
) -> list[Grasp]:
    found: list[Grasp] = []
    for patch in patches(surface, cloud, others, up, cup, tolerances=tolerances):
        reason = f"seal within {1e3 * patch.residual:.1f} mm; " + ", ".join(
            f"{term} {value:.2f}" for term, value in patch.terms.items()
        )
        score = seal_score(patch.terms)
        if score < tolerances.least_seal:
            continue
        for turn in CUP_TURNS:  # a cup is round: how the hand is turned about it matters to the arm alone
            pose = patch.pose_tool_to_world @ turn
            found.append(Grasp(name, "suction", pose, 0.0, cup.opening, score, reason, patch.terms))
    return found


def _varied(grasps: list[Grasp], limit: int) -> list[Grasp]:
    """Best first, without near copies (within 6 mm and 10 degrees of a better one of the same tool)."""
    kept: list[Grasp] = []
    for grasp in sorted(grasps, key=lambda grasp: -grasp.score):
        pose = grasp.pose_tool_to_world
        near = any(
            other.tool == grasp.tool
            and np.linalg.norm(other.pose_tool_to_world[:3, 3] - pose[:3, 3]) < 0.006
            and np.trace(other.pose_tool_to_world[:3, :3].T @ pose[:3, :3]) > 1.0 + 2.0 * np.cos(0.17)
            for other in kept
        )
        if not near:
            kept.append(grasp)
        if len(kept) >= limit:
            break
    return kept
