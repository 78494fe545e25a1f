"""Motion planning against the usual ways, on the same seeded problems in the same run.

A Panda picks low between eight boxes and carries over a wall between four. Beside ours: python-fcl one state
at a time, OMPL's RRTConnect and simplification on top of that, and, where installed (see
`topple.benchmarks.peers`), pybullet-planning, mplib and VAMP with their own collision checks. All but VAMP
look at an edge every 0.05 rad or, mplib, wider. Times are CPU times of planning and shortening, loading
of arm and scene left out on every side; each of our plans has a checker of its own. Also paths that touch
something when looked at every 0.002 rad, and how many reachable top-down poses the inverse kinematics solves.
Grasps ranked and whole plans are parts of their own: see `topple.benchmarks.grasps` and `plans`.
"""

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from topple.benchmarks import grasps, plans
from topple.benchmarks.motion_problems import Problem, checker_of, clutter, pick, top_down, transfer
from topple.benchmarks.one_by_one import OneByOne, ompl_one_by_one
from topple.benchmarks.peers import PEERS, Answer, answers, python_of
from topple.benchmarks.row import Progress, Row
from topple.planner.motion.planner import Motion, plan_motion
from topple.planner.motion.shortcut import densely, length
from topple.robots.arm.arm import Arm
from topple.robots.catalog import robot
from topple.topology.base.errors import InvalidInput

FCL = "python-fcl, one state at a time"
OMPL = "OMPL + python-fcl"
BUDGET = 20.0  # [s] for one problem, on every side
LOOKED_AT = 0.002  # [rad] between the states of a path that are looked at again
PLAIN_BARS = {
    "pick": {OMPL: ">= 50x", "pybullet-planning": ">= 15x", "mplib": ">= 15x"},
    "transfer": {OMPL: ">= 10x", "pybullet-planning": ">= 10x", "mplib": ">= 4x"},
}
CERTIFIED_BARS = {
    "pick": {"pybullet-planning": ">= 8x", "vamp": ">= 0.125x"},
    "transfer": {OMPL: ">= 4x", "pybullet-planning": ">= 4x", "vamp": ">= 0.0333x"},
}


def rows(quick: bool, seed: int, progress: Progress, part: str | None = None) -> list[dict[str, Any]]:
    """Measure.

    Args:
        quick: Fewer states and problems.
        seed: First seed of the problems.
        progress: Called before each part.
        part: One of `PARTS` alone.

    Returns:
        The bench's rows.

    Raises:
        InvalidInput: There is no such part.
    """
    if part is not None and part not in PARTS:
        raise InvalidInput(f"motion has no part {part!r}: expected one of {', '.join(PARTS)}")
    parts = PARTS if part is None else (part,)
    return [row for each in parts for row in PARTS[each](quick, seed, progress)]


def _motions(quick: bool, seed: int, progress: Progress) -> list[dict[str, Any]]:
    arm = robot("panda")
    progress("collision checks")
    found = checking(arm, 2_000 if quick else 20_000, seed)
    for kind, make in (("pick", pick), ("transfer", transfer)):
        progress(f"{kind} problems")
        problems = [make(arm, seed + k) for k in range(5 if quick else 30)]
        found += planning(kind, problems, seed, progress)
    progress("inverse kinematics")
    found.append(_reaching(arm, 50 if quick else 300, seed))
    return [row.to_json() for row in found]


PARTS: dict[str, Callable[[bool, int, Progress], list[dict[str, Any]]]] = {
    "motions": _motions,
    "grasps": grasps.rows,
    "plans": plans.rows,
    "rearranged": plans.rearranged,
}
"""What is measured, each with a table of its own."""


def _timed(call: Callable[[], Any]) -> tuple[Any, float]:
    begun = time.process_time()
    return call(), time.process_time() - begun


def checking(arm: Arm, count: int, seed: int) -> list[Row]:
    """Check random states among ten boxes, in batches and one by one."""
    rng = np.random.default_rng(seed)
    checker = checker_of(arm, clutter(rng, 10))
    single = OneByOne(arm, checker.model)
    q = rng.uniform(arm.lower, arm.upper, (count, len(arm.joints)))
    checker.free(q[:100])
    ours, seconds = _timed(lambda: checker.free(q))
    theirs, their_seconds = _timed(lambda: single.all(q))
    rates, wrong = (count / seconds, count / their_seconds), int((ours != theirs).sum())
    return [
        Row("states checked", rates[0], "1/s", FCL, rates[1], rates[0] / rates[1], ">= 20x"),
        Row(f"disagreements on {count} states", wrong, "states", FCL, 0.0, bar="0"),
    ]


@dataclass(frozen=True)
class _Score:
    """What came of a set of problems: medians over all of them, the rest over those solved."""

    milliseconds: float
    solved: float
    touching: float
    length: float

    @staticmethod
    def of(problems: Sequence[Problem], answers: Sequence[Answer]) -> "_Score":
        paths = [(p.checker, a.path) for p, a in zip(problems, answers, strict=True) if a.path is not None]
        touching = [not checker.free(densely(path, LOOKED_AT)).all() for checker, path in paths]
        return _Score(
            1000 * float(np.median([answer.seconds for answer in answers])),
            100 * len(paths) / len(answers),
            100 * sum(touching) / max(len(paths), 1),
            float(np.mean([length(path) for _, path in paths])) if paths else float("nan"),
        )


def planning(kind: str, problems: list[Problem], seed: int, progress: Progress) -> list[Row]:
    """Plan seeded problems with and without certificate, and by everyone installed; one row per figure.

    Args:
        kind: pick or transfer.
        problems: All with the same arm.
        seed: Of the searches.
        progress: Called before each part.
    """
    progress(f"{kind}: ours")
    plain = _Score.of(problems, [_ours(problem, seed, certified=False) for problem in problems])
    proven = _Score.of(problems, [_ours(problem, seed, certified=True) for problem in problems])
    progress(f"{kind}: OMPL")
    theirs = {OMPL: _Score.of(problems, [_ompl(problem) for problem in problems])}
    for peer in PEERS:
        python = python_of(peer)
        if python is not None:
            progress(f"{kind}: {peer}")
            theirs[peer] = _Score.of(problems, answers(peer, python, problems, seed, BUDGET))
    found: list[Row] = []
    for name, other in theirs.items():
        for what, ours, bars in (
            ("plan and shortcut", plain, PLAIN_BARS[kind]),
            ("certified plan", proven, CERTIFIED_BARS[kind]),
        ):
            ratio = other.milliseconds / ours.milliseconds
            found.append(
                Row(f"{kind}: {what}, median", ours.milliseconds, "ms", name, other.milliseconds, ratio,
                    bars.get(name))
            )  # fmt: skip
    for name, other in theirs.items():
        touching = f"{kind}: paths that touch, every {LOOKED_AT} rad"
        found += [
            Row(f"{kind}: solved and certified", proven.solved, "%", name, other.solved, bar="100"),
            Row(touching, proven.touching, "%", name, other.touching, bar="0"),
            Row(f"{kind}: length of the path, mean", plain.length, "rad", name, other.length),
        ]
    return found


def _ours(problem: Problem, seed: int, certified: bool) -> Answer:
    """A path of ours by a checker that has not seen the scene; with `certified`, only a proven one counts."""
    checker = checker_of(problem.checker.arm, problem.boxes)

    def plan() -> Any:
        return plan_motion(
            checker, problem.start, problem.goals, seed=seed, budget=BUDGET, certified=certified
        )

    motion, seconds = _timed(plan)
    if not isinstance(motion, Motion):
        return Answer(seconds, None)
    proven = motion.certificate is not None and motion.certificate.proven
    return Answer(seconds, motion.path if proven or not certified else None)


def _ompl(problem: Problem) -> Answer:
    single = OneByOne(problem.checker.arm, problem.checker.model)
    path, seconds = _timed(lambda: ompl_one_by_one(single, problem.start, problem.goals, BUDGET))
    return Answer(seconds, path)


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
    return Row("reachable top-down targets solved", share, "%", bar=">= 99.5")
