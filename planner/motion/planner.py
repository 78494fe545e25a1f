"""Planning a motion: the direct edge, then batched RRT-Connect, then OMPL; the path shortened at the end."""

import time
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field, replace

import numpy as np

from topple.planner.budget import OutOfBudget, check_budget, within
from topple.planner.motion.certificate import Certificate, Certifier
from topple.planner.motion.collision import Checker, Contact
from topple.planner.motion.rrt import rrt_connect
from topple.planner.motion.shortcut import densely, length, shortcut
from topple.planner.motion.tolerances import (
    ATTEMPTS,
    CLEARANCE,
    DIRECT,
    EDGE_STEP,
    PATIENCE,
    RELAXED,
    ROUNDED_LIMIT,
    ROUNDS,
)
from topple.topology.base.arrays import BoolArray, FloatArray, freeze
from topple.topology.base.errors import InvalidInput
from topple.topology.base.values import decimal


@dataclass(frozen=True, eq=False)
class Motion:
    """A motion that was found.

    Attributes:
        path: (k, n) waypoints of straight joint-space edges in [rad], read-only.
        goal: Index of the goal it reaches.
        stage: What found it: direct, rrt or ompl.
        certificate: The proof that it is free all along, or what spoils it; None if none was asked for.
        seconds: How long that took.
    """

    path: FloatArray
    goal: int
    stage: str
    certificate: Certificate | None = None
    seconds: float = 0.0

    def __post_init__(self) -> None:
        object.__setattr__(self, "path", freeze(self.path))

    @property
    def length(self) -> float:
        """Length of the path in joint space in [rad]."""
        return length(self.path)


@dataclass(frozen=True, eq=False)
class MotionFailure:
    """Why there is no motion.

    Attributes:
        stage: What failed: start, goals (all in collision), search (none found), or budget (it ran out).
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
    checker: Checker,
    start: FloatArray,
    goals: FloatArray,
    *,
    seed: int = 0,
    rounds: int = ROUNDS,
    budget: float | None = None,
    certified: bool = True,
    clearance: float = CLEARANCE,
) -> Motion | MotionFailure:
    """Find a short path free of collisions to any of several goals.

    A clearance is kept to every obstacle, or as much of it as the start has, or as the best goal has where
    none has it. Where there is no way with it, a fifth of it and then the checker's own margin have to do;
    the certificate says what was kept.

    The direct edges are tried first, the nearest goal first; then the search. States on an edge are checked
    every 0.05 rad, and the edges of the result are certified, that is, proven free in between as well. Where
    some path was found but none that could be certified, it is returned with the certificate that says what
    touches.

    Args:
        checker: The arm, what it holds and what it must not hit.
        start: (n,) joint values.
        goals: (g, n) or (n,) joint values.
        seed: Seed of the search: the same seed gives the same answer, however busy the machine is.
        rounds: Batches of branches before the search gives up.
        budget: Wall-clock seconds for the whole call; where they run out that is the failure.
        certified: Whether to certify; without, a path may touch something between the checked states.
        clearance: Distance wanted from obstacles in [m], where the checker's margin is smaller.

    Returns:
        The motion, or why there is none.

    Raises:
        InvalidInput: If shapes are wrong or values are not finite.
    """
    start, goals = _validate(checker, start, goals)
    trials = checkers(checker, start, goals, clearance)
    return in_turn(
        budget,
        (_plan(trial, start, goals, seed, round(share * rounds), certified) for trial, share in trials),
    )


def in_turn(budget: float | None, searches: Iterable[Motion | MotionFailure]) -> Motion | MotionFailure:
    """The first motion of some searches that is proven, or else what the last one says.

    Args:
        budget: Wall-clock seconds for them all; where they run out that is the failure.
        searches: What they find, each searched for as it is asked for; at least one.
    """
    begun = time.monotonic()
    found: Motion | MotionFailure = MotionFailure("search", "nothing was tried")
    try:
        with within(budget):
            for found in searches:
                if isinstance(found, Motion) and (found.certificate is None or found.certificate.proven):
                    break
    except OutOfBudget as error:
        check_budget()  # that of a caller is not for us to tell
        found = MotionFailure("budget", str(error))
    return replace(found, seconds=time.monotonic() - begun)


def checkers(
    checker: Checker, start: FloatArray, goals: FloatArray, clearance: float
) -> Iterator[tuple[Checker, float]]:
    """Checkers that keep less and less of a clearance, the given one last.

    Args:
        checker: The arm, what it holds and what it must not hit.
        start: (n,) joint values; what it comes nearer to is asked to keep that.
        goals: (g, n) joint values; the same for the best of them, where none has the clearance.
        clearance: Distance wanted from obstacles [m].

    Yields:
        Each with the share of the rounds of a search to be spent on it.
    """
    wanted: FloatArray | None = None
    if clearance > checker.margin:
        trial = checker.at_distance(clearance)
        wanted = trial.model.margin
        yield trial, PATIENCE[0]  # mostly start and goal have it, and nothing need be looked at first
    for part, share in zip(RELAXED, PATIENCE, strict=True):
        if part * clearance <= checker.margin:
            break
        trial = checker.at_distance(part * clearance, start[None])
        if len(goals) and not trial.free(goals).any():
            clear = goals[checker.free(goals)]
            if not len(clear):
                break
            trial = _nearest_kept(checker, start, clear, part * clearance)
        if wanted is None or not np.array_equal(trial.model.margin, wanted):
            yield trial, share
    yield checker, PATIENCE[-1]


def _nearest_kept(checker: Checker, start: FloatArray, goals: FloatArray, clearance: float) -> Checker:
    """A checker that the start and the goal with the most room both satisfy."""
    trials = [checker.at_distance(clearance, np.stack([start, goal])) for goal in goals[:DIRECT]]
    return max(trials, key=lambda trial: float(trial.model.margin.sum()))


def _plan(
    checker: Checker,
    start: FloatArray,
    goals: FloatArray,
    seed: int,
    rounds: int,
    certified: bool,
) -> Motion | MotionFailure:
    """A motion that keeps the checker's margins, or why there is none."""
    nearest = np.argsort(np.linalg.norm(goals - start, axis=1), kind="stable")
    order = nearest[_within(checker, goals[nearest])]
    goals = np.clip(goals, checker.arm.lower, checker.arm.upper)
    clear = _free_states(checker, start, goals[order])
    if not clear[0] or not clear[1:-1].any():
        return _refuse_ends(checker, start, goals[order])
    open_first = bool(clear[-1])
    order = order[clear[1:-1]]
    query = _Query(
        checker,
        start,
        goals[order],
        open_first,
        seed,
        rounds,
        Certifier(checker) if certified else None,
    )
    found = query.direct() or query.search()
    if found is None:
        return _direct_way_barred(checker, start, goals[order[0]])
    path, stage, certificate = found
    goal = int(order[np.argmin(np.abs(goals[order] - path[-1]).max(axis=1))])
    return Motion(path, goal, stage, certificate)


_Found = tuple[FloatArray, str, Certificate | None]


@dataclass(frozen=True, eq=False)
class _Query:
    """One planning query; goals are free and come nearest first; `open_first`: the first's edge is free."""

    checker: Checker
    start: FloatArray
    goals: FloatArray
    open_first: bool
    seed: int
    rounds: int
    certifier: Certifier | None

    def direct(self) -> _Found | None:
        """The first goal that a straight edge reaches."""
        return self._along(self.goals[:1] if self.open_first else self.goals[:0]) or self._along(
            self._others()
        )

    def _others(self) -> FloatArray:
        goals = self.goals[1 if self.open_first else 0 : DIRECT]
        return goals[self.checker.edges_free(np.broadcast_to(self.start, goals.shape), goals)]

    def _along(self, goals: FloatArray) -> _Found | None:
        """The first of the goals whose free edge can be certified."""
        for goal in goals:
            path = np.array([self.start, goal])
            certificate = self._certificate(path)
            if certificate is None or certificate.proven:
                return path, "direct", certificate
        return None

    def search(self) -> _Found | None:
        """The first path the search finds that can be certified, or else the first one."""
        fallback: _Found | None = None
        for attempt in range(ATTEMPTS):
            path, stage = self._search(self.seed + 7919 * attempt)
            if path is None:
                break
            short = shortcut(path, self.checker.edges_free)
            assert short is not None, "a trusted path stays a path"
            certificate = self._certificate(short)
            if certificate is None or certificate.proven:
                return short, stage, certificate
            fallback = fallback or (short, stage, certificate)
            careful = shortcut(path, self._certifiable, trusted=False)
            if careful is not None:
                return careful, stage, self._certificate(careful)
        return fallback

    def _search(self, seed: int) -> tuple[FloatArray | None, str]:
        path = rrt_connect(self.checker, self.start, self.goals, seed=seed, rounds=self.rounds)
        from topple.planner.motion.ompl_search import OMPL_INSTALLED, ompl_path

        if path is not None or not OMPL_INSTALLED:
            return path, "rrt"

        return ompl_path(self.checker, self.start, self.goals, seed=seed, iterations=self.rounds), "ompl"

    def _certificate(self, path: FloatArray) -> Certificate | None:
        return None if self.certifier is None else self.certifier.path(path)

    def _certifiable(self, starts: FloatArray, ends: FloatArray) -> BoolArray:
        """Which edges are free and can be certified."""
        free = self.checker.edges_free(starts, ends)
        some = np.flatnonzero(free)
        if self.certifier is not None and len(some):
            free[some] = [edge.proven for edge in self.certifier.certify(starts[some], ends[some])]
        return free


def _validate(checker: Checker, start: FloatArray, goals: FloatArray) -> tuple[FloatArray, FloatArray]:
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
    arm = checker.arm
    inside: BoolArray = (states >= arm.lower - ROUNDED_LIMIT) & (states <= arm.upper + ROUNDED_LIMIT)
    return np.logical_and.reduce(inside, axis=1)


def _free_states(checker: Checker, start: FloatArray, goals: FloatArray) -> BoolArray:
    """Which of start, goals (g, n) and the straight edge to the first goal are free: (g + 2,), one check."""
    states, group = np.concatenate([start[None], goals]), np.arange(len(goals) + 1)
    if len(goals):
        edge = densely(np.array([start, goals[0]]), EDGE_STEP)[1:-1]
        states = np.concatenate([states, edge])
        group = np.concatenate([group, np.full(len(edge), len(goals) + 1)])
    clear = checker.groups_free(states, group, len(goals) + 2)
    clear[-1] &= clear[1:2].all()
    return clear


def _refuse_ends(checker: Checker, start: FloatArray, goals: FloatArray) -> MotionFailure:
    """Why there is nothing to plan: start or goals touch something, or no goal is within the limits."""
    found = checker.contacts(start)
    if found:
        return MotionFailure("start", f"at the start {_says(found)}", found, found[0].distance)
    if not len(goals):
        return MotionFailure("goals", "there is no goal within the joint limits")
    touching = [checker.contacts(goal) for goal in goals]
    least = max(touching, key=lambda contacts: contacts[0].distance)
    reason = f"in all {len(goals)} goals something touches; at best {_says(least)}"
    return MotionFailure("goals", reason, least, least[0].distance)


def _direct_way_barred(checker: Checker, start: FloatArray, goal: FloatArray) -> MotionFailure:
    """Blame the obstacle in the direct way, as the best guess at what bars every way."""
    states = start + np.linspace(0.0, 1.0, 101)[:, None] * (goal - start)
    hit = np.flatnonzero(~checker.free(states))
    found = checker.contacts(states[hit[len(hit) // 2]]) if len(hit) else ()
    bars = f"; on the direct way {_says(found)}" if found else ""
    reason = f"no motion found{bars}"
    return MotionFailure("search", reason, found, found[0].distance if found else 0.0)


def _says(contacts: tuple[Contact, ...]) -> str:
    worst = contacts[0]
    return f"{worst.a} touches {worst.b} ({decimal(1e3 * max(-worst.distance, 0.0))} mm deep)"
