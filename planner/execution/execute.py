"""Carries out one transfer with an arm in the world, noticing when the object is not in the hand any more."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from topple.planner.bodies.solids import Solids
from topple.planner.grasp.hand import PRESS
from topple.planner.motion.collision import Checker
from topple.planner.motion.planner import MotionFailure, plan_motion
from topple.planner.motion.trajectory import retime
from topple.planner.transfer.checks import MARGIN, RELEASE_GAP
from topple.planner.transfer.segments import Segment
from topple.planner.transfer.transfer import Transfer
from topple.robots.poses import angle_between
from topple.robots.world.simulated_arm import SimulatedArm
from topple.topology.arrays import FloatArray

WATCHED = ("lift", "transfer", "place")  # segments during which the object must be in the hand
TOUCHDOWN = 1.0  # [N] an object that presses this much on what is below stands on it: the arm goes no further
TOUCHED = 2.0  # [N] fingers that press so much on their way in push: less does not move a can
SEATED = 8.0  # [N] seat a cup's lip: the arm goes no further
SHALLOW = 0.005  # [m] before the end of the way in that a grasp still holds: a third of a pad
OFF_COURSE = 0.03  # [rad] an arm this far from its goal is held up by something
NOTHING = 0.001  # [m] pads closer than this have nothing between them
AT_HOME = 0.01  # [rad]
SPEED = 0.5  # share of the joints' velocity limits on the way home
SAMPLES = 40  # of the tool's path per segment, for pictures


@dataclass(frozen=True, eq=False)
class Outcome:
    """What became of a transfer.

    Attributes:
        success: The object was taken, carried and let go where it should be.
        text: What happened, in one sentence.
        tool_path: (k, 3) planned positions of the tool in the world [m], of the segments that were driven.
        slip: Distance [m] and angle [rad] by which the object moved in the hand while it was held, measured
            on true poses; None where it was never held.
        lost_at: (3,) where in the world [m] the object was when it was missed; None where it was not.
    """

    success: bool
    text: str
    tool_path: FloatArray
    slip: tuple[float, float] | None = None
    lost_at: FloatArray | None = None


def execute(transfer: Transfer, robot: SimulatedArm) -> Outcome:
    """Drives the segments one after the other.

    A grasp that closes on nothing, a cup that does not seal or an object lost on the way ends it: the hand
    opens and the arm goes straight up, so that the next look finds it out of the way.

    Args:
        transfer: What to do; it should start where the arm is.
        robot: The arm in its world.
    """
    done: list[Segment] = []
    name = transfer.object
    held: FloatArray | None = None  # pose_object_to_hand once it was taken
    slip: tuple[float, float] | None = None
    for segment in transfer.segments:
        if held is not None and segment.kind == "release":
            slip = _shift(held, robot.pose_in_hand(name, segment.tool))
        problem = _drive(segment, transfer, robot)
        if segment.trajectory is not None:
            done.append(segment)
        if problem is not None:
            in_hand = robot.pose_in_hand(name, segment.tool)
            lost = None if held is None else robot.world.pose(name)[:3, 3]
            retreat(transfer, done, robot)
            slip = None if held is None else _shift(held, in_hand)
            return Outcome(False, problem, _tool_path(done, robot), slip, lost)
        if segment.kind == "grasp":
            held = robot.pose_in_hand(name, segment.tool)
    return Outcome(True, f"{name} was put down, {transfer.placement.rest}.", _tool_path(done, robot), slip)


def _shift(before: FloatArray, after: FloatArray) -> tuple[float, float]:
    """Distance [m] and angle [rad] between two poses (4, 4)."""
    return float(np.linalg.norm(after[:3, 3] - before[:3, 3])), angle_between(before, after)


def withdraw(robot: SimulatedArm, solids: Solids, seed: int) -> None:
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


def retreat(transfer: Transfer, done: list[Segment], robot: SimulatedArm) -> None:
    """Lets go, no wider than the hand was open on its way in, and backs out along that way."""
    if not done:
        robot.release()
        return
    last = done[-1]
    robot.release(last.hand.opening if last.kind == "approach" else None)
    if last.kind == "approach" and last.trajectory is not None:
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


def _drive(segment: Segment, transfer: Transfer, robot: SimulatedArm) -> str | None:
    """Drives one segment; a sentence where it went wrong."""
    name = transfer.object
    if segment.kind == "grasp":
        return _take(segment, transfer, robot)
    if segment.kind == "release":
        # what is held may be wider than it looked
        robot.release(max(segment.hand.opening, robot.opening + RELEASE_GAP))
        robot.wait(0.25)  # what was let go comes to rest before the hand leaves
        return None
    if segment.trajectory is None:
        return None
    if segment.kind in ("move", "approach", "retreat"):
        if segment.tool == "suction" or segment.kind == "move":
            robot.extend(segment.hand.cup_extension)
        if segment.kind != "retreat":
            robot.open(segment.hand.opening)
    guard = _guard(segment, name, robot)
    # a hand that gave way as it closed lifts straight up from where it is
    error = robot.follow(segment.trajectory, guard, keep_offset=segment.kind == "lift")
    if segment.kind == "approach" and segment.tool == "fingers" and _way_left(segment, robot) > SHALLOW:
        touched = robot.strongest_touch()
        return f"the fingers met {touched[0] if touched else 'something'} on their way in."
    if segment.kind in WATCHED and not robot.holds(name):
        return f"{name} slipped out of the hand during the {segment.kind}."
    if error > OFF_COURSE:
        touched = robot.strongest_touch(ignoring=(name,))
        what = f" against {touched[0]}" if touched else ""
        return f"the arm was held up during the {segment.kind}{what}."
    return None


def _guard(segment: Segment, name: str, robot: SimulatedArm) -> Callable[[], bool] | None:
    """What stops a segment before its end: an object that stands, a hand that meets something."""
    if segment.kind == "place":
        return lambda: robot.load_on(name) > TOUCHDOWN
    if segment.kind == "approach":
        most = TOUCHED if segment.tool == "fingers" else SEATED
        return lambda: robot.press() > most
    return None


def _way_left(segment: Segment, robot: SimulatedArm) -> float:
    """How far the tool stopped before the end of a segment [m]."""
    assert segment.trajectory is not None
    states = np.stack([robot.q_target, segment.trajectory.positions[-1]])
    here, there = robot.arm.tool_pose(states, segment.tool)[:, :3, 3]
    return float(np.linalg.norm(there - here))


def _take(segment: Segment, transfer: Transfer, robot: SimulatedArm) -> str | None:
    name = transfer.object
    if segment.tool == "suction":
        robot.wait(0.2)
        return None if robot.suck(name) else f"the cup found no seal on {name}."
    jaw = robot.arm.tools[segment.tool].gripper
    opening = robot.close(PRESS * getattr(jaw, "force", 0.0))
    robot.wait(0.2)
    if opening < NOTHING or not robot.holds(name):
        return f"the fingers closed {'on nothing' if opening < NOTHING else f'without holding {name}'}."
    return None


def _tool_path(done: list[Segment], robot: SimulatedArm) -> FloatArray:
    """(k, 3) in the world [m]."""
    pieces = [np.zeros((0, 3))]
    for segment in done:
        if segment.trajectory is not None:
            q = segment.trajectory.positions
            chosen = q[np.unique(np.linspace(0, len(q) - 1, SAMPLES).astype(int))]
            base = robot.arm.tool_pose(chosen, segment.tool)[:, :3, 3]
            pieces.append(base @ robot.pose_base_to_world[:3, :3].T + robot.pose_base_to_world[:3, 3])
    return np.vstack(pieces)
