"""How much of a body there is once its hidden sides are completed, against its true body.

Of scenes of two generators, seen by simulated depth cameras, on seeds that chose nothing: what the convex
hulls of the completed and of the true body share of the volume that either fills. Hollows do not count.
"""

from collections.abc import Iterator, Mapping, Sequence
from statistics import mean

import numpy as np

from topple.benchmarks.other_piles import NAME as OTHER_PILE
from topple.benchmarks.other_piles import other_pile
from topple.benchmarks.row import Progress, Row
from topple.planner.execution.demo import loop_in
from topple.robots.scenarios import scenario_called
from topple.robots.scenarios.scenario import Scenario
from topple.topology.arrays import FloatArray
from topple.topology.geometry.sides import beyond, joggled_sides
from topple.topology.situation import Situation

FIRST_SEED = 120_000
"""Of the scenes; nothing else begins there."""

SAMPLES = 5_000
"""Points at which two bodies are compared."""

BARS = {3: 90, 1: 80}
"""[%] by the number of cameras."""


def completion_rows(seed: int, scenes: int, progress: Progress) -> list[Row]:
    """Measure.

    Args:
        seed: Transfers on to other scenes.
        scenes: How many of each generator.
        progress: Called before each part.
    """
    found: list[Row] = []
    for cameras, bar in BARS.items():
        where = f"{cameras} camera{'s' * (cameras > 1)}"
        shares: list[tuple[str, float, float]] = []
        for number in range(scenes):
            progress(f"completed bodies, {where}: scene {number + 1} of {scenes}")
            first = FIRST_SEED + 1000 * seed + number
            for stage in (scenario_called("pile", first), other_pile(first)):
                with stage:
                    shares += _shares(stage, cameras, first)
        for generator in ("pile", OTHER_PILE):
            some = [both for name, *both in shares if name == generator]
            found.append(_row(f"{generator}, {where}, {len(some)} bodies", some))
        found.append(_row(f"{where}, {len(shares)} bodies", [both for _, *both in shares], f">= {bar}"))
    return found


def _row(what: str, shares: Sequence[Sequence[float]], bar: str | None = None) -> Row:
    completed, seen = (100 * mean(some) for some in zip(*shares, strict=True))
    return Row(f"overlap of completed and true hulls: {what}", completed, "%", "as seen", seen, bar=bar)


def _shares(stage: Scenario, cameras: int, seed: int) -> Iterator[tuple[str, float, float]]:
    """Generator, and the overlaps with the true hull of each body completed and as it was seen."""
    situation = Situation(loop_in(stage, seed=seed, cameras=cameras).look().scene)
    for name in situation.movable:
        true = _hull(stage.world.body(name).parts, stage.world.pose(name))
        completed, seen = (
            overlap(true, np.concatenate(list(bodies[name])), seed) for bodies in _bodies(situation)
        )
        yield stage.name, completed, seen


def _bodies(situation: Situation) -> tuple[Mapping[str, Sequence[FloatArray]], ...]:
    return situation.completed, {name: (cloud,) for name, cloud in situation.scene.clouds.items()}


def _hull(parts: Sequence[FloatArray], pose: FloatArray) -> FloatArray:
    return np.asarray(np.concatenate(list(parts)) @ pose[:3, :3].T + pose[:3, 3])


def overlap(a: FloatArray, b: FloatArray, seed: int) -> float:
    """What two convex hulls share of the volume that either fills, by points drawn at random.

    Args:
        a: (N, 3) points whose hull is meant [m].
        b: (M, 3) points of the other [m].
        seed: Of the points drawn.
    """
    both = np.concatenate([a, b])
    drawn = np.random.default_rng(seed).uniform(both.min(axis=0), both.max(axis=0), (SAMPLES, 3))
    in_a, in_b = (beyond(joggled_sides(points), drawn) <= 0 for points in (a, b))
    return float(np.count_nonzero(in_a & in_b) / max(np.count_nonzero(in_a | in_b), 1))
