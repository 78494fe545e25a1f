"""What a hand holds with: a parallel jaw by friction, a suction cup by vacuum; how its joints stand."""

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from topple.robots.arm.tolerances import CUP_FRICTION
from topple.topology.base.arrays import FloatArray
from topple.topology.base.values import Word


class ToolName(Word):
    """The tools an arm may have: fingers that close, and a cup that sucks."""

    FINGERS = "fingers"
    SUCTION = "suction"


@dataclass(frozen=True)
class ToolState:
    """How the hand stands.

    Attributes:
        opening: Distance between the finger pads in [m].
        cup_extension: How far the suction cup is pushed out of the palm in [m].
    """

    opening: float = 0.0
    cup_extension: float = 0.0


@dataclass(frozen=True, eq=False)
class ParallelJaw:
    """Two fingers that close on an object and hold it by friction.

    Attributes:
        joints: Joints that move the fingers, as named in the URDF.
        links: Links of the fingers: they may touch what is held.
        openings: (k,) increasing pad distances in [m]; the last one is fully open.
        joint_values: (k, len(joints)) joint values at those openings.
        force: Largest closing force it holds continuously in [N].
        pad_size: Pad extent along the tool's x and z axes in [m].
        friction: Friction coefficient of the pads against common goods.
        speed: Closing speed in [m/s], both pads together.
        give: Mean lever of the friction about a pad's normal in [m]: rubber of 3 MPa that 40 N press on a
            side of 30 mm radius gives way for 6.7 mm around (Hertz), and 3 pi / 16 of that is the lever.
        arc: (k,) how far along the tool's z the pads are at those openings in [m]: a linkage swings them
            forward as they close. None where they slide straight.
    """

    joints: tuple[str, ...]
    links: tuple[str, ...]
    openings: FloatArray
    joint_values: FloatArray
    force: float
    pad_size: tuple[float, float]
    friction: float
    speed: float = 0.1
    give: float = 0.004
    arc: FloatArray | None = None

    @property
    def max_opening(self) -> float:
        """Largest distance between the pads in [m]."""
        return float(self.openings[-1])

    def ahead(self, opening: float) -> float:
        """How far along the tool's z the pads are at a distance of theirs, both in [m]."""
        return 0.0 if self.arc is None else float(np.interp(opening, self.openings, self.arc))

    def pads(self, opening: float) -> FloatArray:
        """Middle of the pads (4, 4) in the tool frame at a distance of theirs [m]."""
        pose = np.eye(4)
        pose[2, 3] = self.ahead(opening)
        return pose

    def lever(self, joint: str) -> float:
        """Way of one pad for the way of a joint, over the stroke: 1 for a slide, in [m/rad] for a hinge."""
        column = self.joint_values[:, self.joints.index(joint)]
        return float((self.openings[-1] - self.openings[0]) / 2.0 / abs(column[-1] - column[0]))

    def values(self, opening: float) -> dict[str, float]:
        """Joint values at a pad distance in [m]; beyond the ends of the stroke it stays at the end."""
        columns = self.joint_values.T
        return {
            name: float(np.interp(opening, self.openings, column))
            for name, column in zip(self.joints, columns, strict=True)
        }

    def opening(self, values: Mapping[str, float]) -> float:
        """The pad distance in [m] at measured joint values: the mean of what each joint says."""
        found: list[float] = []
        for name, column in zip(self.joints, self.joint_values.T, strict=True):
            order = np.argsort(column)
            found.append(float(np.interp(values[name], column[order], self.openings[order])))
        return float(np.mean(found))


def vacuum_load(
    pull: float, shear: float, bending: float, twist: float, *, force: float, radius: float, friction: float
) -> float:
    """Share of what holds a cup's lip that a load on it takes: at 1 it lets go.

    The vacuum presses the lip on. What pulls takes from that; what shears needs as much of it as friction
    takes to bear it, as in the theoretical holding force m (g + a / mu) of Schmalz ("The Vacuum System and
    its Components", load cases I to III); a moment takes as much as its pull on the lip's edge.

    Args:
        pull: Along the axis, away from the cup in [N]; negative presses.
        shear: Across the axis in [N].
        bending: Moment across the axis in [N m].
        twist: Moment about the axis in [N m].
        force: Of the vacuum on the lip's area in [N].
        radius: Of the lip in [m].
        friction: Coefficient between lip and surface.
    """
    return (pull + math.hypot(shear, twist / radius) / friction + bending / radius) / force


def lip_plane(ring: FloatArray, heights: FloatArray) -> tuple[FloatArray, float]:
    """How a lip lies on a surface: what a planner asks of clouds, and a simulated cup of what it meets.

    Args:
        ring: (k, 2) places around the lip in [m], k >= 3, the lip's centre at the origin.
        heights: (k,) of the surface there in [m].

    Returns:
        (3,) the plane a x + b y + c [m] that a bellows follows, and the largest distance of the surface from
        it [m], which the lip has to bridge.
    """
    rows = np.column_stack([ring, np.ones(len(ring))])
    plane: FloatArray = np.linalg.lstsq(rows, heights, rcond=None)[0].astype(np.float64)
    return plane, float(np.abs(rows @ plane - heights).max())


@dataclass(frozen=True)
class SuctionCup:
    """A vacuum cup: holds where its whole lip seals, and below its force limit.

    Attributes:
        link: Link of the cup: it may touch what is held.
        joint: Prismatic joint that pushes the cup out of the palm, or None if the cup stands fixed.
        stroke: Travel of that joint in [m].
        radius: Lip radius in [m].
        max_force: Pull at which it lets go in [N]: vacuum times lip area.
        lip_depth: How much unevenness under the lip the rubber bridges in [m].
        speed: Speed of the stroke in [m/s].
        friction: Coefficient between its lip and what it takes.
        retracts: Whether a drive draws it in on the way; a sprung plunger stands out unless it is pressed.
    """

    link: str
    joint: str | None
    stroke: float
    radius: float
    max_force: float
    lip_depth: float = 0.002
    speed: float = 0.2
    retracts: bool = True
    friction: float = CUP_FRICTION

    def pads(self, _: float) -> FloatArray:
        """The lip (4, 4) in the tool frame."""
        return np.eye(4)

    @property
    def stowed(self) -> float:
        """How far it stands out on the way in [m]."""
        return 0.0 if self.retracts else self.stroke

    def values(self, extension: float) -> dict[str, float]:
        """Joint values at an extension in [m], clipped to the stroke."""
        return {} if self.joint is None else {self.joint: float(np.clip(extension, 0.0, self.stroke))}


@dataclass(frozen=True, eq=False)
class Tool:
    """A frame to grasp with, and what it takes.

    The frame's origin lies between the pads' centres, half open where they swing (suction: at the centre of
    the extended lip); z is the approach direction out of the hand, y the closing direction.

    Attributes:
        name: fingers or suction.
        link: Link that carries the frame.
        pose_tool_to_link: (4, 4).
        gripper: The jaw or the cup.
        links: Links that may touch what the tool holds or is about to hold.
        ready: State of the hand in which the tool approaches an object.
    """

    name: str
    link: str
    pose_tool_to_link: FloatArray
    gripper: ParallelJaw | SuctionCup
    links: tuple[str, ...]
    ready: ToolState

    def pads(self, width: float) -> FloatArray:
        """Where it takes hold: between the pads at a distance of theirs, or at the lip.

        Args:
            width: Of what is held in [m]; 0 for suction.

        Returns:
            (4, 4) pose_pads_to_tool.
        """
        return self.gripper.pads(width)


def tools_of(
    gripper: ParallelJaw | SuctionCup | Mapping[str, Tool] | None, tool_frame: str
) -> dict[str, Tool]:
    """Tools by name: those given, or the one of a jaw or cup whose frame is that of its link."""
    if gripper is None:
        return {}
    if isinstance(gripper, Mapping):
        return dict(gripper)
    if isinstance(gripper, ParallelJaw):
        ready = ToolState(gripper.max_opening)
        return {
            ToolName.FINGERS: Tool(ToolName.FINGERS, tool_frame, np.eye(4), gripper, gripper.links, ready)
        }
    ready = ToolState(cup_extension=gripper.stroke)
    return {ToolName.SUCTION: Tool(ToolName.SUCTION, tool_frame, np.eye(4), gripper, (gripper.link,), ready)}
