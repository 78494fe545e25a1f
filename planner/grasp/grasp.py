"""One way of taking one object."""

from dataclasses import dataclass, field, replace

import numpy as np

from topple.planner.grasp.shape import GRIPPERS
from topple.robots.arm.gripper import FINGERS, Tool
from topple.robots.poses import inverse
from topple.topology.base.arrays import FloatArray, freeze
from topple.topology.base.errors import InvalidInput
from topple.topology.base.values import ByValue

PINCH, RIM = "pinch", "rim"
"""Fingers take hold of an object's outside with both pads, or with one of them inside it."""

HALF_TURN = freeze(np.diag([-1.0, -1.0, 1.0, 1.0]))
"""(4, 4) half a turn of the hand about its approach."""


def kinds() -> tuple[str, ...]:
    """All ways to take hold that there are."""
    return (PINCH, RIM, *(name for name in GRIPPERS if name != FINGERS))


def tool_of(kind: str) -> str:
    """The tool that takes hold in a way: fingers in two, and every other tool in the one called like it."""
    return FINGERS if kind in (PINCH, RIM) else kind


@dataclass(frozen=True, eq=False)
class Grasp(ByValue):
    """A hand pose at which closing the fingers, or switching the cup on, holds an object.

    Attributes:
        object: Name of the object in the scene.
        kind: How it takes hold: `PINCH`, `RIM`, or what its tool is called.
        pose_tool_to_world: (4, 4) rigid pose of the tool frame: z the approach direction, y the closing
            direction, origin between the pads' centres once they hold (suction: the centre of the cup's lip).
        width: Extent of what is between the pads along y [m]; 0 for suction.
        opening: Distance of the pads on the way in [m]; for suction the opening that is kept.
        score: Quality in 0..1, comparable between grasps of one object.
        reason: What the score is made of, in words.
        terms: The score's parts by name, each in 0..1.
        unseen: Whether the hand comes in through space that no camera saw to be empty.
    """

    object: str
    kind: str
    pose_tool_to_world: FloatArray
    width: float
    opening: float
    score: float
    reason: str = ""
    terms: dict[str, float] = field(default_factory=dict[str, float])
    unseen: bool = False

    def __post_init__(self) -> None:
        pose = freeze(self.pose_tool_to_world)
        object.__setattr__(self, "pose_tool_to_world", pose)
        if self.kind not in kinds():
            raise InvalidInput(
                f"grasp of {self.object!r}: kind {self.kind!r} is none of {', '.join(kinds())}"
            )
        if pose.shape != (4, 4) or not np.all(np.isfinite(pose)):
            raise InvalidInput(f"grasp of {self.object!r}: its pose must be a finite 4x4 matrix")
        rotation = pose[:3, :3]
        if np.abs(rotation @ rotation.T - np.eye(3)).max() > 1e-3 or np.linalg.det(rotation) < 0:
            raise InvalidInput(
                f"grasp of {self.object!r}: its pose has no rotation in its upper left 3x3 block"
            )

    @property
    def tool(self) -> str:
        """The arm's tool that makes this grasp."""
        return tool_of(self.kind)

    @property
    def approach(self) -> FloatArray:
        """(3,) unit direction in the world along which the hand comes in."""
        return self.pose_tool_to_world[:3, 2]

    @property
    def closing_axis(self) -> FloatArray:
        """(3,) unit direction in the world along which the pads close."""
        return self.pose_tool_to_world[:3, 1]

    def pose_of(self, tool: Tool) -> FloatArray:
        """(4, 4) pose in the world of an arm's tool that makes it: its pads come there as they close."""
        return self.pose_tool_to_world @ inverse(tool.pads(self.width))

    def near(self, other: "Grasp", distance: float = 0.015, angle: float = 0.35) -> bool:
        """Whether another grasp takes hold at nearly the same place in nearly the same way.

        Args:
            other: The other grasp, of the same object.
            distance: Between the tools' origins, in [m]: about a pad's width.
            angle: Between approaches and between closing directions, in [rad]; the latter matter to
                fingers alone.
        """
        a, b = self.pose_tool_to_world, other.pose_tool_to_world
        axes = (1, 2) if self.kind in (PINCH, RIM) else (2,)
        along = [abs(float(a[:3, axis] @ b[:3, axis])) for axis in axes]
        close = float(np.linalg.norm(a[:3, 3] - b[:3, 3])) < distance
        return self.tool == other.tool and close and min(along) > np.cos(angle)

    def move(self, pose: FloatArray) -> "Grasp":
        """The grasp that takes hold of the object in the same way once that is elsewhere.

        Args:
            pose: (4, 4) rigid transform in the world that moves the object.
        """
        return replace(self, pose_tool_to_world=pose @ self.pose_tool_to_world)

    def turn(self) -> "Grasp":
        """The same grasp with the hand turned half around z: equal for the object, not for the arm."""
        return replace(self, pose_tool_to_world=self.pose_tool_to_world @ HALF_TURN)
