"""Relating clouds against plain numpy and against Qhull alone, and how the time grows with the scene.

- Ten objects (a table, a lemon in a bowl, four stacked, two that touch, one alone; whole surfaces, half a
  millimetre of noise) of 10k, 50k and 200k points each by the paper's rule, against the rule written down
  in plain numpy: Qhull once for every cloud, then for every pair, both ways, every point in the enlarged box
  against every facet Qhull names, and all six cells counted. That side has no broad phase, no early exit
  and no facet left out; it works through the points in blocks only so that its tables fit into memory.
  Ours decides the relations first; the counts and gaps that wait until asked for are timed in a row of
  their own. Every relation and every count of every matrix is compared.
- The same against Qhull alone on the same clouds: what a rule that looks at hulls cannot do without, unless
  it drops points first that cannot be corners. The default rule is held beside it without a bar.
- The most memory numpy holds at a time while relating them, against the bytes of the clouds.
- 1,000 objects against 100 at the same density, 2,000 points each, without `up`; and the same with `up` and
  nothing fixed, where gravity is asked about every object.
- One object of 50 moved: the update against relating all again.
- A 640x480 frame of 15 objects from depth and masks to relations by the default rule, against reading its
  points through Qhull once.

Medians of CPU times, the two sides taking turns in the same run. The ratio of a ">=" bar says how many times
faster, that of a "<=" bar how many times as long.
"""

import tracemalloc
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

from scipy.spatial import ConvexHull

from topple.benchmarks import labelled
from topple.benchmarks.clock import cpu_medians
from topple.benchmarks.clouds import crowd, frame, household
from topple.benchmarks.plain_numpy import plain_numpy
from topple.benchmarks.row import Progress, Row, faster, longer
from topple.topology.base.tolerances import TOLERANCES
from topple.topology.relations.relate import relate
from topple.topology.scene.scene import Scene
from topple.topology.sixim.table import classify
from topple.topology.views.image import DepthImage

NUMPY = "plain numpy"
QHULL = "Qhull alone"


@dataclass(frozen=True)
class Size:
    """One density of the ten objects.

    Attributes:
        points: Per object.
        repeats: Measurements, of which the median counts.
        speedup: Bar against plain numpy.
        floor: Bar against Qhull alone, None where there is none.
        memory: Bar against the bytes of the clouds, None where there is none.
    """

    points: int
    repeats: int
    speedup: float
    floor: float | None
    memory: float | None = None


@dataclass(frozen=True)
class Extent:
    """How much is measured.

    Attributes:
        sizes: Densities of the ten objects.
        crowds: A small and a large number of objects.
        tracked: Objects of the scene in which one moves.
        points: Per object of those two.
        crowds_by_default: Whether the crowds are related by the default rule, too: minutes.
        frame: Whether the rendered frame is measured.
        repeats: Measurements of all but the sizes.
    """

    sizes: tuple[Size, ...]
    crowds: tuple[int, int] = (100, 1000)
    tracked: int = 50
    points: int = 2000
    crowds_by_default: bool = True
    frame: bool = True
    repeats: int = 5


FULL = Extent((Size(10_000, 9, 6, None, 3), Size(50_000, 5, 12, 1.2, 3), Size(200_000, 3, 30, 1.2, 3)))
QUICK = Extent((Size(10_000, 5, 6, None, 3), Size(50_000, 3, 12, 1.2, 3)), crowds_by_default=False, repeats=3)


def rows(quick: bool, seed: int, progress: Progress, data: Path | None = None) -> list[dict[str, Any]]:
    """Measure.

    Args:
        quick: Without the densest clouds, and fewer repeats.
        seed: Seed of the clouds.
        progress: Called before each part.
        data: Folder of frames a person labelled, see `labelled`; None leaves them out.

    Returns:
        The bench's rows.
    """
    extent = QUICK if quick else FULL
    found: list[Row] = []
    for size in extent.sizes:
        progress(f"10 objects x {size.points:,} points")
        found += _ten_objects(size, seed)
    progress(f"{extent.crowds[1]:,} objects")
    found += _crowds(extent, seed)
    progress(f"one of {extent.tracked} moved")
    found.append(_update(extent, seed))
    if extent.frame:
        progress("a frame of 15 objects")
        found.append(_frame(extent.repeats, seed))
    found += labelled.rows(data, progress)
    return [row.to_json() for row in found]


def _ten_objects(size: Size, seed: int) -> list[Row]:
    scene = household(size.points, seed)
    deviation = TOLERANCES.plain_deviation
    relations = relate(scene, plain=True)
    expected = plain_numpy(scene.clouds, deviation)
    other_relation = sum(relations.between(*pair).relation != classify(expected[pair]) for pair in expected)
    other_matrix = sum(bool((relations.between(*pair).matrix != expected[pair]).any()) for pair in expected)
    ours, counted, theirs, floor, default = cpu_medians(
        [
            partial(relate, scene, plain=True),
            lambda: relate(scene, plain=True).to_json(),
            partial(plain_numpy, scene.clouds, deviation),
            lambda: [ConvexHull(cloud) for cloud in scene.clouds.values()],
            partial(relate, scene),
        ],
        size.repeats,
    )
    what = f"10 objects x {size.points:,} points"
    least = None if size.floor is None else f"<= {size.floor:g}x"
    return [
        faster(f"{what}, plain rule", ours, NUMPY, theirs, f">= {size.speedup:g}x"),
        Row(f"{what}: pairs with another relation", other_relation, "pairs", NUMPY, 0.0, None, "0"),
        Row(f"{what}: pairs with another matrix", other_matrix, "pairs", NUMPY, 0.0, None, "0"),
        faster(f"{what}, plain rule, with counts and gaps", counted, NUMPY, theirs),
        longer(f"{what}, plain rule, whole time", ours, QHULL, floor, least),
        longer(f"{what}, default rule, whole time", default, QHULL, floor),
        _memory(f"{what}, plain rule: memory", scene, True, size.memory),
        _memory(f"{what}, default rule: memory", scene, False, size.memory),
    ]


def _memory(what: str, scene: Scene, plain: bool, bar: float | None) -> Row:
    """The most that is allocated at a time beside the scene, as Python and numpy know it, not Qhull."""
    given = sum(cloud.nbytes for cloud in scene.clouds.values()) / 1e6
    tracemalloc.start()
    try:
        relate(scene, plain=plain)
        most = tracemalloc.get_traced_memory()[1] / 1e6
    finally:
        tracemalloc.stop()
    return Row(what, most, "MB", "the clouds", given, most / given, None if bar is None else f"<= {bar:g}x")


def _crowds(extent: Extent, seed: int) -> list[Row]:
    still = [crowd(count, extent.points, seed) for count in extent.crowds]
    floating = [Scene(scene.clouds, up=(0, 0, 1)) for scene in still]
    found: list[Row] = []
    cases = [(still, True, "plain rule"), (still, False, "default rule")]
    cases.append((floating, False, "default rule, up known, nothing fixed"))
    for (few, many), plain, rule in cases:
        if not (plain or extent.crowds_by_default):
            continue
        related = partial(relate, plain=plain, max_objects=len(many.names))
        related(few)
        repeats = extent.repeats if plain else 1
        short, long = cpu_medians([partial(related, few), partial(related, many)], repeats)
        what = f"{len(many.names):,} objects x {extent.points:,} points, {rule}"
        found.append(longer(what, long, f"{len(few.names)} objects", short, "<= 12x"))
    return found


def _update(extent: Extent, seed: int) -> Row:
    """The median over several objects: some have more neighbours than others."""
    scene = crowd(extent.tracked, extent.points, seed)
    relations = relate(scene)
    moved = scene.names[:: max(1, len(scene.names) // 7)]
    calls = [partial(relations.updated, name, scene.clouds[name] + 0.005) for name in moved]
    times = sorted(cpu_medians(calls, extent.repeats))
    full = cpu_medians([partial(relate, scene)], extent.repeats)[0]
    what = f"one object of {extent.tracked} moved, default rule: update"
    return longer(what, times[len(times) // 2], "all again", full, "<= 1/15")


def _frame(repeats: int, seed: int) -> Row:
    image = frame(seed)

    def read(image: DepthImage = image) -> None:
        relate(Scene.from_images([image], fixed=["table"], up=(0, 0, 1)))

    read()
    floor = cpu_medians([lambda: [ConvexHull(cloud) for cloud in image.clouds().values()]], repeats)[0]
    ours = cpu_medians([read], repeats)[0]
    what = (
        f"{image.depth.shape[1]}x{image.depth.shape[0]} frame, {len(image.names) - 1} objects, default rule"
    )
    return longer(what, ours, QHULL, floor, "<= 10x")
