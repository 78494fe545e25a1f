"""A Panda that takes something up and lets it go, as key frames."""

import numpy as np

from topple.planner.formats.arm_motion import ArmMotion
from topple.planner.transfer.segments import Segment, SegmentKind
from topple.robots.arm.gripper import ToolState
from topple.robots.driver import Trajectory

ABOVE = np.array([0.0, -0.3, 0.0, -2.2, 0.0, 2.0, 0.8])
"""A Panda over the table before it [rad]."""
LOWER = np.array([0.0, 0.4, 0.0, 0.0, 0.0, 0.0, 0.0])
"""From there to an object [rad]."""


def carried(name, arm):
    """A motion down to an object, the grasp, up with it, and letting it go."""
    times, down = np.linspace(0.0, 1.0, 40), np.linspace(ABOVE, ABOVE + LOWER, 40)
    wide, narrow = ToolState(0.08), ToolState(0.02)
    drives = [
        Segment(SegmentKind.APPROACH, "fingers", wide, Trajectory(times, down, 0.0 * down)),
        Segment(SegmentKind.GRASP, "fingers", narrow, None, name),
        Segment(SegmentKind.LIFT, "fingers", narrow, Trajectory(times, down[::-1], 0.0 * down), name),
        Segment(SegmentKind.RELEASE, "fingers", wide),
    ]
    return ArmMotion.of(arm, np.eye(4), [(drives, [name], np.array([0.0, 0.0, -0.05]))])
