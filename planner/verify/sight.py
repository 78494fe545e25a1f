"""Where hands come in, held against what cameras saw to be empty by then."""

from collections.abc import Iterator

import numpy as np

from topple.planner.grasp.grasp import Grasp
from topple.planner.grasp.shape import coming_unseen, shapes_of
from topple.planner.transfer.segments import SegmentKind
from topple.planner.verify.replay import Finding, Piece, Replay
from topple.robots.poses import inverse


def _ways_in_seen(replay: Replay) -> tuple[tuple[Piece, bool], ...]:
    """Tell of every way in, after the steps before it, whether cameras saw it to be empty."""
    shapes, situation = shapes_of(replay.arm), replay.situation
    poses, found = {name: np.eye(4) for name in replay.parts}, list[tuple[Piece, bool]]()
    for piece in replay.of_kind(SegmentKind.APPROACH):
        gone = [name for name in situation.scene.names if name not in piece.before]
        situation = situation.without(*gone) if gone else situation
        for name, pose in piece.before.items():
            if not np.array_equal(pose, poses[name]):
                situation = situation.moved([name], pose @ inverse(poses[name]))
                poses[name] = pose
        tool = piece.segment.tool
        pose = replay.tools(piece, piece.states[-1:])[0] @ replay.pads(piece)
        grasp = Grasp(piece.step.object, shapes[tool].kind, pose, 0.0, piece.segment.hand.opening, 0.0)
        found.append((piece, not coming_unseen([grasp], situation, shapes)[0]))
    return tuple(found)


def unsaid(replay: Replay) -> Iterator[Finding]:
    """Steps that keep quiet about a hand that comes in unseen."""
    for piece, seen in replay.once(_ways_in_seen):
        if not seen and not piece.step.unseen:
            yield Finding(1.0, f"step {piece.index + 1} ({piece.step.object})", piece.index)


def said(replay: Replay) -> Iterator[str]:
    """Say which steps call a hand unseen that was seen all the way."""
    for piece, seen in replay.once(_ways_in_seen):
        if seen and piece.step.unseen:
            yield (
                f"step {piece.index + 1} ({piece.step.object}) says that its hand comes in unseen: "
                "in this scene cameras saw all of its way to be empty"
            )
