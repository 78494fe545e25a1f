"""The paper's fourteen scenes, rebuilt, and five methods on them (its section 4, Tables 3 and 4).

- Scenes 1 to 7, boxes, books, a jar and bars that lie, stand and lean, are seen by two depth cameras with
  a Kinect's faults. Scenes 8 to 14, things of the YCB object set, are whole surfaces, and are seen by one
  and by three cameras besides. All are settled in PyBullet, in ten jittered variants each; poses,
  viewpoints and what is true were fixed before any rule was run on them.
- Columns: topple's default rule; plain 6IM, the paper's rule to the letter, at a deviation of 2 mm and
  at the one that is estimated from the clouds (the paper gives no number: "usually equal to the deviation of
  point clouds"); the same with boxes for hulls at 2 mm; feature extraction; and learning.
  Feature extraction and learning are implementations of ours in the spirit of the methods the paper compares
  itself to: their figures say little about the originals.
- The paper's own figures stand beside, on its own scenes: ours are rebuilt from its words.

A pair counts as right where the relation is the listed one, as in the paper; for feature extraction contain
and partial contain are the same. A pair of an object that was not seen counts as wrong. Figures are means
over the variants, with 95 % intervals of the mean.
"""

from collections.abc import Iterator, Sequence
from concurrent.futures import Executor
from pathlib import Path
from typing import Any

import topple.benchmarks.paper.learning as learning
from topple.benchmarks.paper.case import Outcome, Task, solve
from topple.benchmarks.paper.summary import report
from topple.benchmarks.paper.things import Things
from topple.benchmarks.paper.truth import SCENES
from topple.benchmarks.row import Progress
from topple.topology.base.errors import InvalidInput
from topple.topology.base.workers import all_of, open_executor

VARIANTS = 10
"""Jittered variants of every scene."""
PILES = 30
"""Piles the learning column is trained on."""
QUICK_PILES = 6
"""The same for a quick run."""


def rows(
    quick: bool,
    seed: int,
    progress: Progress,
    meshes: Path | None = None,
    scenes: Path | None = None,
    executor: Executor | None = None,
) -> list[dict[str, Any]]:
    """Measure.

    Args:
        quick: One variant of each scene.
        seed: Moves on to other variants; those of seed 0 are never used to choose anything.
        progress: Called before each part.
        meshes: Folder of YCB models, one folder each; None: procedural things.
        scenes: Where the scenes are written to, as `.npz` the other commands read.
        executor: Whose workers take the variants, and see the same folders; None for a process a core.

    Returns:
        The bench's rows.

    Raises:
        InvalidInput: A folder is not there.
    """
    for place, what in ((meshes, "meshes"), (scenes, "scenes")):
        if place is not None and not place.is_dir():
            raise InvalidInput(f"there is no folder {place} for {what}: give one that exists")
    things = Things(meshes)
    if things.absent:
        progress(f"no model of {', '.join(things.absent)}: procedural")
    with open_executor(executor) as pool:
        learned = None
        if learning.available():
            progress("learning from piles")
            first = learning.FIRST_PILE + 1000 * seed
            last = first + (QUICK_PILES if quick else PILES)
            piles = all_of(learning.examples_of, range(first, last), pool)
            learned = learning.train([example for examples in piles for example in examples])
        tasks = [
            Task(number, variant, seed, things, learned, scenes)
            for variant in range(1 if quick else VARIANTS)
            for number in SCENES
        ]
        outcomes = list(_solved(pool, tasks, progress))
    found = report(outcomes, None if learned is not None else learning.INSTALL)
    return [row.to_json() for row in found]


def _solved(pool: Executor, tasks: Sequence[Task], progress: Progress) -> Iterator[Outcome]:
    for done, outcomes in enumerate(all_of(solve, tasks, pool)):
        progress(f"scene {tasks[done].number}, variant {tasks[done].variant + 1}: {done + 1} of {len(tasks)}")
        yield from outcomes
