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

F1 is pooled over the piles, with a 95 % interval from drawing piles anew; shares have Wilson's. With
`--verify` the same is done for the checked graph, and compared with the default: that is slow.

`--piles DIR` scores recorded piles instead of our own, and `--data DIR` adds annotated camera frames: there
the direct constraints found and the false ones are counted against what somebody wrote down by eye. How much
of a body is there once its hidden sides are completed stands beside: `topple.benchmarks.completion`.
"""

import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from statistics import median
from typing import Any

import numpy as np

from topple.benchmarks.clock import cpu_seconds
from topple.benchmarks.completion import completion_rows
from topple.benchmarks.guesses import Guess, guesses
from topple.benchmarks.piles import make_pile, observe, truth
from topple.benchmarks.recorded import Case, Frame, recorded_frames, recorded_piles
from topple.benchmarks.row import Progress, Row
from topple.benchmarks.scores import Score, f1_interval, score, share
from topple.planner.planning.next_view import next_view
from topple.planner.planning.order import order
from topple.topology.scene.scene import Scene

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
        scenes: Of each generator, in which bodies are completed: 25 have 300 bodies; 0 for none.
    """

    piles: int
    views: tuple[int, ...] = (0, 3, 1)
    scenes: int = 25


FULL = Extent(26)
QUICK = Extent(2, scenes=0)


def rows(
    quick: bool,
    seed: int,
    progress: Progress,
    *,
    piles: Path | None = None,
    data: Path | None = None,
    verify: bool = False,
) -> list[dict[str, Any]]:
    """Measure.

    Args:
        quick: Two piles, and no completed bodies.
        seed: Transfers on to other piles.
        progress: Called before each part.
        piles: A folder of recorded piles, to be scored instead of our own.
        data: A folder with annotated camera frames, to be scored too.
        verify: Score `--verify` too.

    Returns:
        The bench's rows.
    """
    extent = QUICK if quick else FULL
    found: list[Row] = []
    if piles is not None:
        cases = list(recorded_piles(piles))[: extent.piles if quick else None]
    else:
        cases = [_case(seed, number, extent, progress) for number in range(extent.piles)]
        if 1 in extent.views:
            progress("a second view")
            found.append(_second_view(cases))
    for view in extent.views:
        progress(f"{VIEWS[view]}: default and baselines")
        found += _view(cases, view)
    if extent.scenes:
        found += completion_rows(seed, extent.scenes, progress)
    if data is not None:
        progress("annotated frames")
        found += _frames(recorded_frames(data))
    progress("times")
    found += _speed(cases)
    if verify:
        found += _verified(cases, extent.views, progress)
    return [row.to_json() for row in found]


def _case(seed: int, number: int, extent: Extent, progress: Progress) -> Case:
    """A pile of our own, with its truth."""
    progress(f"pile {number + 1} of {extent.piles}: lifting everything in turn")
    pile_seed = FIRST_PILE + 1000 * seed + number
    pile = make_pile(pile_seed)
    return Case(pile_seed, truth(pile), {view: observe(pile, view, pile_seed) for view in extent.views})


def _second_view(cases: Sequence[Case]) -> Row:
    """What one more picture adds to one camera: from where `next_view` says, and from the opposite side."""

    def seen(case: Case, next_one: bool) -> Scene:
        one = case.scenes[1]
        middle = np.mean([one.clouds[name].mean(axis=0) for name in one.movable], axis=0)
        opposite = one.viewpoints[0] * [-1.0, -1.0, 1.0] + 2.0 * middle * [1.0, 1.0, 0.0]
        view = next_view(one) if next_one else None
        if next_one and view is None:
            return one
        eye = opposite if view is None else view.eye
        return observe(make_pile(case.seed), 1, case.seed, eye[None])

    def total(next_one: bool) -> list[Score]:
        scenes = [seen(case, next_one) for case in cases]
        return [
            score(_answer(scene), case.labels, scene.movable)
            for case, scene in zip(cases, scenes, strict=True)
        ]

    ours, theirs = total(True), total(False)
    interval = f1_interval(ours)
    return Row(
        "F1, 1 camera and the next view", sum(ours, Score()).f1, "", "and the opposite view",
        sum(theirs, Score()).f1, None, None, interval,
    )  # fmt: skip


def _view(cases: Sequence[Case], view: int) -> list[Row]:
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
    for name, scores in theirs.items():
        beside = name, sum(scores, Score()).safe, total.piles
        found.append(share(f"safe orders, {where}", total.safe, total.piles, against=beside))
    extra = "plain 6IM + height", naive.lean, naive.targets
    what = f"targets without an extra removal, {where}"
    return [*found, share(what, total.lean, total.targets, ">= 95", against=extra)]


def _verified(cases: Sequence[Case], views: tuple[int, ...], progress: Progress) -> list[Row]:
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
            share(
                f"safe orders, {where}", total.safe, total.piles, f">= {SAFE_BARS[view]}",
                against=("without --verify", plain.safe, plain.piles),
            ),
        ]  # fmt: skip
    return [*found, Row("--verify on a pile, median, wall time", median(seconds), "s", bar="<= 20")]


def _frames(frames: Iterable[Frame]) -> list[Row]:
    """Direct constraints of annotated frames: the graph's edges against what was written down."""
    needed = found = false = said = 0
    for frame in frames:
        edges = {(e.first, e.then) for e in order(frame.scene).graph.dependencies} - frame.doubtful
        needed += len(frame.needed)
        found += len(frame.needed & edges)
        said += len(edges)
        false += len(edges - frame.needed)
    return [
        share("real frames, constraints found", found, needed, ">= 95"),
        share("real frames, edges that are false", false, said, "<= 5"),
    ]


def _speed(cases: Sequence[Case]) -> list[Row]:
    """CPU time of `order` on the largest pile, warm, and wall time of the whole command on it."""
    view = next(iter(cases[0].scenes))
    scene = max((case.scenes[view] for case in cases), key=lambda scene: len(scene.movable))
    order(scene)
    seconds = median(cpu_seconds(lambda: order(scene)) for _ in range(5))
    size = f"{len(scene.movable)} objects x {max(len(c) for c in scene.clouds.values()):,} points"
    return [
        Row(f"order of {size}, warm", seconds, "s", bar="<= 0.25"),
        Row(f"topple order of {size}, whole command", _command(scene), "s", bar="<= 2.5"),
    ]


def _command(scene: Scene) -> float:
    """Wall time [s] of `topple order` in a process of its own, the second of two runs."""
    with tempfile.TemporaryDirectory(prefix="topple-") as folder:
        path = Path(folder) / "scene.npz"
        fixed = np.array(sorted(scene.fixed))
        np.savez(path, up=np.asarray(scene.up), fixed=fixed, **dict[str, Any](scene.clouds))
        call = [sys.executable, "-m", "topple.planner.cli.main", "order", str(path), "--json"]
        subprocess.run(call, check=True, capture_output=True)  # reads what the next run finds in memory
        begun = time.perf_counter()
        subprocess.run(call, check=True, capture_output=True)
        return time.perf_counter() - begun


def _answer(scene: Scene, verify: bool = False) -> Guess:
    """What topple says, in the form that is scored."""
    found = order(scene, verify=verify)
    return Guess(
        pairs=frozenset((edge.first, edge.then) for edge in found.graph.dependencies),
        order=found.order,
        groups=found.groups,
    )


def _scored(cases: Sequence[Case], view: int, answer: Callable[[Scene, int], Guess]) -> list[Score]:
    """One score per pile."""
    return [
        score(answer(case.scenes[view], case.seed), case.labels, case.scenes[view].movable) for case in cases
    ]
