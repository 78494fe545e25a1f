"""The joints' part of a plan: limits, smooth joins, and velocities that are those of the positions."""

import numpy as np

from topple.planner.formats.plan_structs import PlanData, SegmentData
from topple.planner.formats.verification import Residual, Worst
from topple.planner.verify.tolerances import AT_REST, DRIFT, JUMP, LIP, OVER
from topple.robots.arm.arm import Arm
from topple.topology.arrays import FloatArray


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
    found: list[tuple[str, float, float]] = []
    if arm.jaw is not None:
        found.append(("opening", segment.hand.opening, arm.jaw.max_opening))
    if arm.cup is not None:
        found.append(("cup_extension", segment.hand.cup_extension, arm.cup.stroke))
    return found


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
        driven = np.cumsum(0.5 * (velocities[1:] + velocities[:-1]) * span, axis=0)
        drift = np.abs(positions[1:] - positions[0] - driven)  # what is a little off each time adds up
        found["integral"].note(float(drift.max()), where, step)
    return positions[-1]
