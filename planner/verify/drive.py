"""The joints' part of a plan: limits, smooth joins, and velocities that are those of the positions."""

from collections.abc import Iterator

import numpy as np
from scipy.interpolate import CubicHermiteSpline, CubicSpline

from topple.planner.verify.replay import Finding, Piece, Replay
from topple.planner.verify.tolerances import LIP, QUARTERS, STRAYED
from topple.robots.arm.arm import Arm
from topple.robots.driver import Trajectory
from topple.topology.base.arrays import FloatArray


def ways(replay: Replay) -> tuple[tuple[Piece, Trajectory], ...]:
    """The pieces in which the arm moves, and how."""
    some = ((piece, piece.segment.motion) for piece in replay.pieces)
    return tuple((piece, way) for piece, way in some if way is not None)


def _stretches(replay: Replay) -> Iterator[tuple[Piece, FloatArray, FloatArray, FloatArray]]:
    """Motions of more than one sample: the piece, their spans (t - 1, 1) [s], positions and velocities."""
    for piece, (stamps, positions, velocities) in replay.once(ways):
        if len(stamps) > 1:
            yield piece, np.maximum(np.diff(stamps)[:, None], 1e-9), positions, velocities


def beyond_limits(replay: Replay) -> Iterator[Finding]:
    """How far joints, pads and cup are beyond where they go [rad] or [m]."""
    arm = replay.arm
    for piece in replay.pieces:
        hand = piece.segment.hand
        for what, value, most in (
            ("opening", hand.opening, arm.hand_limits.opening),
            ("cup_extension", hand.cup_extension, arm.hand_limits.cup_extension),
        ):
            yield piece.finds(max(value - most, -value) - LIP, what)
    for piece, (_, positions, _) in replay.once(ways):
        beyond = np.maximum(positions - arm.upper, arm.lower - positions).max(axis=0)
        yield piece.finds(float(beyond.max()), arm.joints[int(beyond.argmax())])


def jumps(replay: Replay) -> Iterator[Finding]:
    """How far motions begin from where the arm is [rad]."""
    for piece, (_, positions, _) in replay.once(ways):
        yield piece.finds(float(np.abs(positions[0] - piece.start).max()))


def unrest(replay: Replay) -> Iterator[Finding]:
    """How fast joints are where motions begin and end [rad/s]."""
    for piece, (_, _, velocities) in replay.once(ways):
        yield piece.finds(float(np.abs(velocities[[0, -1]]).max()))


def times(replay: Replay) -> Iterator[Finding]:
    """Times that do not increase, or do not begin at 0."""
    for piece, (stamps, *_) in replay.once(ways):
        yield piece.finds(float(stamps[0] != 0.0), f"it begins at {stamps[0]:g} s")
        yield piece.finds(float(np.count_nonzero(np.diff(stamps) <= 0.0)))


def speeds(replay: Replay) -> Iterator[Finding]:
    """Shares by which joints are faster than they can be, as is said and on the mean between two samples."""
    for piece, span, positions, velocities in _stretches(replay):
        for rates in (velocities, np.diff(positions, axis=0) / span):
            yield _share(piece, replay.arm, rates, replay.arm.velocity)


def accelerations(replay: Replay) -> Iterator[Finding]:
    """Shares by which joints speed up faster than they can."""
    for piece, span, _, velocities in _stretches(replay):
        yield _share(piece, replay.arm, np.diff(velocities, axis=0) / span, replay.arm.acceleration)


def _share(piece: Piece, arm: Arm, rates: FloatArray, most: FloatArray) -> Finding:
    share = (np.abs(rates) / most).max(axis=0) - 1.0
    return piece.finds(float(share.max()), arm.joints[int(share.argmax())])


def drifts(replay: Replay) -> Iterator[Finding]:
    """How far positions are from the integral of velocities [rad]: what is a little off each time adds up."""
    for piece, span, positions, velocities in _stretches(replay):
        way = np.cumsum(0.5 * (velocities[1:] + velocities[:-1]) * span, axis=0)
        yield piece.finds(float(np.abs(positions[1:] - positions[0] - way).max()))


def strays(replay: Replay) -> Iterator[Finding]:
    """How far [m] a controller's spline takes a joint or the tool off the straight edges that were checked.

    ROS 2's joint trajectory controller drives a cubic through positions and velocities, others one through
    the positions alone.
    """
    for piece, way in replay.once(ways):
        if len(way.times) > 1 and (np.diff(way.times) > 0.0).all():
            yield piece.finds(_stray(replay.arm, piece.segment.tool, *way))


def _stray(arm: Arm, tool: str, times: FloatArray, positions: FloatArray, velocities: FloatArray) -> float:
    begin, way = (
        np.repeat(each, len(QUARTERS), axis=0) for each in (positions[:-1], np.diff(positions, axis=0))
    )
    at = (times[:-1, None] + np.diff(times)[:, None] * np.array(QUARTERS)).ravel()
    length = np.maximum((way * way).sum(axis=1), np.finfo(float).tiny)
    worst = 0.0
    for spline in (
        CubicHermiteSpline(times, positions, velocities), CubicSpline(times, positions, bc_type="clamped"),
    ):  # fmt: skip
        q = np.asarray(spline(at))
        share = np.clip(((q - begin) * way).sum(axis=1) / length, 0.0, 1.0)
        straight = begin + share[:, None] * way
        most = (arm.chain.reach + 1.0) * np.abs(q - straight).sum(axis=1)  # with a tool of a metre
        far = most > STRAYED
        if far.any():
            hands = (arm.tool_pose(each[far], tool) for each in (q, straight))
            links = (arm.chain.frames(each[far]) for each in (q, straight))
            for a, b in (tuple(hands), tuple(links)):
                worst = max(worst, float(np.linalg.norm((a - b)[..., :3, 3], axis=-1).max()))
    return worst
