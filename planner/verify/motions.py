"""The joints' part of a plan: limits, smooth joins, and velocities that are those of the positions."""

import numpy as np
from scipy.interpolate import CubicHermiteSpline, CubicSpline

from topple.planner.formats.plan_structs import PlanData, SegmentData
from topple.planner.formats.verification import Residual, Worst
from topple.planner.verify.tolerances import AT_REST, DRIFT, JUMP, LIP, OVER, QUARTERS, STRAYED
from topple.robots.arm.arm import Arm
from topple.topology.base.arrays import FloatArray


def check_motions(plan: PlanData, arm: Arm) -> tuple[Residual, ...]:
    """Check every motion of a plan against the arm's limits.

    Args:
        plan: The plan.
        arm: The arm.

    Returns:
        Residuals of joint positions, velocities, accelerations, continuity and times.
    """
    found = {
        "position": Worst("joint positions", "rad", 1e-6),
        "velocity": Worst("joint velocities", "1", OVER),
        "acceleration": Worst("joint accelerations", "1", OVER),
        "continuity": Worst("continuity", "rad", JUMP),
        "rest": Worst("rest at the joins", "rad/s", AT_REST),
        "integral": Worst("positions from velocities", "rad", DRIFT),
        "times": Worst("times that do not increase", "1"),
        "spline": Worst("splines through the samples off the straight way", "m", STRAYED),
    }
    q = np.array(plan.q_start)
    for index, step in enumerate(plan.steps):
        for segment in step.segments:
            where = f"step {index + 1} ({step.object}), {segment.kind}"
            for what, value, most in _hand(segment, arm):
                found["position"].note(max(value - most, -value) - LIP, f"{where}: {what}", index)
            if segment.motion is None:
                continue
            q = _check_motion(segment, q, arm, found, where, index)
    return tuple(worst.residual() for worst in found.values())


def _hand(segment: SegmentData, arm: Arm) -> list[tuple[str, float, float]]:
    """How the hand stands, and how far it goes [m]."""
    return [
        ("opening", segment.hand.opening, arm.jaw.max_opening if arm.jaw is not None else 0.0),
        ("cup_extension", segment.hand.cup_extension, arm.cup.stroke if arm.cup is not None else 0.0),
    ]


def _check_motion(
    segment: SegmentData, q: FloatArray, arm: Arm, found: dict[str, Worst], where: str, step: int
) -> FloatArray:
    assert segment.motion is not None
    times = np.array(segment.motion.times)
    positions, velocities = np.array(segment.motion.positions), np.array(segment.motion.velocities)
    beyond = np.maximum(positions - arm.upper, arm.lower - positions).max(axis=0)
    found["position"].note(float(beyond.max()), f"{where}: {arm.joints[int(beyond.argmax())]}", step)
    found["continuity"].note(float(np.abs(positions[0] - q).max()), where, step)
    found["rest"].note(float(np.abs(velocities[[0, -1]]).max()), where, step)
    found["times"].note(float(times[0] != 0.0), f"{where}: it begins at {times[0]:g} s", step)
    if len(times) > 1:
        span = np.diff(times)[:, None]
        found["times"].note(float(np.count_nonzero(span <= 0.0)), where, step)
        span = np.maximum(span, 1e-9)
        mean = np.diff(positions, axis=0) / span
        for speeds in (velocities, mean):
            share = (np.abs(speeds) / arm.velocity).max(axis=0) - 1.0
            found["velocity"].note(float(share.max()), f"{where}: {arm.joints[int(share.argmax())]}", step)
        share = (np.abs(np.diff(velocities, axis=0) / span) / arm.acceleration).max(axis=0) - 1.0
        found["acceleration"].note(float(share.max()), f"{where}: {arm.joints[int(share.argmax())]}", step)
        if not (np.diff(times) <= 0.0).any():
            found["spline"].note(_strayed(arm, segment.tool, times, positions, velocities), where, step)
        driven = np.cumsum(0.5 * (velocities[1:] + velocities[:-1]) * span, axis=0)
        drift = np.abs(positions[1:] - positions[0] - driven)  # what is a little off each time adds up
        found["integral"].note(float(drift.max()), where, step)
    return positions[-1]


def _strayed(arm: Arm, tool: str, times: FloatArray, positions: FloatArray, velocities: FloatArray) -> float:
    """How far [m] a controller's spline takes a joint or the tool off the straight edges that were checked.

    ROS 2's joint trajectory controller drives a cubic through positions and velocities, others one through
    the positions alone.
    """
    begin, way = (
        np.repeat(positions[:-1], len(QUARTERS), axis=0),
        np.repeat(np.diff(positions, axis=0), len(QUARTERS), axis=0),
    )
    at = (times[:-1, None] + np.diff(times)[:, None] * np.array(QUARTERS)).ravel()
    length = np.maximum((way * way).sum(axis=1), np.finfo(float).tiny)
    worst = 0.0
    for spline in (
        CubicHermiteSpline(times, positions, velocities), CubicSpline(times, positions, bc_type="clamped"),
    ):  # fmt: skip
        driven = np.asarray(spline(at))
        share = np.clip(((driven - begin) * way).sum(axis=1) / length, 0.0, 1.0)
        straight = begin + share[:, None] * way
        most = (arm.chain.reach + 1.0) * np.abs(driven - straight).sum(axis=1)  # with a tool of a metre
        far = most > STRAYED
        if far.any():
            hands = (arm.tool_pose(q[far], tool) for q in (driven, straight))
            links = (arm.chain.frames(q[far]) for q in (driven, straight))
            for a, b in (tuple(hands), tuple(links)):
                worst = max(worst, float(np.linalg.norm((a - b)[..., :3, 3], axis=-1).max()))
    return worst
