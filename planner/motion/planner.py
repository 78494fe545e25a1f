"""Planning a motion: the direct edge, then batched RRT-Connect, then OMPL; the path shortened at the end."""

import time
from dataclasses import dataclass, field

import numpy as np

from topple.planner.motion.collision import Checker, Contact
from topple.planner.motion.rrt import rrt_connect
from topple.planner.motion.shortcut import length, shortcut
from topple.topology.arrays import BoolArray, FloatArray, frozen
from topple.topology.errors import InvalidInput


@dataclass(frozen=True, eq=False)
class Motion:
    """A motion that was found.

    Attributes:
        path: (k, n) waypoints of straight joint-space edges in [rad], read-only.
        goal: Index of the goal it reaches.
        stage: What found it: direct, rrt or ompl.
        seconds: How long that took.
    """

    path: FloatArray
    goal: int
    stage: str
    seconds: float = 0.0

    def __post_init__(self) -> None:
        object.__setattr__(self, "path", frozen(self.path))

    @property
    def length(self) -> float:
        """Length of the path in joint space in [rad]."""
        return length(self.path)


@dataclass(frozen=True, eq=False)
class MotionFailure:
    """Why there is no motion.

    Attributes:
        stage: What failed: start, goals (all in collision), or search (none found in time).
        reason: One line fit to print.
        contacts: What touches in the start, or in the goal with the least overlap; for a search, what bars
            the direct way to the nearest goal.
        distance: Overlap of those in [m], negative.
        seconds: How long was tried.
    """

    stage: str
    reason: str
    contacts: tuple[Contact, ...] = field(default=())
    distance: float = 0.0
    seconds: float = 0.0

    @property
    def witness(self) -> tuple[str, str] | None:
        """The names of the deepest pair."""
        return (self.contacts[0].a, self.contacts[0].b) if self.contacts else None


def plan_motion(
    checker: Checker, start: FloatArray, goals: FloatArray, *, seed: int = 0, budget: float = 5.0
) -> Motion | MotionFailure:
    """Find a short path free of collisions to any of several goals.

    Free means: at states at most 0.05 rad apart on every edge. The direct edges are tried first, the shortest
    first.

    Args:
        checker: The arm, what it holds and what it must not hit.
        start: (n,) joint values.
        goals: (g, n) or (n,) joint values.
        seed: Seed of the search. As long as the budget is not used up, the same seed gives the same path.
        budget: Seconds to search.

    Returns:
        The motion, or why there is none.

    Raises:
        InvalidInput: If shapes are wrong or values are not finite.
    """
    begun = time.monotonic()
    start, goals = _validated(checker, start, goals)
    failure = _refused(checker, start, goals)
    if failure is not None:
        return failure
    free = np.flatnonzero(checker.free(goals) & _within(checker, goals))
    order = free[np.argsort(np.linalg.norm(goals[free] - start, axis=1), kind="stable")]
    direct = _direct(checker, start, goals[order])
    if direct is not None:
        path = np.array([start, goals[order[direct]]])
        return Motion(path, int(order[direct]), "direct", time.monotonic() - begun)
    path, stage = _searched(checker, start, goals[order], seed, begun + budget)
    if path is None:
        return _barred(checker, start, goals[order[0]], time.monotonic() - begun)
    path = shortcut(path, checker.edges_free)
    goal = int(np.argmin(np.abs(goals - path[-1]).max(axis=1)))
    return Motion(path, goal, stage, time.monotonic() - begun)


def _direct(checker: Checker, start: FloatArray, goals: FloatArray) -> int | None:
    """Index of the first goal that a straight edge reaches; goals come nearest first."""
    for first in range(0, min(len(goals), 16), 4):
        some = goals[first : first + 4]
        free = checker.edges_free(np.broadcast_to(start, some.shape), some)
        if free.any():
            return first + int(np.argmax(free))
    return None


def _searched(
    checker: Checker, start: FloatArray, goals: FloatArray, seed: int, deadline: float
) -> tuple[FloatArray | None, str]:
    share = time.monotonic() + 0.7 * max(deadline - time.monotonic(), 0.0)
    path = rrt_connect(checker, start, goals, seed=seed, deadline=share)
    if path is not None:
        return path, "rrt"
    from topple.planner.motion.ompl_search import ompl_path

    return ompl_path(checker, start, goals, seed=seed, seconds=deadline - time.monotonic()), "ompl"


def _validated(checker: Checker, start: FloatArray, goals: FloatArray) -> tuple[FloatArray, FloatArray]:
    n = len(checker.arm.joints)
    start, goals = np.asarray(start, dtype=float), np.atleast_2d(np.asarray(goals, dtype=float))
    if start.shape != (n,) or goals.shape[1:] != (n,):
        raise InvalidInput(
            f"{checker.arm.name} has {n} joints: expected a start ({n},) and goals (g, {n}), "
            f"found {start.shape} and {goals.shape}"
        )
    if not np.isfinite(start).all() or not np.isfinite(goals).all():
        raise InvalidInput("start and goals must be finite joint values in [rad]")
    return start, goals


def _within(checker: Checker, states: FloatArray) -> BoolArray:
    slack = 1e-6  # inverse kinematics may end on a limit, and rounding beyond it
    arm = checker.arm
    inside: BoolArray = (states >= arm.lower - slack) & (states <= arm.upper + slack)
    return np.logical_and.reduce(inside, axis=1)


def _refused(checker: Checker, start: FloatArray, goals: FloatArray) -> MotionFailure | None:
    found = checker.contacts(start)
    if found:
        return MotionFailure("start", f"at the start {_says(found)}", found, found[0].distance)
    if not len(goals):
        return MotionFailure("goals", "there are no goals")
    inside = _within(checker, goals)
    if not inside.any():
        return MotionFailure("goals", "all goals lie outside the joint limits")
    if checker.free(goals[inside]).any():
        return None
    touching = [checker.contacts(goal) for goal in goals[inside]]
    least = max(touching, key=lambda contacts: contacts[0].distance)
    reason = f"in all {len(goals)} goals something touches; at best {_says(least)}"
    return MotionFailure("goals", reason, least, least[0].distance)


def _barred(checker: Checker, start: FloatArray, goal: FloatArray, seconds: float) -> MotionFailure:
    """What stands in the direct way, as the best guess at what bars every way."""
    states = start + np.linspace(0.0, 1.0, 101)[:, None] * (goal - start)
    hit = np.flatnonzero(~checker.free(states))
    found = checker.contacts(states[hit[len(hit) // 2]]) if len(hit) else ()
    bars = f"; on the direct way {_says(found)}" if found else ""
    reason = f"no motion found in {seconds:.1f} s{bars}"
    return MotionFailure("search", reason, found, found[0].distance if found else 0.0, seconds)


def _says(contacts: tuple[Contact, ...]) -> str:
    worst = contacts[0]
    return f"{worst.a} touches {worst.b} ({1000 * -min(worst.distance, 0.0):.0f} mm deep)"
