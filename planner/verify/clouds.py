"""Seen points against what the arm and the carried object fill: bodies may be entered, points not."""

from dataclasses import dataclass, field

import numpy as np

from topple.planner.formats.plan_structs import PlanData
from topple.planner.formats.verification import Residual, Worst
from topple.planner.verify.bodies import parts_of, tool_poses
from topple.planner.verify.replay import SegmentReplay
from topple.planner.verify.tolerances import EVERY, FILLED, NOISE, SHARE, STRAYS
from topple.robots.arm.arm import Arm
from topple.topology.arrays import FloatArray
from topple.topology.geometry.rigid import transformed
from topple.topology.geometry.sides import beyond, joggled_sides
from topple.topology.scene import Scene


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
            if len(seen) != 1 or seen[0] in self.scene.fixed:
                continue
            cloud = transformed(self.scene.clouds[seen[0]], piece.poses[seen[0]])
            (other,) = pair - {seen[0]}
            lay = 0.0
            if other in self._links:
                poses = links[:, self.arm.links.index(other)]
                solids = self._links[other]
            elif other in piece.held:
                poses, solids = np.matmul(tools, piece.held[other]), self._parts[other]
                if piece.step.placement.into != seen[0]:  # as deep as it lay or is to lie is no entering
                    lay = _depth(transformed(cloud, np.linalg.inv(poses[piece.at_rest])), solids)
            else:
                continue
            for number, pose in zip(numbers.tolist(), poses, strict=True):
                depth = _depth(transformed(cloud, np.linalg.inv(pose)), solids)
                where = f"{piece.where}: {seen[0]} in {other} at state {number}"
                self.entered.note(depth - lay, where, piece.index)

    def residuals(self) -> tuple[Residual, ...]:
        """What was found, and whether the plan's bodies are those of the scene."""
        return self.entered.residual(), self._same()

    def _same(self) -> Residual:
        worst = Worst("points outside of the plan's bodies", "m", FILLED)
        for name, cloud in self.scene.clouds.items():
            out = np.min([beyond(sides, cloud) for sides in self._parts[name]], axis=0)
            worst.note(float(np.quantile(out, SHARE)), name)
        return worst.residual()


def _depth(points: FloatArray, solids: list[FloatArray]) -> float:
    """How deep points are in solids [m], a few strays left out."""
    deep = np.max([-beyond(sides, points) for sides in solids], axis=0)
    return max(0.0, float(np.sort(deep)[max(len(deep) - 1 - STRAYS, 0)]))
