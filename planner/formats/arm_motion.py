"""How an arm moved, as key frames: what a page plays back."""

from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from topple.planner.formats.plan_structs import SegmentData
from topple.planner.motion.trajectory import Trajectory
from topple.planner.transfer.segments import Segment, SegmentKind
from topple.robots.arm.arm import Arm
from topple.robots.arm.gripper import ToolState
from topple.robots.poses import inverse
from topple.topology.base.arrays import FloatArray
from topple.topology.base.values import ByValue

FRAMES = 16
"""Key frames of a motion: the poses between them are interpolated, which is off by less than a millimetre."""
HAND_SECONDS = 0.8
"""What opening or closing a hand is shown to take [s]: plans do not time it."""


Drive = Segment | SegmentData
"""One piece of what an arm does: of what was planned, or of what a plan says."""


@dataclass(frozen=True, eq=False)
class ArmMotion(ByValue):
    """Where the links of an arm, and what it carries, were.

    Attributes:
        times: (k,) of the key frames [s], from 0, not decreasing.
        kinds: For each key frame what the arm does from there on.
        links: (k, L, 4, 4) pose_link_to_world, in the order of `Arm.links`.
        carried: name -> (k, 4, 4) rigid transform in the world since the first key frame.
        ends: Of each pick and place its last key frame.
        beside: (L, 4, 4) pose_link_to_world of another such arm, which stands still; none where L = 0.
    """

    times: FloatArray
    kinds: tuple[str, ...]
    links: FloatArray
    carried: Mapping[str, FloatArray] = field(default_factory=dict[str, FloatArray])
    ends: tuple[int, ...] = ()
    beside: FloatArray = field(default_factory=lambda: np.empty((0, 4, 4)))

    @staticmethod
    def of(arm: Arm, pose_base_to_world: FloatArray, carries: Iterable["Carry"]) -> "ArmMotion | None":
        """Put key frames where the arm goes.

        Args:
            arm: The arm.
            pose_base_to_world: (4, 4) where it stands.
            carries: What it does, in order.

        Returns:
            The motion; None where the arm does not move.
        """
        frames = _Frames(arm, np.asarray(pose_base_to_world))
        for carry in carries:
            frames.add(carry)
        return frames.motion()


@dataclass(frozen=True, eq=False)
class Carry:
    """A pick and place, or as much of it as was done.

    Attributes:
        drives: Its pieces, in order.
        names: What moves with the hand from grasp to release.
        fall: (3,) how it goes on from where it is let go [m].
    """

    drives: Sequence[Drive]
    names: Collection[str]
    fall: FloatArray = field(default_factory=lambda: np.zeros(3))


class _Frames:
    """Collects key frames."""

    def __init__(self, arm: Arm, base: FloatArray) -> None:
        self._arm, self._base = arm, base
        self._times: list[float] = []
        self._kinds: list[str] = []
        self._links: list[FloatArray] = []
        self._poses: list[dict[str, FloatArray]] = []
        self._now: dict[str, FloatArray] = {}
        self._held: dict[str, FloatArray] = {}  # pose_start_to_tool
        self._hand: ToolState | None = None
        self._q: FloatArray | None = None
        self._clock = 0.0
        self._ends: list[int] = []

    def add(self, carry: Carry) -> None:
        for drive in carry.drives:
            if (way := drive.trajectory) is not None:
                self._drive(drive, way)
            elif self._q is not None:
                self._close(drive, carry)
        self._ends.append(max(len(self._times) - 1, 0))

    def motion(self) -> ArmMotion | None:
        if not self._times:
            return None
        names = sorted({name for poses in self._poses for name in poses})
        carried = {name: np.array([poses.get(name, np.eye(4)) for poses in self._poses]) for name in names}
        times, links = np.array(self._times), np.array(self._links)
        return ArmMotion(times, tuple(self._kinds), links, carried, tuple(self._ends))

    def _drive(self, drive: Drive, way: Trajectory) -> None:
        count, hand = len(way.times), _state(drive)
        chosen = np.unique(np.linspace(0, count - 1, min(count, FRAMES)).round().astype(int))
        q, times = way.positions[chosen], way.times[chosen] - way.times[0]
        links = self._base @ self._arm.forward(q, hand)
        tools = self._base @ self._arm.tool_pose(q, drive.tool)
        for time, pose, tool in zip(times, links, tools, strict=True):
            self._now |= {name: tool @ start for name, start in self._held.items()}
            self._keep(self._clock + float(time), drive.kind, pose)
        self._clock += float(times[-1])
        self._q, self._hand = q[-1], hand

    def _close(self, drive: Drive, carry: Carry) -> None:
        """The hand closes or opens while the arm stands."""
        assert self._q is not None
        hand = _state(drive)
        self._keep(self._clock, drive.kind, self._arm_at(self._q, self._hand or hand))
        self._clock += HAND_SECONDS
        self._hand = hand
        if drive.kind == SegmentKind.GRASP:
            tool = (self._base @ self._arm.tool_pose(self._q, drive.tool))[0]
            self._held = {name: inverse(tool) @ self._now.get(name, np.eye(4)) for name in carry.names}
        elif drive.kind == SegmentKind.RELEASE:
            for name in self._held:
                self._now[name] = self._now[name].copy()
                self._now[name][:3, 3] += carry.fall
            self._held = {}
        self._keep(self._clock, drive.kind, self._arm_at(self._q, hand))

    def _arm_at(self, q: FloatArray, hand: ToolState) -> FloatArray:
        return (self._base @ self._arm.forward(q, hand))[0]

    def _keep(self, time: float, kind: str, links: FloatArray) -> None:
        self._times.append(time)
        self._kinds.append(str(kind))
        self._links.append(links)
        self._poses.append(dict(self._now))


def _state(drive: Drive) -> ToolState:
    """How the hand stands in a piece."""
    return ToolState(drive.hand.opening, drive.hand.cup_extension)
