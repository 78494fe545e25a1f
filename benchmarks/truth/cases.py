"""Cases: scenes of the pool and of recorded data, each in every view, as a version is asked and is scored."""

import hashlib
import json
from collections.abc import Iterator, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass, replace
from functools import cache, partial
from itertools import product
from pathlib import Path

import numpy as np

from topple.benchmarks.labelled import truth_of
from topple.benchmarks.labels import read_truth
from topple.benchmarks.recorded import KEYS, UNIT
from topple.benchmarks.row import Progress
from topple.benchmarks.scores import Labels
from topple.benchmarks.truth import geometry, mask_faults, pool, views
from topple.benchmarks.truth.answers import Question
from topple.benchmarks.truth.geometry import RelationLabels
from topple.benchmarks.truth.mask_faults import NO_FAULTS, MaskFaults, corrupt
from topple.benchmarks.truth.pool import SETS, PoolScene
from topple.benchmarks.truth.resting import TABLE as NARROW
from topple.benchmarks.truth.views import VIEWS
from topple.robots.world import camera
from topple.topology.base.errors import InvalidInput
from topple.topology.base.workers import open_executor

GATED = ("settled", "built", "designed")
FEW = 20
"""Scenes of each of these sets that every run has: the quick run, and all jitter."""

MANY = 400
"""Scenes of the pool on which a change is judged, drawn by its commit."""

TAUGHT = 4
"""Beyond those, every so manieth scene of a set teaches how likely what is found of a pair is true."""

TABLE_LABEL = "1"
"""Label of the table in recorded frames."""


@dataclass(frozen=True, eq=False)
class Case:
    """A scene in one view.

    Attributes:
        set: What it is of: a generator, recorded piles or frames.
        view: One of `VIEWS`.
        name: Of the scene.
        question: What a version is asked.
        labels: What simulation, or a person, says of orders.
        relations: What the shapes, or a person, say of relations.
        looks: Further looks at the same scene.
        mask_faults: What is wrong with its masks.
    """

    set: str
    view: str
    name: str
    question: Question
    labels: Labels
    relations: RelationLabels
    looks: tuple[Question, ...] = ()
    mask_faults: MaskFaults = NO_FAULTS


def few() -> list[PoolScene]:
    """The scenes of every run."""
    return [scene for which in GATED for scene in [s for s in pool.pool() if s.set == which][:FEW]]


def drawn(commit: str) -> list[PoolScene]:
    """Scenes on which a commit is judged, of each set as many as its share.

    Args:
        commit: Its name; another commit draws other scenes, so that no set becomes what one works towards.
    """
    rng = np.random.default_rng(int(hashlib.sha256(commit.encode()).hexdigest()[:8], 16))
    taught = {scene.name for scene in training()}
    every = [scene for scene in pool.pool() if scene.name not in taught]
    found: list[PoolScene] = []
    for which in SETS:
        own = [scene for scene in every if scene.set == which]
        count = min(len(own), round(MANY * len(own) / len(every)))
        found += [own[k] for k in sorted(rng.choice(len(own), count, replace=False))]
    return found


def training() -> list[PoolScene]:
    """Scenes that chances are fitted to: no version is judged on them."""
    return [scene for which in SETS for scene in [s for s in pool.pool() if s.set == which][FEW::TAUGHT]]


def table_of(scene: PoolScene) -> tuple[float, float]:
    """Extents of the table [m] that a scene is looked at on."""
    return views.WIDE if scene.seed % views.NARROW_EVERY else NARROW


def pool_cases(
    scenes: Sequence[PoolScene],
    folder: Path,
    progress: Progress,
    looks: int = 1,
    executor: Executor | None = None,
) -> list[Case]:
    """Cases of the pool in every view, rendered where they are not yet.

    Args:
        scenes: The scenes.
        folder: Where what topple is given is kept.
        progress: Called as scenes are rendered.
        looks: How often cameras look at each.
        executor: Whose workers render; None for a process a core.
    """
    place = folder / _digest()
    place.mkdir(parents=True, exist_ok=True)
    jobs = [
        (scene, view, look)
        for scene in scenes
        for view, cameras in VIEWS.items()
        for look in range(looks if cameras else 1)
    ]
    missing = [job for job in jobs if not _file(place, *job).exists()]
    if missing:
        with open_executor(executor) as workers:
            for number, path in enumerate(workers.map(partial(_rendered, place), missing), 1):
                progress(f"{number} of {len(missing)} views rendered: {path.stem}")
    return [
        Case(
            scene.set, view, scene.name, _question(scene, place, view, 0), scene.labels, scene.relations,
            tuple(_question(scene, place, view, look) for look in range(1, looks if cameras else 1)),
        )
        for scene in scenes
        for view, cameras in VIEWS.items()
    ]  # fmt: skip


def _question(scene: PoolScene, place: Path, view: str, look: int) -> Question:
    return Question(f"{scene.name}, {view}", _file(place, scene, view, look), tuple(scene.labels))


def _file(place: Path, scene: PoolScene, view: str, look: int) -> Path:
    shape = hashlib.sha256()
    for body in scene.resting.bodies:
        shape.update(
            scene.resting.poses[body.name].tobytes() + b"".join(part.tobytes() for part in body.parts)
        )
    return place / f"{scene.set}-{scene.seed}-{shape.hexdigest()[:8]}-{VIEWS[view]}-{look}.npz"


def _rendered(place: Path, job: tuple[PoolScene, str, int]) -> Path:
    scene, view, look = job
    arrays = views.seen(scene.resting, VIEWS[view], look, table_of(scene))
    path = _file(place, scene, view, look)
    views.keep(arrays, path)
    return path


@cache
def _digest() -> str:
    """Of all that decides what topple is given of a scene, in whatever pool it is."""
    sources = [Path(module.__file__ or "") for module in (views, geometry, camera)]
    return hashlib.sha256(b"".join(path.read_bytes() for path in sources)).hexdigest()[:12]


def masked_cases(cases: Sequence[Case], hows: Sequence[str], folder: Path) -> Iterator[Case]:
    """The same cases of one camera with masks as segmentations give them, each way in turn.

    Args:
        cases: The cases.
        hows: Some of `mask_faults.INACCURATE` and `mask_faults.WRONG`.
        folder: Where what topple is given is kept.
    """
    place = folder / "masks"
    place.mkdir(parents=True, exist_ok=True)
    for case, how in product(cases, hows):
        yield _masked(case, how, place)


def _masked(case: Case, how: str, place: Path) -> Case:
    source = case.question.path
    with np.load(source, allow_pickle=False) as held:
        arrays = {key: held[key] for key in held.files}
    key = "label" if "label" in arrays else "label_0"
    label = arrays[key].astype(np.int64)
    names = [str(name) for name in arrays.get("names", np.arange(1, label.max() + 1))]
    support = case.question.fixed[0] if case.question.fixed else "table"
    rng = np.random.default_rng(int(hashlib.sha256(case.name.encode()).hexdigest()[:8], 16))
    arrays[key], names, faults = corrupt(label, names, how, support, rng)
    if "names" in arrays:
        arrays["names"] = np.array(names)
    made_of = hashlib.sha256(source.read_bytes() + Path(mask_faults.__file__).read_bytes()).hexdigest()[:12]
    path = place / f"{source.stem}-{how.replace(' ', '-')}-{made_of}.npz"
    if not path.exists():
        views.keep(arrays, path)
    question = replace(case.question, name=f"{case.question.name}, masks {how}", path=path)
    which = "masks" if case.set in SETS else f"{case.set}, masks"
    return replace(case, set=which, view=how, question=question, looks=(), mask_faults=faults)


def recorded_cases(data: Path | None, piles: Path | None, folder: Path) -> list[Case]:
    """Cases of recorded data.

    Args:
        data: A folder with annotated frames.
        piles: A folder of recorded piles; `piles` beside `data` where None and there.
        folder: Where what topple is given is kept.

    Raises:
        InvalidInput: A folder lacks what it should hold.
    """
    beside = None if data is None else data.resolve().parent / "piles"
    archives = piles or (beside if beside is not None and beside.is_dir() else None)
    found = [] if archives is None else list(_piles(archives, folder))
    frames = [] if data is None else list(_frames(data))
    if data is not None and not frames:
        raise InvalidInput(f"{data}: no annotated frames (NAME.npz beside NAME.gt.json) here or below")
    return [*found, *frames]


def _piles(archives: Path, folder: Path) -> Iterator[Case]:
    for path in sorted(archives.glob("*.npz")):
        labels = read_truth(path).labels
        with np.load(path, allow_pickle=False) as held:
            given = {key: held[key] for key in held.files}
        for view, cameras in VIEWS.items():
            prefix = f"{KEYS[cameras]}/"
            own = [key for key in given if key.startswith(prefix)]
            clouds = {key.removeprefix(prefix): given[key] * UNIT for key in own}
            arrays = {
                "names": np.array(list(clouds)), "fixed": given["fixed"], "up": given["up"],
                **{f"cloud_{k}": cloud for k, cloud in enumerate(clouds.values())},
                **({"viewpoints": given[f"viewpoints{cameras}"]} if cameras else {}),
            }  # fmt: skip
            place = folder / "recorded" / f"{path.stem}-{cameras}.npz"
            place.parent.mkdir(parents=True, exist_ok=True)
            views.keep(arrays, place)
            question = Question(f"{path.stem}, {view}", place, tuple(labels))
            yield Case("recorded piles", view, path.stem, question, labels, {})


def _frames(data: Path) -> Iterator[Case]:
    for path in sorted(data.rglob("*.gt.json")):
        truth = json.loads(path.read_text(encoding="utf-8"))
        if "removal_constraints" not in truth:
            continue
        labels = read_truth(path).labels
        name = path.name.removesuffix(".gt.json")
        file = path.with_name(f"{name}.npz")
        fixed = (TABLE_LABEL,) if TABLE_LABEL in truth["objects"] else ()
        question = Question(name, file, tuple(labels), load=True, fixed=fixed)
        yield Case("recorded frames", "1 camera", name, question, labels, truth_of(truth))
