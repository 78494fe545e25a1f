"""What `rank_grasps` asks about a hand, written down in plain numpy, to compare with.

Every grasp for itself against every point of the scene: what is between the pads, what the hand sweeps on its
straight way in, and whether the finger tips are over the ground. Nothing is thinned, cropped or shared.
"""

import numpy as np

from topple.planner.grasp.grasp import Grasp
from topple.planner.grasp.hand import HandShape
from topple.planner.grasp.suction import CupShape
from topple.planner.grasp.tolerances import ASIDE, GRASP_TOLERANCES, PAST_PADS
from topple.topology.base.arrays import FloatArray
from topple.topology.bodies.solids import up_of
from topple.topology.scene.scene import Scene


def held(grasp: Grasp, scene: Scene, hand: HandShape) -> str:
    """The movable object with most points between the pads, "" where there are but stray ones.

    Args:
        grasp: The grasp.
        scene: Everything there is.
        hand: The fingers.
    """
    bound = np.array([hand.pad_width / 2.0, hand.max_opening / 2.0, hand.pad_length / 2.0 + PAST_PADS])
    counts = {
        name: int(np.count_nonzero((np.abs(_local(scene.clouds[name], grasp)) < bound).all(axis=1)))
        for name in scene.movable
    }
    best = max(counts, key=lambda name: counts[name], default="")
    return best if best and counts[best] > GRASP_TOLERANCES.stray_points else ""


def against(grasp: Grasp, scene: Scene, hand: HandShape, cup: CupShape) -> str:
    """What speaks against a hand on its straight way in, in the words of `rank_grasps`.

    Args:
        grasp: The grasp, with its object.
        scene: Everything there is, with `up`.
        hand: The fingers.
        cup: The suction cup.
    """
    margin = GRASP_TOLERANCES.under_clearance
    met: list[str] = []
    for name, cloud in scene.clouds.items():
        local = _local(cloud, grasp)
        local = local[(local[:, 2] > -GRASP_TOLERANCES.reach) & (np.abs(local[:, :2]).max(axis=1) < ASIDE)]
        within = [
            (local[:, 0] > x0) & (local[:, 0] < x1) & (local[:, 1] > y0) & (local[:, 1] < y1)
            & (local[:, 2] < front - margin)
            for x0, x1, y0, y1, front in _prisms(grasp, hand, cup)
        ]  # fmt: skip
        if grasp.tool == "suction" and name != grasp.object:
            within.append(
                (np.hypot(local[:, 0], local[:, 1]) < cup.cup.radius + margin) & (local[:, 2] < -margin)
            )
        if any(np.count_nonzero(inside) > GRASP_TOLERANCES.stray_points for inside in within):
            met.append(name)
    words = [f"the hand meets {', '.join(met)}"] if met else []
    if grasp.tool == "fingers" and _tip(grasp, hand, scene) < _floor(grasp.object, scene):
        words.append("the fingers would go below the ground")
    return "; ".join(words)


def _prisms(grasp: Grasp, hand: HandShape, cup: CupShape) -> list[tuple[float, ...]]:
    if grasp.tool == "suction":
        return [(*prism.x, *prism.y, prism.front) for prism in cup.body]
    opening = min(hand.max_opening, grasp.opening) if grasp.opening > 0.0 else hand.max_opening
    return [tuple(float(value) for value in bounds) for bounds in hand.footprints(opening)]


def _local(cloud: FloatArray, grasp: Grasp) -> FloatArray:
    pose = grasp.pose_tool_to_world
    return (cloud - pose[:3, 3]) @ pose[:3, :3]


def _tip(grasp: Grasp, hand: HandShape, scene: Scene) -> float:
    return float((grasp.pose_tool_to_world[:3, 3] + hand.tip * grasp.approach) @ up_of(scene))


def _floor(name: str, scene: Scene) -> float:
    own, reach = scene.clouds[name], GRASP_TOLERANCES.reach
    lower, upper = own.min(axis=0) - reach, own.max(axis=0) + reach
    grounds = [scene.clouds[fixed] for fixed in scene.fixed if fixed != name]
    near = [ground[((ground > lower) & (ground < upper)).all(axis=1)] for ground in grounds]
    return max(
        (float(np.quantile(ground @ up_of(scene), 0.1)) for ground in near if len(ground)), default=-np.inf
    )
