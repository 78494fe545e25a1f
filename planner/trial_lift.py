"""Lifting a little and looking before lifting on: what moves along was held by the object, or holds it."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from topple.planner.motion.trajectory import Trajectory
from topple.planner.pick_place.segments import Segment
from topple.robots.simulated_arm import SimulatedArm

TRIAL = 0.005  # [m] lifted before the look: half of what counts as disturbed, and more than noise shows
CALM = 0.15  # [s] until what was moved is at rest enough for a look

Watch = Callable[[], Callable[[], tuple[str, ...]]]
"""Looks now; what it returns looks again, and names what moved in between."""


def try_lift(segment: Segment, robot: SimulatedArm, watch: Watch) -> tuple[Segment, tuple[str, ...]]:
    """Lifts by `TRIAL`, looks, and goes back down where something moved along.

    Args:
        segment: The lift.
        robot: The arm, with the object in its hand.
        watch: Who looks.

    Returns:
        What is left of the lift, and the names of what moved.
    """
    assert segment.trajectory is not None
    way = segment.trajectory
    places = robot.arm.tool_pose(way.positions, segment.tool)[:, :3, 3]
    risen = np.linalg.norm(places - places[0], axis=1)
    parted = min(max(int(np.searchsorted(risen, TRIAL)), 1), len(way.times) - 2)
    first, rest = piece(way, 0, parted), piece(way, parted, len(way.times) - 1)
    moved_since = watch()
    robot.follow(first)
    robot.wait(CALM)
    moved = moved_since()
    if moved:
        robot.follow(backwards(first))
        robot.wait(CALM)
    return replace(segment, trajectory=rest), moved


def piece(trajectory: Trajectory, begin: int, end: int) -> Trajectory:
    """A piece of a trajectory, from one sample to another, that starts and ends at rest.

    Args:
        trajectory: The whole.
        begin: Number of the first sample.
        end: Number of the last one.

    Returns:
        The same way in one and a half times the time, which keeps the largest speed.
    """
    count = max(int(np.ceil(1.5 * (end - begin))), 2)
    share = np.linspace(0.0, 1.0, count + 1)
    at = begin + (end - begin) * (3.0 * share**2 - 2.0 * share**3)
    samples = np.arange(len(trajectory.times))
    times = 1.5 * share * float(trajectory.times[end] - trajectory.times[begin])
    positions = np.stack([np.interp(at, samples, column) for column in trajectory.positions.T], axis=1)
    return Trajectory(times, positions, np.gradient(positions, times, axis=0))


def backwards(trajectory: Trajectory) -> Trajectory:
    """The way back along a trajectory, in the same time."""
    times = trajectory.times[-1] - trajectory.times[::-1]
    return Trajectory(times, trajectory.positions[::-1].copy(), -trajectory.velocities[::-1])
