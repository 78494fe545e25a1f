"""How an arm moved, as key frames: what a page plays back."""

from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

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


Carry = tuple[Sequence[Segment], Collection[str], FloatArray]
"""As much of a pick and place as was done: its pieces, of what was planned or of what a plan says, what moves
with the hand from grasp to release, and (3,) how that goes on from where it is let go [m]."""


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
    def of(arm: Arm, pose_base_to_world: FloatArray, carries: Iterable[Carry]) -> "ArmMotion | None":
        """Put key frames where the arm goes.

        Args:
            arm: The arm.
            pose_base_to_world: (4, 4) where it stands.
            carries: What it does, in order.

        Returns:
            The motion; None where the arm does not move.
        """
        base, q, hand = np.asarray(pose_base_to_world), None, ToolState()
        frames: list[tuple[float, str, FloatArray, dict[str, FloatArray]]] = []
        now, held = dict[str, FloatArray](), dict[str, FloatArray]()  # of what is held, pose_start_to_tool
        ends, clock = list[int](), 0.0
        for drives, names, fall in carries:
            for drive in drives:
                kind, way, state = str(drive.kind), drive.motion, drive.hand
                if way is not None:
                    last = len(way.times) - 1
                    chosen = np.unique(np.linspace(0, last, min(last + 1, FRAMES)).round().astype(int))
                    states, times = way.positions[chosen], way.times[chosen] - way.times[0]
                    links, tools = base @ arm.forward(states, state), base @ arm.tool_pose(states, drive.tool)
                    for time, pose, tool in zip(times, links, tools, strict=True):
                        now |= {name: tool @ start for name, start in held.items()}
                        frames.append((clock + float(time), kind, pose, dict(now)))
                    clock, q = clock + float(times[-1]), states[-1]
                elif q is not None:  # the hand closes or opens while the arm stands
                    frames.append((clock, kind, (base @ arm.forward(q, hand))[0], dict(now)))
                    clock += HAND_SECONDS
                    if kind == SegmentKind.GRASP:
                        to_tool = inverse((base @ arm.tool_pose(q, drive.tool))[0])
                        held = {name: to_tool @ now.get(name, np.eye(4)) for name in names}
                    elif kind == SegmentKind.RELEASE:
                        drop = np.zeros((4, 4))
                        drop[:3, 3] = fall
                        now |= {name: now[name] + drop for name in held}
                        held = {}
                    frames.append((clock, kind, (base @ arm.forward(q, state))[0], dict(now)))
                hand = state
            ends.append(max(len(frames) - 1, 0))
        if not frames:
            return None
        times, kinds, links, poses = zip(*frames, strict=True)
        carried = {name: np.array([each.get(name, np.eye(4)) for each in poses]) for name in sorted(now)}
        return ArmMotion(np.array(times), kinds, np.array(links), carried, tuple(ends))
