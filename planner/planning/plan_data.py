"""Transfers as plan data."""

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from topple.planner.decide.dependency import Dependency
from topple.planner.formats.plan_structs import (
    AttachmentData,
    AwayData,
    DependencyData,
    GraspData,
    Matrix,
    ObjectData,
    PlacementData,
    Step,
)
from topple.planner.placement.away import Receiver
from topple.planner.planning.step import NextStep
from topple.planner.transfer.segments import Segment
from topple.robots.arm.gripper import ToolState
from topple.robots.driver import Trajectory
from topple.topology.base.arrays import FloatArray
from topple.topology.situation.situation import Situation

DIGITS = 6  # micrometres and microradians: below what any arm can tell


def step_data(
    chosen: NextStep,
    reason: str,
    after: list[int],
    moved: Mapping[str, FloatArray],
    seconds: float,
    against: list[DependencyData],
) -> Step:
    """A step as a plan has it, its numbers rounded to a millionth.

    Args:
        chosen: The step, with its transfer.
        reason: Why, in a sentence.
        after: Indices of the steps it has to follow.
        moved: Rigid transforms (4, 4) of the objects since the plan began, for those that moved.
        seconds: What it took to find it.
        against: Doubtful dependencies that it goes against.
    """
    transfer, grasp, place = chosen.transfer, chosen.transfer.grasp, chosen.transfer.placement
    to_tool = np.linalg.inv(grasp.pose_tool_to_world)
    return Step(
        object=transfer.object,
        action=str(chosen.action),
        reason=reason,
        after=after,
        grasp=GraspData(
            str(grasp.kind),
            _round(grasp.pose_tool_to_world),
            round(grasp.width, DIGITS),
            round(grasp.score, DIGITS),
            grasp.reason,
            {name: round(value, DIGITS) for name, value in grasp.terms.items()},
        ),
        placement=PlacementData(
            _round(place.pose_before_to_after),
            place.rest,
            round(place.drop, DIGITS),
            place.into,
            "" if place.how is None else str(place.how),
            place.falls,
        ),
        segments=[_rounded_segment(segment) for segment in transfer.segments],
        attachments=[
            AttachmentData(name, grasp.tool, _round(to_tool @ moved.get(name, np.eye(4))))
            for name in (transfer.object, *transfer.riding)
        ],
        upright=transfer.upright,
        planning_seconds=round(seconds, 3),
        against=against,
        fallbacks=[str(name) for name in chosen.all_fallbacks],
        buffer=chosen.buffer,
        unseen=grasp.unseen,
    )


def _round(matrix: FloatArray) -> Matrix:
    return np.round(matrix, DIGITS).tolist()


def away_data(away: Receiver) -> AwayData:
    """Where things go that are taken, as data."""
    return AwayData(str(away.how), _round(away.pose), np.round(away.size, DIGITS).tolist())


def said_unseen(steps: Sequence[Step]) -> tuple[str, ...]:
    """The sentence on objects at which a hand comes in through space that no camera saw to be empty."""
    names = ", ".join(dict.fromkeys(step.object for step in steps if step.unseen))
    words = f"no camera saw the hand's way to {names} to be empty: it is taken to be; look there before"
    return (words,) if names else ()


def dependency_data(edge: Dependency) -> DependencyData:
    """A dependency as data."""
    return DependencyData(edge.first, edge.then, str(edge.reason), round(float(edge.confidence), 4))


def objects_data(situation: Situation) -> list[ObjectData]:
    """The objects of a situation as a plan keeps them, and the matter around them as one that never moves."""
    scene, solids, whole = situation.scene, situation.solids, situation.completed
    return [
        ObjectData(
            name,
            name not in scene.movable,
            rounded_parts(solids[name]),
            [] if whole[name] is solids[name] else rounded_parts(whole[name]),
        )
        for name in solids
    ]


def rounded_parts(parts: Sequence[FloatArray]) -> list[list[list[float]]]:
    """Convex parts (V, 3) as a plan keeps them."""
    return [_round(part) for part in parts]


def _rounded_segment(segment: Segment) -> Segment:
    hand = ToolState(round(segment.hand.opening, DIGITS), round(segment.hand.cup_extension, DIGITS))
    motion = segment.motion
    if motion is not None:
        times, positions, velocities = (np.round(each, DIGITS) for each in motion)
        kept = np.append(np.diff(times) > 0.0, True)  # the last sample may follow within a microsecond
        motion = Trajectory(times[kept], positions[kept], velocities[kept])
    return replace(segment, hand=hand, motion=motion, clearance=round(segment.clearance, DIGITS))
