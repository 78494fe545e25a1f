"""Seen points against what the arm and the carried object fill: bodies may be entered, points not."""

from dataclasses import dataclass, field

import numpy as np

from topple.planner.formats.plan_structs import PlanData
from topple.planner.formats.verification import Residual, Worst
from topple.planner.verify.bodies import parts_of, tool_poses
from topple.planner.verify.replay import SegmentReplay
from topple.planner.verify.tolerances import EVERY, FILLED, NOISE, SHARE, STRAYS
from topple.robots.arm.arm import Arm
from topple.topology.base.arrays import FloatArray
from topple.topology.bodies.tolerances import GRAIN
from topple.topology.geometry.pieces import pieces_of, surface_spacing
from topple.topology.geometry.rigid import transformed
from topple.topology.geometry.sides import beyond, joggled_sides
from topple.topology.geometry.thin import spacing_of, voxel_means
from topple.topology.scene.scene import Scene


@dataclass(eq=False)
class CloudCheck:
    """Collects seen points inside links and carried objects in the segments it is shown.

    Attributes:
        plan: The plan.
        arm: The arm.
        scene: What was seen.
    """

    plan: PlanData
    arm: Arm
    scene: Scene
    entered: Worst = field(default_factory=lambda: Worst("seen points entered", "m", NOISE))
    pressed: Worst = field(
        default_factory=lambda: Worst("pressed into what it is put on or into", "m", NOISE)
    )

    def __post_init__(self) -> None:
        self._parts = {
            name: [joggled_sides(part) for part in parts] for name, parts in parts_of(self.plan).items()
        }
        self._links = {
            name: [joggled_sides(part) for part in parts]
            for name, parts in zip(self.arm.links, self.arm.parts, strict=True)
            if parts
        }

    def look(self, piece: SegmentReplay) -> None:
        """Check where pairs may touch: there the bodies were not asked."""
        numbers = np.unique([*range(0, len(piece.states), EVERY), len(piece.states) - 1])
        states = piece.states[numbers]
        tools = tool_poses(self.arm, self.plan, piece.segment.tool, states)
        links = np.matmul(np.array(self.plan.pose_base_to_world), self.arm.forward(states, piece.hand))
        for pair in piece.may_touch:
            seen = [name for name in pair if name in piece.poses and name != piece.step.object]
            onto = piece.step.placement.into in seen  # its bodies are no bar: its points are all that is
            if len(seen) != 1 or (seen[0] in self.scene.fixed and not onto):
                continue
            cloud = transformed(self.scene.clouds[seen[0]], piece.poses[seen[0]])
            (other,) = pair - {seen[0]}
            lay = 0.0
            if other in self._links:
                poses = links[:, self.arm.links.index(other)]
                solids = self._links[other]
            elif other in piece.held:
                poses, solids = np.matmul(tools, piece.held[other]), self._parts[other]
                if not onto:  # as deep as it lay or is to lie is no entering
                    lay = _depth(transformed(cloud, np.linalg.inv(poses[piece.at_rest])), solids)
            else:
                continue
            for number, pose in zip(numbers.tolist(), poses, strict=True):
                depth = _depth(transformed(cloud, np.linalg.inv(pose)), solids)
                where = f"{piece.where}: {seen[0]} in {other} at state {number}"
                (self.pressed if onto else self.entered).note(depth - lay, where, piece.index)

    def residuals(self) -> tuple[Residual, ...]:
        """What was found, and whether the plan's bodies are those of the scene."""
        return self.entered.residual(), self.pressed.residual(), self._same()

    def _same(self) -> Residual:
        worst = Worst("points outside of the plan's bodies", "m", FILLED)
        for name, cloud in self.scene.clouds.items():
            out = _beyond_all(self._parts[name], cloud)
            worst.note(float(np.quantile(out, SHARE)), name)
            # a post on a large table is less than the share of strays, but its points hang together
            odd = voxel_means(cloud[out > FILLED], 2 * GRAIN)
            for piece in pieces_of(odd, surface_spacing(odd, spacing_of(cloud))):
                worst.note(float(_beyond_all(self._parts[name], piece).max()), name)
        return worst.residual()


def _beyond_all(solids: list[FloatArray], points: FloatArray) -> FloatArray:
    """(N,) how far points (N, 3) are from the nearest of some solids [m], negative inside."""
    return np.min([beyond(sides, points) for sides in solids], axis=0)


def _depth(points: FloatArray, solids: list[FloatArray]) -> float:
    """How deep points are in solids [m], a few strays left out."""
    deep = -_beyond_all(solids, points)
    return max(0.0, float(np.sort(deep)[max(len(deep) - 1 - STRAYS, 0)]))
