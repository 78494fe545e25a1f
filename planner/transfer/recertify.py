"""A transfer that was planned for predicted bodies, proven on those that are seen."""

from dataclasses import replace

from topple.planner.fallbacks import Relaxation
from topple.planner.grasp.judge import in_the_way
from topple.planner.grasp.room import Room
from topple.planner.grasp.tolerances import GRASP_TOLERANCES
from topple.planner.motion.certificate import Certifier
from topple.planner.transfer.checks import Checks
from topple.planner.transfer.segments import THEN, Segment, SegmentKind
from topple.planner.transfer.stages import may_touch
from topple.planner.transfer.tolerances import MARGIN, ROUNDING
from topple.planner.transfer.transfer import Transfer
from topple.robots.arm.arm import Arm, Station
from topple.topology.situation.situation import Situation


def recertify(transfer: Transfer, situation: Situation, station: Station) -> Transfer | None:
    """Prove that a transfer can be done in another situation than it was planned for.

    The hand needs room among the clouds, and something of the object where it closes. Every motion is
    certified as it is driven, between its samples too, by the rules that it was planned by: at the same
    distances, and what may touch is what might touch then.

    Args:
        transfer: The transfer.
        situation: What is seen.
        station: The arm as it stands before.

    Returns:
        The transfer with its proofs of the situation; None where something of it cannot be proven.
    """
    if transfer.object not in situation.movable or not _takes(transfer, situation, station.arm):
        return None
    checks = Checks(transfer.object, situation, station, transfer.riding)
    lenient = Relaxation.THROUGH_GUESSES in transfer.fallbacks
    margin = 0.0 if Relaxation.NARROW in transfer.fallbacks else MARGIN
    segments: list[Segment] = []
    for segment in transfer.segments:
        kind, clearance = THEN.get(segment.kind, segment.kind), 0.0
        kept = margin if kind is SegmentKind.TRANSFER else 0.0
        checker = checks.checker(kind, transfer.grasp, transfer.placement, lenient=lenient, margin=kept)
        if segment.motion is not None:
            certificate = Certifier(checker).path(segment.motion.positions, ROUNDING)
            if not certificate.proven:
                return None
            clearance = certificate.clearance
        segments.append(replace(segment, may_touch=may_touch(checker), clearance=clearance))
    return replace(transfer, segments=tuple(segments))


def _takes(transfer: Transfer, situation: Situation, arm: Arm) -> bool:
    """Whether the hand has room on its way in, and takes hold of something of the object."""
    grasp, scene = transfer.grasp, situation.scene
    room = Room.of(situation, arm)
    within = room.within(grasp.tool, grasp.pose_tool_to_world[None])[0][scene.movable.index(transfer.object)]
    return within > GRASP_TOLERANCES.stray_points and not in_the_way([grasp], room)[0][1]
