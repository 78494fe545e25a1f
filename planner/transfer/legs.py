"""The legs of a transfer: joint paths with what they were checked against, made into timed segments."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from topple.planner.grasp.grasp import Grasp
from topple.planner.motion.certificate import Certificate
from topple.planner.motion.collision import Checker
from topple.planner.motion.trajectory import retime
from topple.planner.placement.placement import Placement
from topple.planner.transfer.handling import Handling
from topple.planner.transfer.segments import Segment, no_faster_than
from topple.topology.arrays import FloatArray


@dataclass(eq=False)
class Leg:
    """One motion of a transfer.

    Attributes:
        kind: One of `topple.planner.transfer.segments.KINDS` that moves the arm.
        path: (k, n) joint values [rad].
        checker: What it was checked against.
        straight: Whether the tool goes in a straight line, slowly.
        certificate: The proof that it is free, once there is one.
    """

    kind: str
    path: FloatArray
    checker: Checker
    straight: bool = False
    certificate: Certificate | None = None


def segments_of(
    legs: Sequence[Leg],
    handling: Handling,
    grasp: Grasp,
    place: Placement,
    speed: float,
    straight_speed: float,
) -> tuple[Segment, ...]:
    """Time the legs, and put grasp and release between them.

    Args:
        legs: Move, approach, lift, transfer, place and retreat.
        handling: Of the object.
        grasp: How it is held.
        place: Where it goes.
        speed: Share of the joints' velocity limits.
        straight_speed: Of the tool on straight legs [m/s].

    Returns:
        The segments in the order they are driven.
    """
    ready, closed = handling.ready(grasp), handling.closed(grasp)
    released = handling.released(grasp, place.into)
    hands = {"move": handling.arm.on_the_way(ready.opening), "approach": ready, "retreat": released}
    segments: list[Segment] = []
    for leg in legs:
        pairs = tuple((min(pair), max(pair)) for pair in sorted(leg.checker.allow, key=sorted))
        if leg.kind == "lift":
            segments.append(Segment("grasp", grasp.tool, closed, None, handling.name, pairs))
        if leg.kind == "retreat":
            segments.append(Segment("release", grasp.tool, released, None, None, pairs))
        trajectory = retime(handling.arm, leg.path, speed)
        if leg.straight:
            places = handling.arm.tool_pose(leg.path, grasp.tool)[:, :3, 3]
            way = float(np.linalg.norm(np.diff(places, axis=0), axis=1).sum())
            trajectory = no_faster_than(trajectory, way, straight_speed)
        hand, holding = (hands[leg.kind], None) if leg.kind in hands else (closed, handling.name)
        segments.append(Segment(leg.kind, grasp.tool, hand, trajectory, holding, pairs, leg.certificate))
    return tuple(segments)
