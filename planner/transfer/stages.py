"""The stages of a transfer: each with what it is checked against, its way, its proof and its failures."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from topple.planner.failure import Check, FailureLog
from topple.planner.grasp.grasp import Grasp
from topple.planner.motion.certificate import Certificate, Certifier
from topple.planner.motion.collision import Checker
from topple.planner.motion.planner import MotionFailure, plan_motion
from topple.planner.motion.shortcut import densely
from topple.planner.motion.trajectory import retime
from topple.planner.motion.upright import Upright, plan_upright
from topple.planner.transfer.limits import TransferLimits
from topple.planner.transfer.segments import THEN, Segment, SegmentKind, no_faster_than
from topple.planner.transfer.tolerances import LINE_STEP, ROUNDING
from topple.topology.base.arrays import FloatArray

STRAIGHT = (SegmentKind.APPROACH, SegmentKind.LIFT, SegmentKind.PLACE, SegmentKind.RETREAT)


@dataclass(eq=False)
class Stage:
    """One motion of a transfer.

    Attributes:
        kind: Which.
        checker: What it is checked against.
        log: Takes down what it fails of.
        path: (k, n) joint values [rad], once there is a way.
        certificate: The proof that it is free, once there is one.
    """

    kind: SegmentKind
    checker: Checker
    log: FailureLog
    path: FloatArray | None = None
    certificate: Certificate | None = None

    @property
    def way(self) -> FloatArray:
        """The path of a stage that has one."""
        assert self.path is not None, f"{self.kind} has no way yet"
        return self.path

    def straight(self, path: FloatArray | None, q: FloatArray, backwards: bool = False) -> bool:
        """Take a straight path from a state, where there is one and nothing bars it.

        Args:
            path: (k, n) joint values; None where the arm does not reach along the line.
            q: (n,) the state, to be told of.
            backwards: Whether the stage is driven the other way round.
        """
        if path is None:
            self.log.note(self.kind, Check.REACH, f"no straight {self.kind} within the arm's reach", q)
        elif not self.checker.edges_free(path[:-1], path[1:], step=LINE_STEP).all():
            states = densely(path, LINE_STEP)
            self.blame(states[int(np.argmin(self.checker.free(states)))])
        else:
            self.path = path[::-1] if backwards else path
            return True
        return False

    def prove(self) -> bool:
        """Certify the way, once; what touches between its samples is noted."""
        if self.certificate is None:
            self.certificate = Certifier(self.checker).path(self.way, ROUNDING)
        found = self.certificate.contact
        if self.certificate.proven:
            return True
        pair = None if found is None else (found.a, found.b)
        words = "something" if pair is None else " and ".join(pair)
        text = f"{self.kind}: {words} too close between samples"
        self.log.note(self.kind, Check.PROOF, text, self.certificate.state, pair)
        return False

    def search(
        self, start: FloatArray, goals: FloatArray, seed: int, rounds: int, upright: Upright | None = None
    ) -> int | None:
        """Look for a proven free way.

        Args:
            start: (n,) joint values.
            goals: (g, n) joint values.
            seed: Of the search.
            rounds: Batches of branches before the search gives up.
            upright: How a tool is kept on the way, if at all.

        Returns:
            The index of the goal that is reached; None, noted, where there is no way.
        """
        if upright is None:
            found = plan_motion(self.checker, start, goals, seed=seed, rounds=rounds)
        else:
            found = plan_upright(self.checker, start, goals, upright, seed=seed, rounds=rounds)
        if isinstance(found, MotionFailure):
            check = Check.COLLISION if found.stage in ("start", "goals") else Check.SEARCH
            self.log.note(self.kind, check, f"{self.kind}: {found.reason}", start, found.witness)
            return None
        if found.certificate is None or not found.certificate.proven:
            contact = None if found.certificate is None else found.certificate.contact
            pair = None if contact is None else (contact.a, contact.b)
            self.log.note(self.kind, Check.PROOF, f"{self.kind}: too close between samples", start, pair)
            return None
        self.path, self.certificate = found.path, found.certificate
        return found.goal

    def blame(self, q: FloatArray, step: str | None = None) -> None:
        """Note what meets what in a state (n,)."""
        pair, step = self.checker.witness(q), step or self.kind
        text = f"{step} in collision" if pair is None else f"{step}: {pair[0]} meets {pair[1]}"
        self.log.note(step, Check.COLLISION, text, q, pair)


def segments_of(stages: Sequence[Stage], grasp: Grasp, limits: TransferLimits) -> tuple[Segment, ...]:
    """Time the stages, and put grasp and release between them.

    Args:
        stages: Move, approach, lift, transfer, place and retreat, each with a proof.
        grasp: How the object is held.
        limits: How fast to move.

    Returns:
        The segments in the order they are driven.
    """
    segments: list[Segment] = []
    for stage in stages:
        checker, proof = stage.checker, stage.certificate
        assert proof is not None, f"{stage.kind} has no proof yet"
        holding = None if checker.attached is None else checker.attached.name
        given = grasp.tool, checker.tool_state, None, holding, may_touch(checker)
        segments += [Segment(still, *given) for still, then in THEN.items() if then is stage.kind]
        trajectory = retime(checker.arm, stage.way, limits.speed)
        if stage.kind in STRAIGHT:
            places = checker.arm.tool_pose(stage.way, grasp.tool)[:, :3, 3]
            way = float(np.linalg.norm(np.diff(places, axis=0), axis=1).sum())
            trajectory = no_faster_than(trajectory, way, limits.straight_speed)
        moving = Segment(stage.kind, *given, proof.proven, proof.clearance)
        segments.append(replace(moving, motion=trajectory))
    return tuple(segments)


def may_touch(checker: Checker) -> tuple[tuple[str, str], ...]:
    """Pairs of names that a checker lets touch, sorted."""
    return tuple((min(pair), max(pair)) for pair in sorted(checker.allow, key=sorted))
