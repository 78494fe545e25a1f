"""What a tool takes hold with, whatever kind it is: what an arm, a world and a plan ask of it."""

from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from topple.robots.arm.tolerances import FINGERS_TOUCH
from topple.topology.base.arrays import FloatArray

if TYPE_CHECKING:
    from topple.robots.driver import Driver


FINGERS, SUCTION = "fingers", "suction"
"""topple's own tools: fingers that close, and a cup that sucks."""


@dataclass(frozen=True)
class ToolState:
    """How the hand stands.

    Attributes:
        opening: Distance between the finger pads in [m].
        cup_extension: How far the suction cup is pushed out of the palm in [m].

    Examples:
        >>> ToolState(opening=0.08)
        ToolState(opening=0.08, cup_extension=0.0)
    """

    opening: float = 0.0
    cup_extension: float = 0.0


class Gripper(ABC):
    """A kind of gripper, each in a file of its own: a jaw, a hinged one, a cup, and those of other packages.

    What a search for grasps asks is the other half of it, `topple.planner.grasp.shape.Shape`. What is not
    said here is that of one that takes by a single face and has no joints.

    Attributes:
        tool: What its tool is called.
        touch: What the wrist feels as it touches what it takes, where the way in ends [N].
        presses: Whether it is to be pressed on that; else what stops it on its way in is in the way.
    """

    tool: ClassVar[str]
    touch: ClassVar[float] = FINGERS_TOUCH
    presses: ClassVar[bool] = False

    @property
    @abstractmethod
    def touching(self) -> tuple[str, ...]:
        """Links that touch what is held."""

    @property
    def limits(self) -> ToolState:
        """How far its parts go."""
        return ToolState()

    @property
    def stowed(self) -> float:
        """How far it stands out on the way [m]."""
        return 0.0

    @property
    def widest(self) -> float:
        """Side [m] of the largest cube that it surely takes."""
        return np.inf

    @property
    def jaw(self) -> Any:
        """The fingers of it that a world drives, a `topple.robots.arm.jaw.ParallelJaw`."""
        return None

    @property
    def cup(self) -> Any:
        """The cup to switch on to hold by a face, a `topple.robots.arm.cup.SuctionCup`; None without one."""
        return None

    def pads(self, width: float) -> FloatArray:
        """Where it takes hold (4, 4) in the tool frame, of what has a width [m] between its pads."""
        return np.eye(4)

    def closing_region(self, opening: float) -> FloatArray:
        """Extents (3,) in the tool frame of what is between its pads at a distance of theirs [m]."""
        return np.zeros(3)

    def values(self, state: ToolState) -> dict[str, float]:
        """Values of its joints as the hand stands, beyond the ends of their stroke those of the end."""
        return {}

    @abstractmethod
    def take(self, robot: "Driver", name: str) -> str | None:
        """Take hold of an object by a driver; a sentence where it does not hold."""

    @abstractmethod
    def data(self) -> dict[str, Any]:
        """Describe the tool for a plan, under a key of its own: `jaw`, `cup`, or `more` for another kind."""

    @abstractmethod
    def facts(self) -> dict[str, Any]:
        """Describe the tool for `topple robot --json`, its `kind` included."""

    @abstractmethod
    def __str__(self) -> str:
        """In words, with its dimensions."""


@dataclass(frozen=True, eq=False)
class Tool:
    """A frame to grasp with, and what it takes.

    The frame's origin lies between the pads' centres, half open where they swing (suction: at the centre of
    the extended lip); z is the approach direction out of the hand, y the closing direction.

    Attributes:
        name: fingers or suction, or that of another package's gripper.
        link: Link that carries the frame.
        pose_tool_to_link: (4, 4).
        gripper: What it takes hold with.
        links: Links that may touch what the tool holds or is about to hold.
        ready: State of the hand in which the tool approaches an object.
    """

    name: str
    link: str
    pose_tool_to_link: FloatArray
    gripper: Gripper
    links: tuple[str, ...]
    ready: ToolState

    @classmethod
    def of(cls, gripper: Gripper, link: str, pose_tool_to_link: FloatArray, *more: str) -> "Tool":
        """The tool of a gripper that comes in as far open, or out, as it goes; more links may touch."""
        links = (*gripper.touching, *more)
        return cls(gripper.tool, link, pose_tool_to_link, gripper, links, gripper.limits)

    def pads(self, width: float) -> FloatArray:
        """Where it takes hold: between the pads at a distance of theirs, or at the lip.

        Args:
            width: Of what is held in [m]; 0 for suction.

        Returns:
            (4, 4) pose_pads_to_tool.
        """
        return self.gripper.pads(width)


def tools_of(gripper: Gripper | Mapping[str, Tool] | None, tool_frame: str) -> dict[str, Tool]:
    """Tools by name: those given, or the one of a gripper whose frame is that of its link."""
    if isinstance(gripper, Gripper):
        return {gripper.tool: Tool.of(gripper, tool_frame, np.eye(4))}
    return dict(gripper or {})
