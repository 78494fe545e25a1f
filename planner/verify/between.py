"""Motions as a plan writes them proven free between their samples too, by certificates derived anew."""

from collections.abc import Iterator

from topple.planner.motion.certificate import Certificate, Certifier
from topple.planner.motion.collision import Checker
from topple.planner.motion.model import Attachment
from topple.planner.verify.replay import Finding, Piece, Replay
from topple.planner.verify.tolerances import ROUNDED
from topple.topology.bodies.solids import move_parts

Proven = tuple[Piece, Certificate, bool]
"""A piece in which the arm moves, its certificate, and whether it is nowhere closer than its plan says."""


def certificates(replay: Replay) -> tuple[Proven, ...]:
    """Derive the certificate of every motion, with everything where the actions have it."""
    found: list[Proven] = []
    for piece in replay.pieces:
        if piece.segment.motion is None:
            continue
        held = [part for name, to in piece.held.items() for part in move_parts(replay.parts[name], to)]
        checker = Checker(
            replay.arm,
            replay.base,
            {name: move_parts(replay.parts[name], pose) for name, pose in piece.poses.items()},
            tool_state=piece.hand,
            attached=Attachment(tuple(held), piece.segment.tool, piece.step.object) if held else None,
            allow=piece.may_touch,
        )
        positions, room = piece.segment.motion.positions, piece.segment.clearance - ROUNDED
        kept = not piece.segment.certified or room <= 0.0 or checker.at_distance(room).free(positions).all()
        found.append((piece, Certifier(checker).path(positions), bool(kept)))
    return tuple(found)


def open_motions(replay: Replay) -> Iterator[Finding]:
    """Motions that a plan calls unproven or that cannot be proven, and those closer than it says."""
    for piece, certificate, kept in replay.once(certificates):
        if not piece.segment.certified:
            yield piece.finds(1.0)
        elif not kept:
            yield piece.finds(1.0, f"something is closer than {1e3 * piece.segment.clearance:.1f} mm")
        if piece.segment.certified and not certificate.proven:
            yield piece.finds(1.0, "said to be proven free")


def open_motion(replay: Replay, step: int) -> str:
    """The first motion of a step that is not proven, and what comes too close; empty where all are."""
    for piece, certificate, _ in replay.once(certificates):
        if piece.index == step and not certificate.proven:
            met = certificate.contact
            return f"{piece.segment.kind}{'' if met is None else f': {met.a} and {met.b}'}"
    return ""


def clearance(replay: Replay, step: int) -> str:
    """The least distance proven of all motions of a step, all along, but for pairs that may touch."""
    proven = (proof.clearance for piece, proof, _ in replay.once(certificates) if piece.index == step)
    return f"{1e3 * min(proven):.2g} mm at least"
