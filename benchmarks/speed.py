"""How fast whole answers are: frame to order, plans, the thinking of a closed loop, and how times grow.

With `--against COMMIT` every task is done by that commit as well, in the same run and turn about, each time
in a process of its own with the libraries of this one; a bar in x compares the two. Without it what has a
fixed peer is held against that: Qhull on the same clouds, a process that imports numpy and SciPy. No bar is a
time.

- Default relations of ten objects against Qhull alone on the same clouds.
- A file with a 640x480 frame to its order, imports left out: recorded frames of `--data DIR`, else a rendered
  one; the same as `topple order`, a process; the same with its first object moved and everything else known.
- A plan that clears ten things with a Panda, seen by three cameras.
- Thinking in the closed loop of the pile: all that is neither an arm's motion nor a camera's picture, for
  each action.
- How long the arm waits for a decision once it has done something, from the pictures to its next motion,
  where the next step is chosen while it acts and where it is not; for the first it waits in any case.
- A brick wall of whole noisy surfaces, every brick across two others: one island of contacts. Stacks of four,
  far from each other: how the time grows with their number (2 is quadratic), and how large their relations
  are as JSON without pairs that are far.
- Relations of many recorded scenes by two workers, processes and those of a dask cluster where there is dask,
  against one after the other; the workers have done a scene each before.

CPU times, but for the waiting, the run of the demo and the two workers.
"""

import json
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Generator, Sequence
from concurrent.futures import Executor
from contextlib import AbstractContextManager, ExitStack, contextmanager, suppress
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from statistics import median
from typing import Any

import numpy as np
from scipy.spatial import ConvexHull

from topple.benchmarks import plans, speed_tasks
from topple.benchmarks.clock import cpu_medians, cpu_seconds
from topple.benchmarks.clouds import brick_wall, frame, household, stacks_of_four
from topple.benchmarks.row import Progress, Row, faster, longer
from topple.benchmarks.versions import of_commit
from topple.planner.planning.order import order
from topple.topology.base.errors import InvalidInput, NotInstalled
from topple.topology.base.workers import WorkerPool
from topple.topology.relations.relate import relate, relate_all
from topple.topology.scene.scene import Scene

NOT_SLOWER = ">= 0.9x"
"""Of what a commit before takes: figures of one run differ by a few percent."""

FRAME, PROCESS, WALL, RELATIONS = 55.0, 8.0, 550.0, 13.0
"""Most times as long as the fixed peer: a frame to order, the same as a process, a wall of 30 bricks,
relations of ten objects in the quick run. About twice where they stood when they were set: ratios of one run
on a busy machine differ by a third. What is finer is seen against a commit, in pairs."""

PEERS = {"hulls": "Qhull alone", "imports": "a process that imports numpy and SciPy"}
WORKERS = 2
WAITING = ("dishes", "tower", "pile")
"""Scenes in which the arm's waiting is measured."""
MANY = 60
"""Recorded scenes that two workers relate."""
FRAMES = 6
"""Of the recorded frames, so many are measured, evenly spread over the sorted names."""


@dataclass(frozen=True)
class Extent:
    """How much is measured.

    Attributes:
        relations: Points of each of ten objects, and the bar against Qhull alone.
        walls: Bricks, and the bar against Qhull alone; None where there is none.
        stacks: Objects of the scenes, rising: the last are held against the first.
        repeats: How often tasks in processes of their own are done.
        exponent: With which power of their number the time of stacks may grow.
        whole: Whether plan, closed loop and demo are measured: minutes.
    """

    relations: tuple[tuple[int, float], ...] = ((10_000, 3.5), (50_000, 1.7), (200_000, 1.1))
    walls: tuple[tuple[int, float | None], ...] = ((30, WALL), (60, None), (120, None))
    stacks: tuple[int, ...] = (100, 200, 400, 1000)
    repeats: int = 3
    exponent: float = 1.2
    whole: bool = True


FULL = Extent()
QUICK = Extent(((10_000, RELATIONS),), ((30, WALL),), (40, 100), 1, 1.5, whole=False)


def rows(
    quick: bool, seed: int, progress: Progress, data: Path | None = None, against: str | None = None
) -> list[dict[str, Any]]:
    """Measure.

    Args:
        quick: Small scenes alone, once each: two minutes.
        seed: Of clouds and scenes.
        progress: Called before each part.
        data: A folder of recorded frames (`*.npz`); None: a rendered one.
        against: A commit that does the same; None: bars against one are not judged.

    Returns:
        The bench's rows.

    Raises:
        InvalidInput: There is no such commit.
    """
    extent = QUICK if quick else FULL
    found: list[Row] = []
    for points, bar in extent.relations:
        progress(f"relations of 10 objects x {points:,} points")
        found.append(relations_row(points, bar, seed, 3 if quick else 5))
    with tempfile.TemporaryDirectory(prefix="topple-speed-") as scratch:
        trees = Trees(Path(scratch), against)
        found += _frames(trees, data, extent.repeats, seed, progress)
        if extent.whole and data is not None:
            found += many_rows(sorted(data.rglob("*.npz"))[:MANY], progress)
        if extent.whole:
            found += _whole(trees, extent.repeats, seed, progress)
        for bricks, most in extent.walls:
            progress(f"a wall of {bricks} bricks")
            found += wall_rows(trees, bricks, most, seed)
    progress(f"stacks of four: {', '.join(map(str, extent.stacks))} objects")
    found.append(stacks_row(extent.stacks, extent.exponent, seed))
    progress(f"relations JSON of {extent.stacks[-1]} objects")
    found.append(json_row(extent.stacks[-1], seed))
    return [row.to_json() for row in found]


class Trees:
    """This tree, and that of a commit where one is named.

    Args:
        scratch: A folder to write into.
        against: The commit.

    Raises:
        InvalidInput: There is no such commit.
    """

    def __init__(self, scratch: Path, against: str | None) -> None:
        self.scratch = scratch
        self._old = None if against is None else of_commit(against, scratch / "versions")
        self.name = None if self._old is None else self._old.name
        self._script = scratch / "tasks" / "speed_tasks.py"  # beside it are no modules that hide others
        self._script.parent.mkdir()
        self._script.write_text(Path(speed_tasks.__file__).read_text(encoding="utf-8"), encoding="utf-8")

    def measure(
        self, task: str, settings: dict[str, Any], repeats: int
    ) -> tuple[list[float], list[float] | None]:
        """Do a task by this tree and by the older one, turn about, each time in a new process.

        Args:
            task: One of `speed_tasks.TASKS`.
            settings: What it takes.
            repeats: How often.

        Returns:
            Medians of its figures by this tree, and by the older one; None where there is none.
        """
        ours: list[list[float]] = []
        theirs: list[list[float]] = []
        for _ in range(repeats):
            ours.append(self._figures(task, settings, None))
            if self._old is not None:
                theirs.append(self._figures(task, settings, self._old.folder))
        medians = [median(values) for values in zip(*ours, strict=True)]
        return medians, [median(values) for values in zip(*theirs, strict=True)] if theirs else None

    def ours(self, task: str, settings: dict[str, Any]) -> list[float]:
        """What a task takes by this tree alone, once, in a new process; see `measure`."""
        return self._figures(task, settings, None)

    def _figures(self, task: str, settings: dict[str, Any], tree: Path | None) -> list[float]:
        """What a task takes by a tree, this one where None, in a process of its own."""
        before = os.environ.get("PYTHONPATH")
        paths = [*([str(tree)] if tree else []), *([before] if before else [])]
        command = [sys.executable, str(self._script), task, json.dumps(settings)]
        environment = {**os.environ, "PYTHONPATH": os.pathsep.join(paths)}
        done = subprocess.run(command, env=environment, capture_output=True, text=True, check=False)
        if done.returncode:
            last = (done.stderr.strip().splitlines() or ["it said nothing"])[-1]
            raise RuntimeError(f"{task} by {self.name if tree else 'this tree'} failed: {last}")
        return json.loads(done.stdout.splitlines()[-1])

    def row(self, what: str, ours: float, theirs: float | None) -> Row:
        """A figure, against that of the commit where it was measured."""
        if theirs is None or self.name is None:
            return Row(what, ours, "s")
        return faster(what, ours, self.name, theirs, NOT_SLOWER)


def exponent(counts: Sequence[float], seconds: Sequence[float]) -> float:
    """With which power of a count a time grows, between the first and the last of some.

    Args:
        counts: Of objects, rising.
        seconds: What each takes [s].
    """
    return float(np.log(seconds[-1] / seconds[0]) / np.log(counts[-1] / counts[0]))


def relations_row(points: int, bar: float, seed: int, repeats: int) -> Row:
    """Default relations of ten objects of so many points against Qhull alone."""
    scene = household(points, seed)
    floor, default = cpu_medians(
        [lambda: [ConvexHull(cloud) for cloud in scene.clouds.values()], partial(relate, scene)], repeats
    )
    what = f"default relations, 10 objects x {points:,} points"
    return longer(what, default, "Qhull alone", floor, f"<= {bar:g}x")


def _frames(trees: Trees, data: Path | None, repeats: int, seed: int, progress: Progress) -> list[Row]:
    if data is None:
        paths, what = [_rendered(trees.scratch, seed + k) for k in (1, 0)], "a rendered frame of 15 things"
    else:
        every = sorted(data.rglob("*.npz"))
        if len(every) < 2:
            raise InvalidInput(f"{data}: fewer than two frames (*.npz) in this folder and below")
        paths = [every[1], *every[:: -(-len(every) // FRAMES)]]  # the first is not counted
        what = f"{len(paths) - 1} recorded frames, mean"
    settings = {"paths": [str(path) for path in paths]}
    found: list[Row] = []
    for task, words, peer, bar in (
        ("order", "to order", "hulls", FRAME),
        ("process", "to order, as a process", "imports", PROCESS),
        ("again", "to order again, one object moved", "hulls", None),
    ):
        progress(f"{what}, {words}")
        ours, theirs = trees.measure(task, settings, repeats)
        means = float(np.mean(ours[1:])), None if theirs is None else float(np.mean(theirs[1:]))
        found.append(trees.row(f"{what}, {words}", *means))
        fixed = float(np.mean(trees.ours(peer, settings)[-len(paths) + 1 :]))
        most = None if bar is None else f"<= {bar:g}x"
        found.append(longer(f"{what}, {words}", means[0], PEERS[peer], fixed, most))
    return found


def many_rows(paths: Sequence[Path], progress: Progress) -> list[Row]:
    """How much sooner two workers relate scenes than one process does.

    Args:
        paths: The scenes.
        progress: Called before each part.
    """
    progress(f"{len(paths)} scenes, one after the other")
    alone = _wall(partial(relate_all, paths))
    found: list[Row] = []
    for name, pool in {"processes": _processes, "dask": _dask}.items():
        with ExitStack() as stack, suppress(NotInstalled):
            workers = stack.enter_context(pool())
            relate_all(paths[:WORKERS], executor=workers)
            progress(f"{len(paths)} scenes, two workers, {name}")
            taken = _wall(partial(relate_all, paths, executor=workers))
            what = f"relations of {len(paths)} scenes, two workers, {name}, wall"
            found.append(faster(what, taken, "one after the other", alone, ">= 1.7x"))
    return found


def _processes() -> AbstractContextManager[Executor]:
    return WorkerPool(WORKERS)


@contextmanager
def _dask() -> Generator[Executor, None, None]:
    try:
        from distributed import Client, LocalCluster
    except ImportError as error:
        raise NotInstalled("a cluster needs dask", "dask") from error
    size: dict[str, Any] = {"n_workers": WORKERS, "threads_per_worker": 1, "dashboard_address": None}
    with LocalCluster(**size) as cluster, Client(cluster) as client:
        yield client.get_executor()


def _wall(call: Callable[[], object]) -> float:
    begun = time.perf_counter()
    call()
    return time.perf_counter() - begun


def _whole(trees: Trees, repeats: int, seed: int, progress: Progress) -> list[Row]:
    """A plan, a closed loop and the demo."""
    progress("a plan of ten objects")
    with plans.ten(seed) as stage:
        scene, base = plans.seen(stage), stage.pose_base_to_world.tolist()
    path = written(scene, trees.scratch / "ten_scene.npz")
    ours, theirs = trees.measure("plan", {"paths": [str(path)], "base": base}, 1)
    what = "plan that clears ten objects with a Panda"
    found = [trees.row(what, ours[0], None if theirs is None else theirs[0])]
    progress("thinking in closed loops")
    runs = [trees.measure("think", {"scene": "pile", "seed": seed + k}, 1) for k in range(repeats)]
    old = [theirs[0] for _, theirs in runs if theirs is not None]
    what = f"thinking for an action in a closed loop, pile, median of {len(runs)} runs, CPU"
    ours = median(figures[0] for figures, _ in runs)
    found.append(trees.row(what, ours, median(old) if old else None))
    found += waiting_rows(trees, range(seed, seed + repeats), progress)
    progress("topple demo")
    ours, theirs = trees.measure("demo", {"folder": str(trees.scratch)}, 1)
    return [*found, trees.row("topple demo, wall", ours[0], None if theirs is None else theirs[0])]


def waiting_rows(trees: Trees, seeds: Sequence[int], progress: Progress) -> list[Row]:
    """How long the arm waits for a decision, with the next step chosen while it acts and without.

    Args:
        trees: This one.
        seeds: Of the runs of each scene.
        progress: Called before each run.
    """
    waited: dict[bool, list[float]] = {False: [], True: []}
    taken = {False: 0.0, True: 0.0}
    for scene in WAITING:
        for seed in seeds:
            for ahead, found in waited.items():
                progress(f"waiting in closed loops, {scene} {seed}{', chosen ahead' * ahead}")
                seconds, *each = trees.ours("wait", {"scene": scene, "seed": seed, "ahead": ahead})
                taken[ahead] += seconds
                found += each
    plain, ahead = waited[False], waited[True]
    what = f"waiting of the arm for a decision, next step chosen ahead, wall, of {len(ahead)}"
    after = "chosen after the look"

    def most(seconds: Sequence[float]) -> float:
        return float(np.quantile(seconds, 0.9))

    return [
        longer(f"{what}, median", median(ahead), after, median(plain), "<= 0.4"),
        longer(f"{what}, 90 %", most(ahead), after, most(plain), "<= 1"),
        longer("all of these runs, wall", taken[True], after, taken[False]),
    ]


def wall_rows(trees: Trees, bricks: int, most: float | None, seed: int) -> list[Row]:
    """The order of a wall of so many bricks, against Qhull alone and by the commit where one is named."""
    small, wall = (
        str(written(brick_wall(count, seed), trees.scratch / f"wall_{count}_scene.npz"))
        for count in (8, bricks)
    )
    what, settings = f"order of a wall of {bricks} bricks", {"paths": [small, wall]}
    ours, theirs = trees.measure("order", settings, 1)
    fixed = trees.ours("hulls", settings)[-1]
    bar = None if most is None else f"<= {most:g}x"
    found = [longer(what, ours[-1], PEERS["hulls"], fixed, bar)]
    return found if theirs is None else [*found, trees.row(what, ours[-1], theirs[-1])]


def stacks_row(counts: Sequence[int], most: float, seed: int) -> Row:
    """How the order of stacks of four grows between the first and the last of some numbers of bricks."""
    times = [_ordered(stacks_of_four(count, seed)) for count in counts]
    taken = ", ".join(f"{seconds:.3g}" for seconds in times[1:])
    others = ", ".join(map(str, counts[1:]))
    what = f"order of stacks of four, {others} objects against {counts[0]}: exponent ({taken} s)"
    return Row(what, exponent(counts, times), "", bar=f"<= {most:g}")


def json_row(count: int, seed: int) -> Row:
    """How large the relations of so many objects are as JSON, against every pair of them."""
    found = relate(stacks_of_four(count, seed), max_objects=count + 1)
    some, every = (len(json.dumps(found.to_json(far=far))) / 1e3 / count for far in (False, True))
    what = f"relations JSON of {count} objects in stacks of four without far pairs, for each object"
    return Row(what, some, "kB", "every pair", every, some / every, "<= 5")


def _ordered(scene: Scene) -> float:
    """CPU time [s] of relations and order of a scene of any size."""
    most = len(scene.clouds)
    return cpu_seconds(lambda: order(scene, relations=relate(scene, max_objects=most)))


def _rendered(folder: Path, seed: int) -> Path:
    """A rendered frame as a file: depth, matrix, labels, the table's plane."""
    image = frame(seed)
    path = folder / f"frame_{seed}.npz"
    table = np.concatenate([image.pose_camera_to_world[2, :3], [image.pose_camera_to_world[2, 3]]])
    np.savez_compressed(path, depth=image.depth, K=image.K, label=image.label, table_plane=table)
    return path


def written(scene: Scene, path: Path) -> Path:
    """A scene as a file of clouds."""
    arrays: dict[str, Any] = {name: np.asarray(cloud) for name, cloud in scene.clouds.items()}
    arrays |= {"fixed": np.array(sorted(scene.fixed)), "viewpoints": np.asarray(scene.viewpoints)}
    np.savez_compressed(path, up=np.asarray(scene.up), **arrays)
    return path
