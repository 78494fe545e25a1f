"""What `order` gets right on piles, judged by simulation, against what one would write in an afternoon.

Seeded piles of household things are settled in PyBullet, and every object in turn is lifted straight up and
taken away at three frictions: whoever moves had to go first. The piles are seen whole, by three depth
cameras and by one; per view this scores

- F1, precision and recall of the transitive closure of the dependencies, pairs too close to call left out,
- the share of piles for which the order that clears everything is safe: nothing is taken while something it
  would move is still there (objects of a group may, if simulation has them in one cycle),
- the share of targets for which nothing is removed beyond what simulation demands.

The baselines are given the same clouds:

- top height: the highest top first, everything before what is lower;
- AABB above: of two boxes that come within a centimetre and overlap seen from above, the one with the higher
  centre first;
- plain 6IM + height: of two objects that are not disjoint by the paper's rule at 3 mm, the one with the
  higher mean first;
- random: any order.

F1 is pooled over the piles, with a 95 % interval from drawing piles anew; shares have Wilson's. The full
bench does the same for `--verify`, and compares it with the default.
"""

import time
from collections.abc import Callable
from dataclasses import dataclass
from statistics import median
from typing import Any

import numpy as np

from topple.planner.bench.clock import cpu_seconds
from topple.planner.bench.guesses import Guess, guesses
from topple.planner.bench.row import Progress, Row
from topple.planner.bench.scores import Labels, Score, f1_interval, score, share_interval
from topple.planner.order import order
from topple.planner.piles import SAMPLES, make_pile, observe, truth
from topple.topology.scene import Scene

FIRST_PILE = 7_200_000
"""Seed of the first pile; those of other collections of piles are far below."""

VIEWS = {0: "whole surfaces", 3: "3 cameras", 1: "1 camera"}
F1_BARS = {0: 0.93, 3: 0.86, 1: 0.75}
VERIFIED_F1_BARS = {0: 0.96, 3: 0.90, 1: 0.80}
SAFE_BARS = {0: 95, 3: 90, 1: 85}  # [%] of piles, with --verify


@dataclass(frozen=True)
class Extent:
    """How much is measured.

    Attributes:
        piles: Number of piles.
        views: Numbers of cameras; 0 for whole surfaces.
        verified: Whether `--verify` is scored, too.
    """

    piles: int
    views: tuple[int, ...] = (0, 3, 1)
    verified: bool = True


FULL = Extent(26)
QUICK = Extent(5, verified=False)


@dataclass(frozen=True, eq=False)
class Case:
    """One pile, seen.

    Attributes:
        seed: Of the pile.
        labels: then -> first -> 1, 0 or None.
        scenes: Cameras -> what they see.
    """

    seed: int
    labels: Labels
    scenes: dict[int, Scene]


def rows(quick: bool, seed: int, progress: Progress) -> list[dict[str, Any]]:
    """Measure.

    Args:
        quick: A handful of piles, and without `--verify`.
        seed: Moves on to other piles.
        progress: Called before each part.

    Returns:
        The bench's rows.
    """
    extent = QUICK if quick else FULL
    cases: list[Case] = []
    for number in range(extent.piles):
        progress(f"pile {number + 1} of {extent.piles}: lifting everything in turn")
        cases.append(_case(FIRST_PILE + 1000 * seed + number, extent.views))
    found: list[Row] = []
    for view in extent.views:
        progress(f"{VIEWS[view]}: default and baselines")
        found += _view(cases, view)
    found.append(_speed(cases))
    if extent.verified:
        found += _verified(cases, extent.views, progress)
    return [row.to_json() for row in found]


def _case(seed: int, views: tuple[int, ...]) -> Case:
    pile = make_pile(seed)
    return Case(seed, truth(pile), {view: observe(pile, view, seed) for view in views})


def _view(cases: list[Case], view: int) -> list[Row]:
    ours = _scored(cases, view, lambda scene, seed: _answer(scene))
    theirs = {name: _scored(cases, view, guess) for name, guess in guesses().items()}
    where, interval = VIEWS[view], f1_interval(ours)
    total, naive = sum(ours, Score()), sum(theirs["plain 6IM + height"], Score())
    found: list[Row] = []
    for name, scores in theirs.items():
        bar = f">= {F1_BARS[view]:.2f}" if not found else None  # the bar is held up once
        value = sum(scores, Score()).f1
        found.append(Row(f"F1, {where}", total.f1, "", name, value, None, bar, interval))
    found += [
        Row(f"precision, {where}", total.precision, "", "plain 6IM + height", naive.precision),
        Row(f"recall, {where}", total.recall, "", "plain 6IM + height", naive.recall),
    ]
    safe, piles = total.safe, total.piles
    for name, scores in theirs.items():
        value = _percent(sum(scores, Score()).safe, piles)
        found.append(
            Row(
                f"safe orders, {where}", _percent(safe, piles), "%", name, value,
                interval=share_interval(safe, piles),
            )
        )  # fmt: skip
    return [*found, _extra(total, naive, where)]


def _extra(total: Score, naive: Score, where: str) -> Row:
    return Row(
        f"targets without an extra removal, {where}",
        _percent(total.lean, total.targets),
        "%",
        "plain 6IM + height",
        _percent(naive.lean, naive.targets),
        bar=">= 95",
        interval=share_interval(total.lean, total.targets),
    )


def _verified(cases: list[Case], views: tuple[int, ...], progress: Progress) -> list[Row]:
    """The same rows for `--verify`, against the default; wall time, since it runs on all cores."""
    found: list[Row] = []
    seconds: list[float] = []
    for view in views:
        scores: list[Score] = []
        for number, case in enumerate(cases):
            progress(f"{VIEWS[view]}: --verify on pile {number + 1} of {len(cases)}")
            begun = time.perf_counter()
            guess = _answer(case.scenes[view], verify=True)
            seconds.append(time.perf_counter() - begun)
            scores.append(score(guess, case.labels, case.scenes[view].movable))
        total = sum(scores, Score())
        plain = sum(_scored(cases, view, lambda scene, seed: _answer(scene)), Score())
        where = f"{VIEWS[view]}, --verify"
        found += [
            Row(
                f"F1, {where}", total.f1, "", "without --verify", plain.f1,
                bar=f">= {VERIFIED_F1_BARS[view]:.2f}", interval=f1_interval(scores),
            ),
            Row(f"precision, {where}", total.precision, "", "without --verify", plain.precision),
            Row(f"recall, {where}", total.recall, "", "without --verify", plain.recall),
            Row(
                f"safe orders, {where}", _percent(total.safe, total.piles), "%", "without --verify",
                _percent(plain.safe, plain.piles), bar=f">= {SAFE_BARS[view]}",
                interval=share_interval(total.safe, total.piles),
            ),
        ]  # fmt: skip
    return [*found, Row("--verify on a pile, median, wall time", median(seconds), "s", bar="<= 20")]


def _speed(cases: list[Case]) -> Row:
    """CPU time of `order` on the largest pile."""
    view = next(iter(cases[0].scenes))
    scene = max((case.scenes[view] for case in cases), key=lambda scene: len(scene.movable))
    order(scene)
    seconds = median(cpu_seconds(lambda: order(scene)) for _ in range(5))
    what = f"order of {len(scene.movable)} objects x {SAMPLES:,} points, warm"
    return Row(what, seconds, "s", bar="<= 0.25")


def _answer(scene: Scene, verify: bool = False) -> Guess:
    """What topple says, in the form that is scored."""
    found = order(scene, verify=verify)
    return Guess(
        pairs=frozenset((edge.first, edge.then) for edge in found.graph.dependencies),
        order=found.order,
        groups=found.groups,
    )


def _scored(cases: list[Case], view: int, answer: Callable[[Scene, int], Guess]) -> list[Score]:
    """One score per pile."""
    return [
        score(answer(case.scenes[view], case.seed), case.labels, case.scenes[view].movable) for case in cases
    ]


def _percent(part: int, whole: int) -> float:
    return float(np.nan_to_num(100 * np.divide(part, whole))) if whole else 100.0
