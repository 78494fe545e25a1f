"""One variant of one scene: staged, seen, and answered by every column."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from topple.benchmarks.clock import cpu_seconds
from topple.benchmarks.paper.columns import (
    ESTIMATED,
    LENIENT,
    PLAIN,
    TOPPLE,
    Answer,
    Column,
    cleaned,
    columns,
)
from topple.benchmarks.paper.layouts import LAYOUTS
from topple.benchmarks.paper.looks import FEW, WHOLE, look, looks_at
from topple.benchmarks.paper.stage import staged
from topple.benchmarks.paper.things import Things
from topple.benchmarks.paper.truth import SCENES, Listed
from topple.topology.scene.scene import Scene
from topple.topology.sixim.table import Relation

SCORED = 14_000
"""Family of variants that is scored with seed 0; another seed moves on to another family."""


@dataclass(frozen=True)
class Task:
    """What is to be done.

    Attributes:
        number: Of the scene.
        variant: Of the scene.
        seed: Family of variants.
        things: Where the objects come from.
        learned: The trained column, if any.
        folder: Where the scenes are written to, if anywhere.
    """

    number: int
    variant: int
    seed: int
    things: Things
    learned: Column | None = None
    folder: Path | None = None


@dataclass(frozen=True)
class Judged:
    """One pair, judged.

    Attributes:
        a: One object.
        b: The other.
        true: "a true b".
        said: What the column says, None where it knows an object not.
        right: Whether that counts as right.
    """

    a: str
    b: str
    true: Relation
    said: Relation | None
    right: bool

    @property
    def is_contact(self) -> bool:
        """Whether the pair is not disjoint."""
        return self.true is not Relation.DISJOINT

    @property
    def claimed(self) -> bool:
        """Whether the column says it is not disjoint."""
        return self.said not in (None, Relation.DISJOINT)


@dataclass(frozen=True)
class Outcome:
    """What one column said of one look at one variant.

    Attributes:
        number: Of the scene.
        variant: Of the scene.
        how: How it was looked at.
        column: Name of the method.
        pairs: All pairs.
        seconds: CPU time [s].
    """

    number: int
    variant: int
    how: str
    column: str
    pairs: tuple[Judged, ...]
    seconds: float

    @property
    def right(self) -> int:
        """Number of pairs that are right."""
        return sum(pair.right for pair in self.pairs)


def solve(task: Task) -> list[Outcome]:
    """Stage a variant, look at it, and let every column answer.

    Args:
        task: What is to be done.

    Returns:
        One outcome per way of looking and column.
    """
    found: list[Outcome] = []
    family = SCORED + task.seed
    with staged(task.number, task.variant, family, task.things, LAYOUTS) as world:
        for index, how in enumerate(looks_at(task.number)):
            rng = np.random.default_rng([family, task.number, task.variant, index])
            scene = look(world, task.number, how, rng)
            if task.folder is not None:
                _write(scene, task, how)
            found += _answers(scene, task, how)
    return found


def _answers(scene: Scene, task: Task, how: str) -> list[Outcome]:
    """All columns on whole surfaces and few views, topple and the paper's rule on the others."""
    methods: Mapping[str, Column] = columns(task.learned)
    if how not in (FEW, WHOLE):
        methods = {name: methods[name] for name in (TOPPLE, PLAIN, ESTIMATED)}
    without_strays = cleaned(scene)
    found: list[Outcome] = []
    for name, method in methods.items():
        answers: list[Answer] = []
        given = scene if name == TOPPLE else without_strays
        seconds = cpu_seconds(
            lambda method=method, given=given, answers=answers: answers.append(method(given))
        )
        pairs = tuple(judged(listed, answers[0], name in LENIENT) for listed in SCENES[task.number].pairs)
        found.append(Outcome(task.number, task.variant, how, name, pairs, seconds))
    return found


def judged(listed: Listed, answer: Answer, lenient: bool = False) -> Judged:
    """Hold an answer against the truth of a pair.

    Args:
        listed: The pair and its relation.
        answer: What a column says.
        lenient: Whether within and partial within, contain and partial contain count as the same.
    """
    a, true, b = listed
    said = answer.get((a, b))
    if said is None and (b, a) in answer:
        said = answer[b, a].converse
    right = said is true or (lenient and said is not None and _loose(said) is _loose(true))
    return Judged(a, b, true, said, right)


def _loose(relation: Relation) -> Relation:
    """Without the difference between whole and part."""
    merged = {Relation.PARTIAL_WITHIN: Relation.WITHIN, Relation.PARTIAL_CONTAIN: Relation.CONTAIN}
    return merged.get(relation, relation)


def _write(scene: Scene, task: Task, how: str) -> None:
    """Write a scene as the commands read it; the first variant under the plain name."""
    assert task.folder is not None
    name = f"scene_{task.number:02d}"
    if how not in (FEW, WHOLE):
        name += "_" + how.replace(" ", "_")
    if task.variant:
        name += f"_variant_{task.variant}"
    arrays: dict[str, Any] = {key: cloud.astype(np.float32) for key, cloud in scene.clouds.items()}
    arrays |= {"fixed": np.array(sorted(scene.fixed)), "up": np.array([0.0, 0.0, 1.0])}
    if len(scene.viewpoints):
        arrays["viewpoints"] = scene.viewpoints
    np.savez_compressed(task.folder / f"{name}.npz", **arrays)
