"""What hands hold, and what they meet on their straight way in: many grasps of a scene at once."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from topple.planner.grasp.cells import Cells, Region
from topple.planner.grasp.hand import HandShape, hand_shape
from topple.planner.grasp.suction import CupShape, cup_shape
from topple.planner.grasp.surface import Surface, surface_in
from topple.planner.grasp.surroundings import floor_near, surroundings
from topple.planner.grasp.tolerances import ASIDE, AT_LIP, FINE, GRASP_TOLERANCES, PAST_PADS
from topple.robots.arm.arm import Arm
from topple.robots.arm.gripper import ToolName
from topple.robots.catalog import robot
from topple.topology.base.arrays import BoolArray, FloatArray, IntArray
from topple.topology.geometry.hull import Hull
from topple.topology.scene.scene import Scene
from topple.topology.situation.situation import Situation


@dataclass(frozen=True, eq=False)
class Room:
    """A scene made ready to hold many hands against it.

    Attributes:
        situation: The scene, and what is read of it.
        arm: The arm; a Panda's hand or cup stands in for what it does not have.
        cells: The points of the scene's clouds, in their order, and of its matter.
        movable: Those of the movable objects alone, in theirs.
    """

    situation: Situation
    arm: Arm | None
    cells: Cells
    movable: Cells

    @classmethod
    def of(cls, situation: Situation, arm: Arm | None) -> "Room":
        """Make a situation ready for an arm's hand and cup."""
        scene = situation.scene
        movable = Cells.of([scene.clouds[name] for name in scene.movable], FINE)
        return cls(situation, arm, Cells.of([*scene.clouds.values(), scene.matter]), movable)

    @property
    def scene(self) -> Scene:
        """What is seen."""
        return self.situation.scene

    def surface(self, name: str) -> Surface:
        """An object to take hold of."""
        if name not in self._surfaces:
            around = surroundings(name, self.scene, self.situation.up)
            self._surfaces[name] = surface_in(name, self.situation, around)
        return self._surfaces[name]

    def hulls(self, name: str) -> tuple[Hull, ...]:
        """What an object fills, as far as it was seen: its convex parts."""
        if name not in self._hulls:
            self._hulls[name] = tuple(map(Hull.of, self.situation.solids[name]))
        return self._hulls[name]

    @cached_property
    def _hulls(self) -> dict[str, tuple[Hull, ...]]:
        return {}

    @cached_property
    def _surfaces(self) -> dict[str, Surface]:
        return {}

    @cached_property
    def hand(self) -> HandShape:
        """Fingers."""
        return hand_shape(self._with(ToolName.FINGERS, "panda"))

    @cached_property
    def cup(self) -> CupShape:
        """Suction cup."""
        return cup_shape(self._with(ToolName.SUCTION, "panda-suction"))

    def _with(self, tool: str, stand_in: str) -> Arm:
        return self.arm if self.arm is not None and tool in self.arm.tools else robot(stand_in)

    def between_pads(self, poses: FloatArray) -> IntArray:
        """Count what is between the pads of the open hand.

        Args:
            poses: (P, 4, 4) pose_tool_to_world.

        Returns:
            (P, M) points of each movable object, in the scene's order.
        """
        half = [self.hand.pad_width, self.hand.max_opening, self.hand.pad_length + 2.0 * PAST_PADS]
        bound = np.tile(np.array(half) / 2.0, (len(poses), 1))
        return self.movable.counts(poses, Region(-bound, bound))

    def under_cup(self, poses: FloatArray) -> IntArray:
        """Count what is under the cup's lip.

        Args:
            poses: (P, 4, 4) pose_tool_to_world.

        Returns:
            (P, M) points of each movable object, in the scene's order.
        """
        bound = np.tile([self.cup.radius, self.cup.radius, AT_LIP], (len(poses), 1))
        return self.movable.counts(poses, Region(-bound, bound, self.cup.radius))

    def met_by_fingers(self, poses: FloatArray, openings: FloatArray) -> BoolArray:
        """Ask what open hands meet on their straight way in.

        Args:
            poses: (P, 4, 4) pose_tool_to_world.
            openings: (P,) distance of the pads [m]; as far as they open where 0.

        Returns:
            (P, K + 1) whether each of the scene's clouds is met, and its matter.
        """
        widest = self.hand.max_opening
        opening = np.where(openings > 0.0, np.minimum(widest, openings), widest)
        return self._met(poses, [_swept(len(poses), *bounds) for bounds in self.hand.footprints(opening)])

    def met_by_cup(self, poses: FloatArray, own: Sequence[str]) -> BoolArray:
        """Ask what hands with the cup out meet on their straight way in.

        Args:
            poses: (P, 4, 4) pose_tool_to_world.
            own: (P,) what each takes, which may bulge into the bellows.

        Returns:
            (P, K + 1) whether each of the scene's clouds is met, and its matter.
        """
        body = [_swept(len(poses), *prism.x, *prism.y, prism.front) for prism in self.cup.body]
        margin, names = GRASP_TOLERANCES.under_clearance, list(self.scene.clouds)
        side = self.cup.radius + margin
        lip = _swept(len(poses), -side, side, -side, side, 0.0)
        beside = self._met(poses, [Region(lip.lower, lip.upper, side)])
        beside[np.arange(len(poses)), [names.index(name) for name in own]] = False
        return self._met(poses, body) | beside

    def below_ground(self, poses: FloatArray, own: Sequence[str]) -> BoolArray:
        """(P,) whether finger tips at poses (P, 4, 4) would be below the ground around what they take."""
        floors = {name: floor_near(name, self.scene, self.situation.up) for name in set(own)}
        tips = (poses[:, :3, 3] + self.hand.tip * poses[:, :3, 2]) @ self.situation.up
        return np.asarray(tips < np.array([floors[name] for name in own], dtype=np.float64))

    def _met(self, poses: FloatArray, regions: Sequence[Region]) -> BoolArray:
        return self.cells.more_than(GRASP_TOLERANCES.stray_points, poses, regions)


def _swept(
    count: int,
    x_low: float,
    x_high: float,
    y_low: float | FloatArray,
    y_high: float | FloatArray,
    front: float,
) -> Region:
    """A prism of `count` hands with everything behind it, as far as it is cleared of what lies below."""
    lower, upper = np.empty((count, 3)), np.empty((count, 3))
    for axis, (low, high) in enumerate(((x_low, x_high), (y_low, y_high))):
        lower[:, axis], upper[:, axis] = np.maximum(low, -ASIDE), np.minimum(high, ASIDE)
    lower[:, 2], upper[:, 2] = -GRASP_TOLERANCES.reach, front - GRASP_TOLERANCES.under_clearance
    return Region(lower, upper)
