"""The pieces of a pick and place, in the order they are driven."""

from dataclasses import dataclass

from topple.robots.arm.gripper import ToolState
from topple.robots.driver import Trajectory
from topple.topology.base.values import Word


class SegmentKind(Word):
    """What a piece is."""

    MOVE = "move"
    """The empty hand, to before the object."""
    APPROACH = "approach"
    """Straight in."""
    GRASP = "grasp"
    """Close, or switch the vacuum on."""
    LIFT = "lift"
    """Straight up; from under a board a little up and straight out."""
    TRANSFER = "transfer"
    """Carrying, to above the place."""
    PLACE = "place"
    """Straight down."""
    RELEASE = "release"
    """Open, or switch the vacuum off."""
    RETREAT = "retreat"
    """Straight out."""


THEN = {SegmentKind.GRASP: SegmentKind.LIFT, SegmentKind.RELEASE: SegmentKind.RETREAT}
"""What the arm does next where it stands still: the same may touch."""


@dataclass(frozen=True)
class Segment:
    """One piece of a pick and place, as the arm does it and as a plan's file has it.

    Attributes:
        kind: Which.
        tool: "fingers" or "suction".
        hand: Set before the motion; for grasp and release what the hand is brought to.
        motion: Null for grasp and release.
        holding: What is in the hand.
        may_touch: Pairs of names (links, objects) that touch here and are meant to.
        certified: Whether the motion was proven free between its samples too.
        clearance: Proven lower bound [m] of the distance, all along, of the arm and what it holds to all that
            stands, but for the pairs that may touch.
        witness: What meets what where the proof failed.
    """

    kind: SegmentKind
    tool: str
    hand: ToolState
    motion: Trajectory | None = None
    holding: str | None = None
    may_touch: tuple[tuple[str, str], ...] = ()
    certified: bool = False
    clearance: float = 0.0
    witness: tuple[str, str] | None = None

    @property
    def seconds(self) -> float:
        """Duration of the motion [s]; 0 where the arm stands still."""
        return 0.0 if self.motion is None else float(self.motion.times[-1])


def no_faster_than(trajectory: Trajectory, length: float, speed: float) -> Trajectory:
    """Stretch a trajectory in time so that the tool keeps below a mean speed.

    Args:
        trajectory: The trajectory.
        length: The tool's way [m].
        speed: The largest mean speed of the tool [m/s].

    Returns:
        The same path, slower where need be.
    """
    duration = float(trajectory.times[-1])
    factor = max(1.0, length / speed / duration) if duration > 0 else 1.0
    return Trajectory(trajectory.times * factor, trajectory.positions, trajectory.velocities / factor)
