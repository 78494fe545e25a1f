"""What hands hold, and what they meet on their straight way in: many grasps of a scene at once."""

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from topple.planner.grasp.cells import Cells, Region
from topple.planner.grasp.shape import Shape, shapes_of
from topple.planner.grasp.surface import Surface, surface_in
from topple.planner.grasp.surroundings import floor_near, surroundings
from topple.planner.grasp.tolerances import FINE, GRASP_TOLERANCES
from topple.robots.arm.arm import Arm
from topple.robots.catalog import names, robot
from topple.topology.base.arrays import BoolArray, FloatArray, IntArray
from topple.topology.base.errors import InvalidInput
from topple.topology.geometry.hull import Hull
from topple.topology.scene.scene import Scene
from topple.topology.situation.situation import Situation


@dataclass(frozen=True, eq=False)
class Room:
    """A scene made ready to hold many hands against it.

    Attributes:
        situation: The scene, and what is read of it.
        arm: The arm; another one's hand stands in for what it does not have.
        cells: The points of the scene's clouds, in their order, and of its matter.
        movable: Those of the movable objects alone, in theirs.
    """

    situation: Situation
    arm: Arm | None
    cells: Cells
    movable: Cells
    _hulls: dict[str, tuple[Hull, ...]] = field(default_factory=dict[str, tuple[Hull, ...]], init=False)
    _surfaces: dict[str, Surface] = field(default_factory=dict[str, Surface], init=False)
    _shapes: dict[str, Shape] = field(default_factory=dict[str, Shape], init=False)

    @classmethod
    def of(cls, situation: Situation, arm: Arm | None) -> "Room":
        """Make a situation ready for an arm's hand and cup."""
        scene = situation.scene
        movable = Cells.of([scene.clouds[name] for name in scene.movable], FINE)
        return cls(situation, arm, Cells.of([*scene.clouds.values(), scene.matter]), movable)

    @property
    def scene(self) -> Scene:
        """The scene as seen."""
        return self.situation.scene

    def surface(self, name: str) -> Surface:
        """An object to take hold of."""
        if name not in self._surfaces:
            around = surroundings(name, self.scene, self.situation.up)
            self._surfaces[name] = surface_in(name, self.situation, around)
        return self._surfaces[name]

    def hulls(self, name: str) -> tuple[Hull, ...]:
        """Space that an object fills, as far as it was seen: its convex parts."""
        if name not in self._hulls:
            self._hulls[name] = tuple(map(Hull.of, self.situation.solids[name]))
        return self._hulls[name]

    def shape(self, tool: str) -> Shape:
        """The hand of a tool: the arm's, or that of the first arm of the catalog which has such a one.

        Raises:
            InvalidInput: No arm has it.
        """
        if tool not in self._shapes:
            own = () if self.arm is None or tool not in self.arm.tools else (self.arm,)
            arm = next((arm for arm in (*own, *map(robot, names())) if tool in arm.tools), None)
            if arm is None:
                raise InvalidInput(f"no robot has a tool {tool!r}: give the robot")
            self._shapes[tool] = shapes_of(arm)[tool]
        return self._shapes[tool]

    def within(self, tool: str, poses: FloatArray) -> IntArray:
        """Count what is where a tool's open hand holds.

        Args:
            tool: Name of the tool.
            poses: (P, 4, 4) pose_tool_to_world.

        Returns:
            (P, M) points of each movable object, in the scene's order.
        """
        return self.movable.counts(poses, self.shape(tool).holds(len(poses)))

    def met(self, tool: str, poses: FloatArray, openings: FloatArray, own: Sequence[str]) -> BoolArray:
        """Ask what a tool's open hands meet on their straight way in.

        Args:
            tool: Name of the tool.
            poses: (P, 4, 4) pose_tool_to_world.
            openings: (P,) distance of the pads [m]; as far as they open where 0.
            own: (P,) what each takes.

        Returns:
            (P, K + 1) whether each of the scene's clouds is met, and its matter.
        """
        sweeps, beside = self.shape(tool).sweeps(openings)
        met, names = self._met(poses, beside), list(self.scene.clouds)
        met[np.arange(len(poses)), [names.index(name) for name in own]] = False
        return self._met(poses, sweeps) | met

    def below_ground(self, tool: str, poses: FloatArray, own: Sequence[str]) -> BoolArray:
        """(P,) whether finger tips at poses (P, 4, 4) would be below the ground around what they take."""
        floors = {name: floor_near(name, self.scene, self.situation.up) for name in set(own)}
        heights = np.array([floors[name] for name in own], dtype=np.float64)
        return self.shape(tool).below(poses, self.situation.up, heights)

    def _met(self, poses: FloatArray, regions: Sequence[Region]) -> BoolArray:
        return self.cells.more_than(GRASP_TOLERANCES.stray_points, poses, regions)
