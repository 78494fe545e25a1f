"""Carries out one transfer with an arm in the world, noticing when the object is not in the hand any more."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from topple.planner.execution.tolerances import AT_HOME, NOTHING, OFF_COURSE, SHALLOW, SPEED, STILL, TOUCHDOWN
from topple.planner.grasp.tolerances import PRESS
from topple.planner.motion.collision import Checker
from topple.planner.motion.planner import MotionFailure, plan_motion
from topple.planner.motion.trajectory import retime
from topple.planner.transfer.segments import Segment, SegmentKind
from topple.planner.transfer.tolerances import MARGIN, RELEASE_GAP
from topple.planner.transfer.transfer import Transfer
from topple.robots.driver import Driver
from topple.topology.arrays import FloatArray
from topple.topology.bodies.solids import Solids

WATCHED = (
    SegmentKind.LIFT,
    SegmentKind.TRANSFER,
    SegmentKind.PLACE,
)  # segments during which the object must be in the hand
GUARDED = (SegmentKind.APPROACH, SegmentKind.PLACE)  # segments that a force at the wrist ends
TOUCHED = {"fingers": 2.0, "suction": 8.0}  # [N] moves no can yet; seats a cup's lip
SAMPLES = 40  # of the tool's path per segment, for pictures


TAKEN, LET_GO, MISSED = "taken", "let go", "missed"
Watch = Callable[[str, str], None]
"""Called when an object was taken, is about to be let go, or is missed, with that and the tool's name."""


@dataclass(frozen=True, eq=False)
class Outcome:
    """What became of a transfer.

    Attributes:
        success: The object was taken, carried and let go where it should be.
        text: What happened, in one sentence.
        tool_path: (k, 3) planned positions of the tool in the world [m], of the segments that were driven.
    """

    success: bool
    text: str
    tool_path: FloatArray


def execute(transfer: Transfer, robot: Driver, watch: Watch | None = None) -> Outcome:
    """Drives the segments one after the other.

    A grasp that closes on nothing, a cup that does not seal or an object lost on the way ends it: the hand
    opens and the arm goes straight up, so that the next look finds it out of the way.

    Args:
        transfer: What to do; it should start where the arm is.
        robot: The arm.
        watch: What looks on, if anything.
    """
    done: list[Segment] = []
    watch = watch or _nobody
    for segment in transfer.segments:
        if segment.kind is SegmentKind.RELEASE:
            watch(LET_GO, segment.tool)
        problem = _drive(segment, transfer.object, robot)
        if segment.trajectory is not None:
            done.append(segment)
        if problem is not None:
            watch(MISSED, segment.tool)
            retreat(done, robot)
            return Outcome(False, problem, _tool_path(done, robot))
        if segment.kind is SegmentKind.GRASP:
            watch(TAKEN, segment.tool)
    return Outcome(
        True, f"{transfer.object} was put down, {transfer.placement.rest}.", _tool_path(done, robot)
    )


def _nobody(_moment: str, _tool: str) -> None:
    """Nothing looks on."""


def withdraw(robot: Driver, solids: Solids, seed: int) -> None:
    """Brings the arm home, out of the cameras' view, where there is a free way.

    Args:
        robot: The arm.
        solids: Convex parts of everything, in the world [m], as they should be now.
        seed: Of the search.
    """
    home = np.asarray(robot.arm.home)
    if np.abs(robot.q_target - home).max() < AT_HOME:
        return
    base, state = robot.pose_base_to_world, robot.tool_state
    checker = Checker(robot.arm, base, solids, tool_state=state, margin=MARGIN)
    near = [frozenset((contact.a, contact.b)) for contact in checker.contacts(robot.q_target)]
    if near:  # the hand may leave what it is still next to
        checker = Checker(robot.arm, base, solids, tool_state=state, allow=near, margin=MARGIN)
    found = plan_motion(checker, robot.q_target, home[None], seed=seed)
    if not isinstance(found, MotionFailure):
        robot.follow(retime(robot.arm, found.path, SPEED))


def retreat(done: list[Segment], robot: Driver) -> None:
    """Lets go, no wider than the hand was open on its way in, and backs out along that way."""
    if not done:
        robot.release()
        return
    last = done[-1]
    robot.release(last.hand.opening if last.kind is SegmentKind.APPROACH else None)
    if last.kind is SegmentKind.APPROACH and last.trajectory is not None:
        path = last.trajectory
        come = int(np.abs(path.positions - robot.q_target).max(axis=1).argmin()) + 1  # it may have stopped
        if come > 1:
            positions, velocities = path.positions[:come][::-1], -path.velocities[:come][::-1]
            robot.follow(
                type(path)(
                    path.times[:come], np.ascontiguousarray(positions), np.ascontiguousarray(velocities)
                )
            )
    robot.extend(robot.arm.on_the_way(0.0).cup_extension)
    robot.open()


def _drive(segment: Segment, name: str, robot: Driver) -> str | None:
    """Drives one segment; a sentence where it went wrong."""
    if segment.kind is SegmentKind.GRASP:
        return _take(segment, name, robot)
    if segment.kind is SegmentKind.RELEASE:
        # what is held may be wider than it looked
        robot.release(max(segment.hand.opening, robot.opening + RELEASE_GAP))
        robot.wait(0.25)  # what was let go comes to rest before the hand leaves
        return None
    if segment.trajectory is None:
        return None
    if segment.kind in (SegmentKind.MOVE, SegmentKind.APPROACH, SegmentKind.RETREAT):
        if segment.tool == "suction" or segment.kind is SegmentKind.MOVE:
            robot.extend(segment.hand.cup_extension)
        if segment.kind is not SegmentKind.RETREAT:
            robot.open(segment.hand.opening)
    guard = TOUCHDOWN if segment.kind is SegmentKind.PLACE else TOUCHED.get(segment.tool)
    if segment.kind in GUARDED and guard is not None:
        robot.wait(STILL)
        error = robot.follow_until(segment.trajectory, guard)
    else:  # a hand that gave way as it closed lifts straight up from where it is
        error = robot.follow(segment.trajectory, keep_offset=segment.kind is SegmentKind.LIFT)
    if (
        segment.kind is SegmentKind.APPROACH
        and segment.tool == "fingers"
        and _way_left(segment, robot) > SHALLOW
    ):
        return f"the fingers met something on their way to {name}."
    if segment.kind in WATCHED and not robot.holding:
        return f"{name} slipped out of the hand during the {segment.kind}."
    if error > OFF_COURSE:
        return f"the arm was held up during the {segment.kind}."
    return None


def _way_left(segment: Segment, robot: Driver) -> float:
    """How far the tool stopped before the end of a segment [m]."""
    assert segment.trajectory is not None
    states = np.stack([robot.q_target, segment.trajectory.positions[-1]])
    here, there = robot.arm.tool_pose(states, segment.tool)[:, :3, 3]
    return float(np.linalg.norm(there - here))


def _take(segment: Segment, name: str, robot: Driver) -> str | None:
    if segment.tool == "suction":
        robot.wait(0.2)
        return None if robot.suck() else f"the cup found no seal on {name}."
    jaw = robot.arm.tools[segment.tool].gripper
    opening = robot.close(PRESS * getattr(jaw, "force", 0.0))
    robot.wait(0.2)
    if opening < NOTHING or not robot.holding:
        return f"the fingers closed {'on nothing' if opening < NOTHING else f'without holding {name}'}."
    return None


def _tool_path(done: list[Segment], robot: Driver) -> FloatArray:
    """(k, 3) in the world [m]."""
    pieces = [np.zeros((0, 3))]
    for segment in done:
        if segment.trajectory is not None:
            q = segment.trajectory.positions
            chosen = q[np.unique(np.linspace(0, len(q) - 1, SAMPLES).astype(int))]
            base = robot.arm.tool_pose(chosen, segment.tool)[:, :3, 3]
            pieces.append(base @ robot.pose_base_to_world[:3, :3].T + robot.pose_base_to_world[:3, 3])
    return np.vstack(pieces)
