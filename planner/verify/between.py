"""Motions as a plan writes them proven free between their samples too, by certificates derived anew."""

from dataclasses import dataclass, field

import numpy as np

from topple.planner.formats.plan_structs import PlanData
from topple.planner.formats.verification import Residual, Worst
from topple.planner.motion.certificate import Certifier
from topple.planner.motion.collision import Checker
from topple.planner.motion.model import Attachment
from topple.planner.verify.bodies import parts_of
from topple.planner.verify.replay import SegmentReplay
from topple.planner.verify.tolerances import ROUNDED
from topple.robots.arm.arm import Arm
from topple.topology.bodies.solids import moved


@dataclass(eq=False)
class BetweenCheck:
    """Collects what cannot be proven of the motions it is shown.

    Attributes:
        plan: The plan.
        arm: The arm.
        clearance: By index of a step, what is proven of all its motions: the least distance [m], all along,
            of what moves to what stands, but for the pairs that may touch.
        open: By index of a step, the motions of which nothing is proven, and what comes too close.
        proof: Motions that the plan calls unproven, or of which some state is closer than it says.
    """

    plan: PlanData
    arm: Arm
    clearance: dict[int, float] = field(default_factory=dict[int, float])
    open: dict[int, str] = field(default_factory=dict[int, str])
    proof: Worst = field(default_factory=lambda: Worst("motions without a proof", "1"))

    def __post_init__(self) -> None:
        self._parts, self._base = parts_of(self.plan), np.array(self.plan.pose_base_to_world)

    def look(self, piece: SegmentReplay) -> None:
        """Derive the certificate of a segment's motion, with everything where the actions have it."""
        if piece.segment.motion is None:
            return
        held = [part for name, to_tool in piece.held.items() for part in moved(self._parts[name], to_tool)]
        checker = Checker(
            self.arm,
            self._base,
            {name: moved(self._parts[name], pose) for name, pose in piece.poses.items()},
            tool_state=piece.hand,
            attached=Attachment(tuple(held), piece.segment.tool, piece.step.object) if held else None,
            allow=piece.may_touch,
        )
        positions, told = np.array(piece.segment.motion.positions), piece.segment.clearance
        if not piece.segment.certified:
            self.proof.count(piece.where, piece.index)
        elif told > ROUNDED and not checker.keeping(told - ROUNDED).free(positions).all():
            self.proof.count(f"{piece.where}: something is closer than {1e3 * told:.1f} mm", piece.index)
        found = Certifier(checker).path(positions)
        if piece.segment.certified and not found.proven:
            self.proof.count(f"{piece.where}: said to be proven free", piece.index)
        if found.proven:
            before = self.clearance.get(piece.index, np.inf)
            self.clearance[piece.index] = min(before, found.clearance)
        else:
            met = "" if found.contact is None else f": {found.contact.a} and {found.contact.b}"
            self.open.setdefault(piece.index, f"{piece.segment.kind}{met}")

    def residuals(self) -> tuple[Residual, ...]:
        """What the plan says of its proofs and is not so."""
        return (self.proof.residual(),)
