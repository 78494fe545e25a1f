"""Relating clouds against plain numpy and against Qhull alone, and how the time grows with the scene.

- Ten objects (a table, a lemon in a bowl, four stacked, two that touch, one alone; whole surfaces, half a
  millimetre of noise) of 10k, 50k and 200k points each by the paper's rule, against the rule written down
  in plain numpy: Qhull for every cloud, then every point in the enlarged box against every facet. Every
  count of every matrix is compared.
- The same against Qhull alone on the same clouds: what a rule that looks at hulls cannot do without, unless
  it drops points first that cannot be corners. The default rule is held beside it without a bar.
- 1,000 objects against 100 at the same density, 2,000 points each, without `up`.
- One object of 50 moved: the update against relating all again.
- A 640x480 frame of 15 objects from depth and masks to relations by the default rule, against reading its
  points through Qhull once.

Medians of CPU times, the two sides taking turns in the same run. The ratio of a ">=" bar says how many times
faster, that of a "<=" bar how many times as long.
"""

from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

from scipy.spatial import ConvexHull

from topple.planner.bench import truth
from topple.planner.bench.clock import cpu_medians
from topple.planner.bench.clouds import crowd, frame, household
from topple.planner.bench.plain_numpy import plain_numpy
from topple.planner.bench.row import Progress, Row, faster, longer
from topple.topology.image import DepthImage
from topple.topology.relate import relate
from topple.topology.scene import Scene
from topple.topology.tolerances import TOLERANCES

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
    """

    points: int
    repeats: int
    speedup: float
    floor: float | None


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


FULL = Extent((Size(10_000, 9, 6, None), Size(50_000, 5, 12, 1.2), Size(200_000, 3, 30, 1.2)))
QUICK = Extent((Size(10_000, 5, 6, None), Size(50_000, 3, 12, 1.2)), crowds_by_default=False, repeats=3)


def rows(quick: bool, seed: int, progress: Progress, data: Path | None = None) -> list[dict[str, Any]]:
    """Measure.

    Args:
        quick: Without the densest clouds, and fewer repeats.
        seed: Seed of the clouds.
        progress: Called before each part.
        data: Folder of frames a person labelled, see `truth`; None leaves them out.

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
    found += truth.rows(data, progress)
    return [row.to_json() for row in found]


def _ten_objects(size: Size, seed: int) -> list[Row]:
    scene = household(size.points, seed)
    deviation = TOLERANCES.plain_deviation
    relations = relate(scene, plain=True)
    expected = plain_numpy(scene.clouds, deviation)
    wrong = sum(bool((relations.between(*pair).matrix != matrix).any()) for pair, matrix in expected.items())
    ours, theirs, floor, default = cpu_medians(
        [
            partial(relate, scene, plain=True),
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
        Row(f"{what}: pairs with another matrix", wrong, "pairs", NUMPY, 0.0, None, "0"),
        longer(f"{what}, plain rule, whole time", ours, QHULL, floor, least),
        longer(f"{what}, default rule, whole time", default, QHULL, floor),
    ]


def _crowds(extent: Extent, seed: int) -> list[Row]:
    few, many = (crowd(count, extent.points, seed) for count in extent.crowds)
    found: list[Row] = []
    for plain, rule in ((True, "plain"), (False, "default")):
        if not (plain or extent.crowds_by_default):
            continue
        relate(few, plain=plain)
        repeats = extent.repeats if plain else 1
        short, long = cpu_medians(
            [partial(relate, few, plain=plain), partial(relate, many, plain=plain)], repeats
        )
        what = f"{len(many.names):,} objects x {extent.points:,} points, {rule} rule"
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
