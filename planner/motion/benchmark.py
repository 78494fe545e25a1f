"""Figures of the motion layer on this machine, each with its baseline: rows for `topple bench motion`."""

import time
from collections.abc import Callable
from itertools import pairwise
from typing import Any

import numpy as np

from topple.planner.motion.collision import Checker
from topple.planner.motion.one_by_one import OneByOne, ompl_one_by_one
from topple.planner.motion.planner import Motion, plan_motion
from topple.planner.motion.problems import Problem, clutter, pick, top_down, transfer
from topple.robots.arm import Arm
from topple.robots.catalog import robot
from topple.topology.arrays import FloatArray

Row = dict[str, Any]
Progress = Callable[[str], None]

FCL = "python-fcl, one state at a time"
OMPL = "OMPL RRTConnect + python-fcl, one state at a time"
BUDGET = 20.0  # [s] for one problem; both sides are given it
BARS = {"pick": 50.0, "transfer": 10.0}  # times faster than OMPL with python-fcl
CERTIFIED_BARS = {"pick": None, "transfer": 4.0}


def rows(quick: bool = False, seed: int = 0, progress: Progress | None = None) -> list[Row]:
    """Measure.

    Args:
        quick: Fewer states and problems, for a first impression.
        seed: First seed of the problems.
        progress: Called with a line of text before each part.

    Returns:
        Rows of a bench: what, value, unit, baseline, baseline_value, ratio, bar, ok. Times are CPU times,
        since ratios of those hold on a busy machine too.
    """
    say = progress or (lambda text: None)
    arm = robot("panda")
    say("collision checks")
    found = _checking(arm, 2_000 if quick else 20_000, seed)
    count = 5 if quick else 30
    for kind, make in (("pick", pick), ("transfer", transfer)):
        problems: list[Problem] = []
        for k in range(count):
            say(f"{kind} problem {k + 1} of {count}")
            problems.append(make(arm, seed + k))
        found += _planning(kind, problems, seed, say)
    say("inverse kinematics")
    return [*found, _reaching(arm, 50 if quick else 300, seed)]


def _row(
    what: str,
    value: float,
    unit: str,
    bar: str | None,
    ok: bool | None,
    baseline: tuple[str, float] | None = None,
    ratio: float | None = None,
) -> Row:
    name, figure = baseline or (None, None)
    return {
        "what": what,
        "value": value,
        "unit": unit,
        "baseline": name,
        "baseline_value": figure,
        "ratio": ratio,
        "bar": bar,
        "ok": ok,
    }


def _timed(call: Callable[[], Any]) -> tuple[Any, float]:
    begun = time.process_time()
    return call(), time.process_time() - begun


def _checking(arm: Arm, count: int, seed: int) -> list[Row]:
    rng = np.random.default_rng(seed)
    checker = Checker(arm, np.eye(4), clutter(rng, 10))
    single = OneByOne(arm, checker.model)
    q = rng.uniform(arm.lower, arm.upper, (count, len(arm.joints)))
    checker.free(q[:100])
    ours, seconds = _timed(lambda: checker.free(q))
    theirs, their_seconds = _timed(lambda: single.all(q))
    ratio = their_seconds / seconds
    wrong = int((ours != theirs).sum())
    return [
        _row(
            "states checked",
            count / seconds,
            "1/s",
            ">= 20x",
            ratio >= 20,
            (FCL, count / their_seconds),
            ratio,
        ),
        _row(f"disagreements on {count} states", wrong, "states", "0", wrong == 0, (FCL, 0.0)),
    ]


def _planning(kind: str, problems: list[Problem], seed: int, say: Progress) -> list[Row]:
    plain, certified, theirs = list[float](), list[float](), list[float]()
    solved = touching = their_touching = their_solved = 0
    for k, problem in enumerate(problems):
        say(f"{kind} problem {k + 1} of {len(problems)}: planning")
        checker, start, goals = problem.checker, problem.start, problem.goals

        def plan(proof: bool, problem: Problem = problem) -> Any:
            return plan_motion(
                problem.checker, problem.start, problem.goals, seed=seed, budget=BUDGET, certified=proof
            )

        plain.append(_timed(lambda plan=plan: plan(False))[1])
        motion, seconds = _timed(lambda plan=plan: plan(True))
        certified.append(seconds)
        if isinstance(motion, Motion):
            solved += motion.certificate is not None and motion.certificate.proven
            touching += not checker.free(densely(motion.path)).all()
        single = OneByOne(checker.arm, checker.model)
        path, seconds = _timed(lambda s=single, a=start, g=goals: ompl_one_by_one(s, a, g, BUDGET))
        theirs.append(seconds)
        if path is not None:
            their_solved += 1
            their_touching += not checker.free(densely(path)).all()
    return _planning_rows(kind, plain, certified, theirs, (solved, touching, their_solved, their_touching))


def _planning_rows(
    kind: str,
    plain: list[float],
    certified: list[float],
    theirs: list[float],
    counts: tuple[int, int, int, int],
) -> list[Row]:
    solved, touching, their_solved, their_touching = counts
    total = len(plain)
    ours, proven, baseline = (1000 * float(np.median(times)) for times in (plain, certified, theirs))
    bar, certified_bar = BARS[kind], CERTIFIED_BARS[kind]
    fast = baseline / proven
    return [
        _row(
            f"{kind}: plan and shortcut, median", ours, "ms", f">= {bar:.0f}x", baseline / ours >= bar,
            (OMPL, baseline), baseline / ours,
        ),
        _row(
            f"{kind}: certified plan, median", proven, "ms",
            None if certified_bar is None else f">= {certified_bar:.0f}x",
            None if certified_bar is None else fast >= certified_bar, (OMPL, baseline), fast,
        ),
        _row(
            f"{kind}: solved and certified", 100 * solved / total, "%", "100", solved == total,
            (OMPL, 100 * their_solved / total),
        ),
        _row(
            f"{kind}: paths that touch something, looked at every 0.002 rad",
            100 * touching / total, "%", "0", touching == 0, (OMPL, 100 * their_touching / total),
        ),
    ]  # fmt: skip


def _reaching(arm: Arm, count: int, seed: int) -> Row:
    """Share of reachable top-down targets solved with the usual number of seeds, from a random start."""
    rng = np.random.default_rng(seed)
    radius, turn = rng.uniform(0.3, 0.65, count), rng.uniform(-1.5, 1.5, count)
    height, yaw = rng.uniform(0.02, 0.35, count), rng.uniform(-3, 3, count)
    places = zip(radius * np.cos(turn), radius * np.sin(turn), height, yaw, strict=True)
    targets = np.array([top_down(float(x), float(y), float(z), float(w)) for x, y, z, w in places])
    many = arm.inverse(targets, seeds=256, rng=np.random.default_rng(seed + 1))
    usual = arm.inverse(targets, near=rng.uniform(arm.lower, arm.upper), rng=rng)
    reachable = [len(a) > 0 or len(b) > 0 for a, b in zip(many, usual, strict=True)]
    share = 100 * sum(len(found) > 0 for found in usual) / max(sum(reachable), 1)
    return _row("reachable top-down targets solved", share, "%", ">= 99.5", share >= 99.5)


def densely(path: FloatArray, step: float = 0.002) -> FloatArray:
    """States on a path (k, n), at most `step` apart in any joint."""
    pieces = [path[:1]]
    for a, b in pairwise(path):
        count = max(int(np.ceil(np.abs(b - a).max() / step)), 1)
        pieces.append(a + np.arange(1, count + 1)[:, None] / count * (b - a))
    return np.concatenate(pieces)
