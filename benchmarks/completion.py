"""How much of a body there is once its hidden sides are completed, against its true body.

Of scenes of two generators, seen by simulated depth cameras, on seeds that chose nothing: what the convex
hulls of the completed and of the true body share of the volume that either fills. Hollows do not count. Then
the same with the mesh of each body known by name: how much they share once those are registered, how many
are, and how many of these are wrong.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from statistics import mean
from tempfile import TemporaryDirectory

import numpy as np

from topple.benchmarks.other_piles import NAME as OTHER_PILE
from topple.benchmarks.other_piles import other_pile
from topple.benchmarks.row import Progress, Row
from topple.planner.execution.demo import loop_in
from topple.robots import scenario
from topple.robots.scenarios.scenario import Scenario
from topple.topology.base.arrays import FloatArray
from topple.topology.geometry.rigid import move_points
from topple.topology.geometry.sides import beyond, joggled_sides
from topple.topology.io.known_models import with_models
from topple.topology.situation.situation import Situation

FIRST_SEED = 120_000
"""Of the scenes; nothing else begins there."""

SAMPLES = 5_000
"""Points at which two bodies are compared."""

BARS = {3: 90, 1: 80}
"""[%] by the number of cameras."""

RIGHT = 0.8
"""Overlap of a model, where it was registered, with the true body; off by 1 cm or 10 degrees it has less."""


@dataclass(frozen=True)
class Completed:
    """What a body has of its true hull.

    Attributes:
        generator: Of its scene.
        completed: Overlap of the completed body.
        seen: Overlap of what was seen.
        known: Overlap with its model known.
        posed: Overlap of its model at the registered pose, taken or not.
        taken: Whether the model took the place of what was seen.
    """

    generator: str
    completed: float
    seen: float
    known: float
    posed: float
    taken: bool


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
        bodies: list[Completed] = []
        for number in range(scenes):
            progress(f"completed bodies, {where}: scene {number + 1} of {scenes}")
            first = FIRST_SEED + 1000 * seed + number
            for stage in (scenario("pile", first), other_pile(first)):
                with stage:
                    bodies += _completed(stage, cameras, first)
        for generator in ("pile", OTHER_PILE):
            some = [body for body in bodies if body.generator == generator]
            found.append(_row(f"{generator}, {where}, {len(some)} bodies", some))
        found.append(_row(f"{where}, {len(bodies)} bodies", bodies, f">= {bar}"))
        found += _known_rows(f"{where}, {len(bodies)} bodies", bodies, f">= {bar}")
    return found


def _row(what: str, bodies: Sequence[Completed], bar: str | None = None) -> Row:
    completed, seen = (
        100 * mean(some) for some in zip(*((body.completed, body.seen) for body in bodies), strict=True)
    )
    return Row(f"overlap of completed and true hulls: {what}", completed, "%", "as seen", seen, bar=bar)


def _known_rows(what: str, bodies: Sequence[Completed], bar: str) -> list[Row]:
    """The same with known models: overlap, and what came of registering them."""
    known, completed = (
        100 * mean(some) for some in zip(*((b.known, b.completed) for b in bodies), strict=True)
    )
    taken = [body for body in bodies if body.taken]
    wrong = sum(body.posed < RIGHT for body in taken)
    missed = sum(body.posed >= RIGHT for body in bodies if not body.taken)
    share = 100 / len(bodies)
    return [
        Row(f"overlap with known models: {what}", known, "%", "completed", completed, bar=bar),
        Row(f"known models registered: {what}", share * len(taken), "%"),
        Row(f"known models refused, and where they would fit: {what}", share * missed, "%"),
        Row(f"known models registered wrongly: {what}", share * wrong, "%", bar="<= 2"),
    ]


def _completed(stage: Scenario, cameras: int, seed: int) -> Iterator[Completed]:
    """Overlaps with the true hull of each body: completed, as it was seen, and with its model known."""
    situation = Situation(loop_in(stage, seed=seed, cameras=cameras).look().scene)
    with TemporaryDirectory() as folder:
        known = Situation(with_models(situation.scene, _written(stage, Path(folder))))
    for name in situation.movable:
        fit, mesh = known.scene.models[name], stage.world.body(name).mesh
        true = _hull(stage.world.body(name).parts, stage.world.pose(name))
        completed, seen, modelled = (
            overlap(true, np.concatenate(list(bodies[name])), seed)
            for bodies in (*_bodies(situation), known.completed)
        )
        posed = overlap(true, move_points(mesh.vertices, fit.pose_model_to_world), seed)
        yield Completed(stage.name, completed, seen, modelled, posed, fit.refused is None)


def _written(stage: Scenario, folder: Path) -> Path:
    """A folder with the mesh of every body under its name."""
    import trimesh

    for name in stage.world.movable:
        mesh = stage.world.body(name).mesh
        trimesh.Trimesh(mesh.vertices, mesh.faces, process=False).export(folder / f"{name}.ply")
    return folder


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
