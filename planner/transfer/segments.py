"""The pieces of a pick and place, in the order they are driven."""

from dataclasses import dataclass

from topple.planner.motion.certificate import Certificate
from topple.planner.motion.trajectory import Trajectory
from topple.robots.arm.gripper import ToolState
from topple.topology.base.values import Word


class SegmentKind(Word):
    """What a piece is, in the order they are driven."""

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


KINDS = tuple(SegmentKind)


@dataclass(frozen=True, eq=False)
class Segment:
    """One piece.

    Attributes:
        kind: Which.
        tool: "fingers" or "suction".
        hand: How the hand stands: set before the motion; for grasp and release what it is brought to.
        trajectory: The motion; None for grasp and release.
        holding: The object in the hand during the motion, or None.
        may_touch: Pairs of names (links, objects) that touch here and are meant to.
        certificate: The proof that nothing else touches all along the motion; None for grasp and release.
    """

    kind: SegmentKind
    tool: str
    hand: ToolState
    trajectory: Trajectory | None
    holding: str | None
    may_touch: tuple[tuple[str, str], ...] = ()
    certificate: Certificate | None = None


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
