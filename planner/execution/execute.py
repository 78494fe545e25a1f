"""Carries out one transfer with an arm in the world, noticing when the object is not in the hand any more."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from topple.planner.execution.lift_monitor import LiftMonitor
from topple.planner.execution.tolerances import (
    AT_HOME,
    FAR,
    JOINING,
    LETTING_GO,
    OFF_COURSE,
    PATH_SAMPLES,
    RESUMED,
    SHALLOW,
    SHUT,
    SLOW,
    SLOW_WAY,
    SPEED,
    STILL,
    TOUCHDOWN,
)
from topple.planner.formats.arm_motion import ArmMotion
from topple.planner.grasp.tolerances import RELEASE_GAP
from topple.planner.motion.collision import Checker
from topple.planner.motion.planner import MotionFailure, plan_motion
from topple.planner.motion.trajectory import retime
from topple.planner.transfer.segments import Segment, SegmentKind, no_faster_than
from topple.planner.transfer.tolerances import MARGIN
from topple.planner.transfer.transfer import Transfer
from topple.robots.driver import Driver, Interruptible, Trajectory
from topple.robots.world.acting_arm import ActingArm
from topple.robots.world.physical_world import PhysicalWorld
from topple.topology.base.arrays import FloatArray
from topple.topology.base.errors import ToppleError
from topple.topology.bodies.solids import Solids
from topple.topology.geometry.rigid import move_points

WATCHED = (
    SegmentKind.LIFT,
    SegmentKind.TRANSFER,
    SegmentKind.PLACE,
)  # segments during which the object must be in the hand
GUARDED = (SegmentKind.APPROACH, SegmentKind.PLACE)  # segments that a force at the wrist ends

TAKEN, LET_GO, MISSED = "taken", "let go", "missed"
Watch = Callable[[str, str], None]
"""Called when an object was taken, is about to be let go, or is missed, with that and the tool's name."""


@dataclass(frozen=True, eq=False)
class Outcome:
    """Result of executing a transfer.

    Attributes:
        success: The object was taken, carried and let go where it should be.
        text: What happened, in one sentence.
        tool_path: (k, 3) planned positions of the tool in the world [m], of the segments that were driven.
        stuck: The hand does not let go of the object: the arm must stay where it is.
        motion: The planned motion of the segments that were driven, for pictures.
        moved: What was seen to move as the object was lifted, with how far [m]: the object was put back.
    """

    success: bool
    text: str
    tool_path: FloatArray
    stuck: bool = False
    motion: ArmMotion | None = None
    moved: Mapping[str, float] = field(default_factory=dict[str, float])


class HandStuck(ToppleError):
    """A hand does not let go: wherever the arm went, it would drag what it holds along."""


def execute(
    transfer: Transfer, robot: Driver, watch: Watch | None = None, monitor: LiftMonitor | None = None
) -> Outcome:
    """Drives the segments one after the other.

    A grasp that closes on nothing, a cup that does not seal or an object lost on the way ends it: the hand
    opens and the arm goes straight up, so that the next look finds it out of the way. An arm that was pushed
    off its path comes back to it and goes on. An object whose lift moves another one is put back.

    Args:
        transfer: What to do; it should start where the arm is.
        robot: The arm.
        watch: What looks on, if anything.
        monitor: What the first of a lift is watched with, by an arm that can be stopped.
    """
    done: list[Segment] = []
    ended: list[Segment] = []
    watch = watch or (lambda moment, tool: None)
    resumed: list[str] = []
    problem, moved = None, dict[str, float]()
    try:
        for segment in transfer.segments:
            if segment.kind is SegmentKind.RELEASE:
                watch(LET_GO, segment.tool)
            if segment.kind is SegmentKind.LIFT and monitor is not None and isinstance(robot, Interruptible):
                segment, moved = _begin_lift(segment, transfer, robot, monitor)
                problem = _put_back_text(moved, transfer.object) if moved else None
            problem = problem or _drive(segment, transfer.object, robot, resumed)
            if segment.motion is not None and not moved:
                done.append(segment)
            if problem is not None:
                watch(MISSED, segment.tool)
                retreat(done, robot)
                break
            ended.append(segment)
            if segment.kind is SegmentKind.GRASP:
                watch(TAKEN, segment.tool)
    except HandStuck as error:
        text = (
            f"the hand does not open and holds {transfer.object} still, the arm stays where it is: {error}."
        )
        words = " ".join(filter(None, (problem, text)))
        return Outcome(False, words, _tool_path(done, robot), True, _motion(transfer, ended, robot))
    kept = all(segment.kind is not SegmentKind.RELEASE for segment in transfer.segments)
    put = f"{transfer.object} {'is held' if kept else 'was put down'}, {transfer.placement.rest}."
    off = f"The arm was off its path during the {' and the '.join(resumed)}." if resumed else None
    text = " ".join(filter(None, (problem or put, off)))
    way, motion = _tool_path(done, robot), _motion(transfer, ended, robot)
    return Outcome(problem is None, text, way, motion=motion, moved=moved)


def _begin_lift(
    segment: Segment, transfer: Transfer, robot: Driver, monitor: LiftMonitor
) -> tuple[Segment, Mapping[str, float]]:
    """Lift slowly for a few centimetres, watched; down again where that moves something.

    Returns:
        What is left of the lift, and what was seen to move, by how far [m].
    """
    assert isinstance(robot, Interruptible) and segment.motion is not None
    path = segment.motion.positions
    places = robot.arm.tool_pose(path, segment.tool)[:, :3, 3]
    ways = np.linalg.norm(places - places[0], axis=1)
    first = min(int(np.searchsorted(ways, SLOW_WAY)) + 1, len(path))
    slow = no_faster_than(retime(robot.arm, path[:first], SPEED), float(ways[first - 1]), SLOW)
    beside = robot.q_target - path[0]  # a hand gives way as it closes
    detector = monitor.detector(transfer, robot, slow.positions + beside)
    for _ in range(len(monitor.images)):
        robot.wait(STILL)
        if not detector.take_reference():
            break
    robot.follow_while(slow, detector.still)
    if detector.moved:
        robot.follow(_way_back(slow, robot.q_target - beside), keep_offset=True)
        return segment, detector.moved
    rest = path[first - 1 :]
    motion = None
    if len(rest) > 1:
        speed = float(ways[-1]) / float(segment.motion.times[-1])
        motion = no_faster_than(retime(robot.arm, rest, SPEED), float(ways[-1] - ways[first - 1]), speed)
    return replace(segment, motion=motion), {}


def _put_back_text(moved: Mapping[str, float], name: str) -> str:
    """Say why an object was put back, in a sentence."""
    some = " and ".join(f"{other} by {1e3 * off:.1f} mm" for other, off in sorted(moved.items()))
    return f"{name} was put back: lifting it moved {some}."


def _way_back(path: Trajectory, q: FloatArray) -> Trajectory:
    """The way back along a path from joint values (n,) on it."""
    come = max(int(np.abs(path.positions - q).max(axis=1).argmin()) + 1, 2)
    positions, velocities = path.positions[:come][::-1], -path.velocities[:come][::-1]
    return Trajectory(path.times[:come], positions, velocities)


def go_home(robot: Driver, solids: Solids, seed: int) -> None:
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
    """Lets go, no wider than the hand was open on its way in, and backs out along that way.

    Raises:
        HandStuck: The hand does not let go.
    """
    last = done[-1] if done else None
    _let_go(robot, last.hand.opening if last is not None and last.kind is SegmentKind.APPROACH else None)
    if last is None:
        return
    if last.kind is SegmentKind.APPROACH and last.motion is not None:
        robot.follow(_way_back(last.motion, robot.q_target))  # it may have stopped before its end
    robot.extend(robot.arm.on_the_way(0.0).cup_extension)
    robot.open()


def taken_over(world: PhysicalWorld, robot: ActingArm, name: str) -> None:
    """Take an object out of the hand, as somebody or a skill of one's own would: it stands far away then.

    Raises:
        HandStuck: The hand does not let go.
    """
    sealed = robot.sealed is not None
    if sealed:
        _let_go(robot, None)
    body, away = world.body(name), np.eye(4)
    away[:3, 3] = FAR
    world.remove(name)
    world.add(body, away, fixed=True)
    if not sealed:
        _let_go(robot, None)


def _drive(segment: Segment, name: str, robot: Driver, resumed: list[str]) -> str | None:
    """Drives one segment; a sentence where it went wrong. Where it was off its path and went on is noted."""
    if segment.kind is SegmentKind.GRASP:
        return robot.arm.tools[segment.tool].gripper.take(robot, name)
    if segment.kind is SegmentKind.RELEASE:
        # what is held may be wider than it looked
        _let_go(robot, max(segment.hand.opening, robot.opening + RELEASE_GAP))
        robot.wait(0.25)  # what was let go comes to rest before the hand leaves
        return None
    if segment.motion is None:
        return None
    gripper = robot.arm.tools[segment.tool].gripper
    if segment.kind in (SegmentKind.MOVE, SegmentKind.APPROACH, SegmentKind.RETREAT):
        if gripper.limits.cup_extension or segment.kind is SegmentKind.MOVE:
            robot.extend(segment.hand.cup_extension)
        if segment.kind is not SegmentKind.RETREAT:
            robot.open(segment.hand.opening)
            if robot.opening < (wanted := min(segment.hand.opening, robot.arm.hand_limits.opening)) - SHUT:
                short = f"{1e3 * robot.opening:.0f} mm instead of {1e3 * wanted:.0f} mm"
                return f"the hand does not open: its pads are {short} apart."
    if segment.kind in GUARDED:
        robot.wait(STILL)
        guard = TOUCHDOWN if segment.kind is SegmentKind.PLACE else gripper.touch
        error = robot.follow_until(segment.motion, guard)
    else:  # a hand that gave way as it closed lifts straight up from where it is
        lifting = segment.kind is SegmentKind.LIFT
        error = robot.follow(segment.motion, keep_offset=lifting)
        for _ in range(RESUMED):
            if error <= OFF_COURSE or (segment.kind in WATCHED and not robot.holding):
                break
            error = _resume(segment.motion, robot)
            if error <= OFF_COURSE:
                resumed.append(str(segment.kind))
    if segment.kind is SegmentKind.APPROACH and not gripper.presses and _way_left(segment, robot) > SHALLOW:
        return f"the fingers met something on their way to {name}."
    if segment.kind in WATCHED and not robot.holding:
        return f"{name} slipped out of the hand during the {segment.kind}."
    return f"the arm was held up during the {segment.kind}." if error > OFF_COURSE else None


def _resume(path: Trajectory, robot: Driver) -> float:
    """Brings an arm back to the nearest place of its path and drives the rest of it; the error at the end."""
    nearest = int(np.abs(path.positions - robot.q_target).max(axis=1).argmin())
    there = np.stack([path.positions[nearest]] * 2)
    robot.follow(Trajectory(np.array([0.0, JOINING]), there, np.zeros_like(there)))
    rest = path.positions[nearest:]
    if len(rest) < 2:
        return float(np.abs(robot.q_target - path.positions[-1]).max())
    return robot.follow(retime(robot.arm, rest, SPEED))


def _let_go(robot: Driver, opening: float | None) -> None:
    """Opens the hand to a pad distance [m], or switches the vacuum off.

    Raises:
        HandStuck: It holds on, though it was told so more than once.
    """
    for _ in range(LETTING_GO):
        robot.release(opening)
        if not robot.holding:
            return
    raise HandStuck(f"its pads are {1e3 * robot.opening:.0f} mm apart")


def _way_left(segment: Segment, robot: Driver) -> float:
    """How far the tool stopped before the end of a segment [m]."""
    assert segment.motion is not None
    states = np.stack([robot.q_target, segment.motion.positions[-1]])
    here, there = robot.arm.tool_pose(states, segment.tool)[:, :3, 3]
    return float(np.linalg.norm(there - here))


def _tool_path(done: list[Segment], robot: Driver) -> FloatArray:
    """(k, 3) in the world [m]."""
    pieces = [np.zeros((0, 3))]
    for segment in done:
        if segment.motion is not None:
            q = segment.motion.positions
            chosen = q[np.unique(np.linspace(0, len(q) - 1, PATH_SAMPLES).astype(int))]
            base = robot.arm.tool_pose(chosen, segment.tool)[:, :3, 3]
            pieces.append(move_points(base, robot.pose_base_to_world))
    return np.vstack(pieces)


def _motion(transfer: Transfer, ended: list[Segment], robot: Driver) -> ArmMotion | None:
    """How the arm went through the segments that it came to the end of."""
    carry = ended, (transfer.object, *transfer.riding), np.zeros(3)
    return ArmMotion.of(robot.arm, robot.pose_base_to_world, [carry])
