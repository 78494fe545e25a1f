"""Whether a hand that closes where a plan closes it takes hold of the object there."""

from collections.abc import Mapping, Sequence

import numpy as np

from topple.planner.formats.plan_structs import Step
from topple.planner.grasp.grasp import kinds, tool_of
from topple.planner.verify.tolerances import CLOSED, FEWEST_BETWEEN, LIP, OPENED, REACHED, SPACING
from topple.robots.arm.arm import Arm
from topple.robots.arm.gripper import ToolState
from topple.robots.collision.fcl_bodies import fcl_body
from topple.robots.poses import inverse
from topple.topology.base.arrays import FloatArray
from topple.topology.geometry.axes import level_axes
from topple.topology.geometry.rigid import move_points
from topple.topology.geometry.samples import sample
from topple.topology.geometry.sides import inset

Bodies = Mapping[str, Sequence[FloatArray]]


class Grip:
    """Holds a plan's grasps against its bodies.

    Args:
        parts: By name convex parts (V, 3) as they were when the plan began [m].
        wholes: The same with the hidden sides.
        arm: The arm.
        up: (3,) against gravity.
    """

    def __init__(self, parts: Bodies, wholes: Bodies, arm: Arm, up: FloatArray) -> None:
        self._parts, self._whole, self.arm, self._up = parts, wholes, arm, up

    def fails(
        self,
        step: Step,
        tool: str,
        before: ToolState,
        closed: ToolState,
        pose_pads_to_world: FloatArray,
        poses: Mapping[str, FloatArray],
    ) -> str | None:
        """Say why a hand takes no hold of a step's object.

        Args:
            step: The step.
            tool: The tool that closes.
            before: The hand on the way in.
            closed: The hand it is brought to.
            pose_pads_to_world: (4, 4) between the pads once they hold, or at the lip.
            poses: Transforms (4, 4) of the objects since the plan began.

        Returns:
            The reason; None where it holds.
        """
        if tool not in self.arm.tools:
            return f"the arm has no {tool}"
        if step.grasp.kind not in kinds():
            return f"{step.grasp.kind!r} is no kind of grasp"
        if tool_of(step.grasp.kind) != tool:
            return f"a grasp by {step.grasp.kind} is no matter of the {tool}"
        to_tool = inverse(pose_pads_to_world) @ poses[step.object]
        parts = [move_points(part, to_tool) for part in self._parts[step.object]]
        if not self.arm.tools[tool].gripper.limits.opening:
            return self._cup_fails(step, tool, closed, parts)
        hidden = [move_points(part, to_tool) for part in self._whole[step.object]]
        return self._pads_fail(step, tool, before, closed, [*parts, *hidden])

    def rides(self, name: str, carrier: str, poses: Mapping[str, FloatArray]) -> bool:
        """Whether an object lies in or on another: its middle is over that, its bottom not below."""
        axes = np.stack(level_axes(self._up))
        own, other = (self._corners(each, poses) for each in (name, carrier))
        over = inset(other @ axes.T, (axes @ own.mean(axis=0))[None])[0] >= 0.0
        return bool(over and (own @ self._up).min() > (other @ self._up).min() - REACHED)

    def _corners(self, name: str, poses: Mapping[str, FloatArray]) -> FloatArray:
        return move_points(np.vstack(self._parts[name]), poses[name])

    def _cup_fails(self, step: Step, tool: str, closed: ToolState, parts: list[FloatArray]) -> str | None:
        ready = self.arm.tools[tool].ready.cup_extension
        if abs(closed.cup_extension - ready) > LIP:
            out = 1e3 * closed.cup_extension
            return f"the cup is {out:.0f} mm out, and takes hold {1e3 * ready:.0f} mm out"
        if step.grasp.width != 0.0:
            return f"a cup takes nothing {1e3 * step.grasp.width:.0f} mm wide between pads"
        gap = distance(np.zeros(3), parts)
        return f"the lip ends {1e3 * gap:.0f} mm from {step.object}" if gap > REACHED else None

    def _pads_fail(
        self, step: Step, tool: str, before: ToolState, closed: ToolState, parts: list[FloatArray]
    ) -> str | None:
        if abs(closed.opening - step.grasp.width) > LIP:
            told, to = 1e3 * step.grasp.width, 1e3 * closed.opening
            return f"the grasp is {told:.0f} mm wide and the pads close to {to:.0f} mm"
        if closed.opening > before.opening - OPENED:
            return f"the pads come in {1e3 * before.opening:.0f} mm apart and do not close"
        half = self.arm.tools[tool].gripper.closing_region(before.opening) / 2.0
        points = np.vstack([*parts, sample(parts, SPACING)])
        between = points[(np.abs(points) <= half + SPACING * np.array([0.0, 1.0, 0.0])).all(axis=1)]
        if len(between) < FEWEST_BETWEEN and distance(half, parts) > REACHED:
            return f"nothing of {step.object} is between the pads"
        wide = float(np.ptp(between[:, 1])) if len(between) else 0.0
        # its hulls bridge hollows: it may be narrower, and pads close until they press
        if closed.opening > wide + CLOSED:
            to = 1e3 * closed.opening
            return f"{step.object} is {1e3 * wide:.0f} mm wide between the pads, which close to {to:.0f} mm"
        return None


def distance(half: FloatArray, parts: Sequence[FloatArray]) -> float:
    """Distance [m] to convex parts from a box about the origin, half its extents (3,), or from the origin."""
    import fcl

    box = fcl.CollisionObject(fcl.Box(*np.maximum(2.0 * half, 1e-4).tolist()))
    ways = (float(fcl.distance(box, fcl_body(part), fcl.DistanceRequest())) for part in parts)
    return max(0.0, min(ways))
