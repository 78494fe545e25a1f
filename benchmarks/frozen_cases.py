"""What is frozen: seeded episodes, relations and orders of piles and frames, plans."""

import json
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from topple.benchmarks.behaviour import EPISODE, ORDER, PLAN, RELATIONS, Paths, digest
from topple.benchmarks.order import FIRST_PILE, VIEWS
from topple.benchmarks.piles import make_pile, observe
from topple.benchmarks.plans import seen
from topple.benchmarks.recorded import recorded_piles
from topple.planner.execution.demo import loop_in
from topple.planner.formats.plan_format import plan_to_json
from topple.planner.planning.order import order
from topple.planner.planning.plan import plan
from topple.robots.scenarios import scenario_called
from topple.topology.errors import InvalidInput, UnknownObject
from topple.topology.io.load import load_scene
from topple.topology.io.sequence import load_sequence
from topple.topology.relations import relate
from topple.topology.scene import Scene

EPISODES = (
    ("tower", 0, 3),  # the quick one
    ("sort", 0, 3),
    *(("dishes", seed, 3) for seed in (0, 1)),
    ("dishes", 0, 1),
    *(("lemon", seed, 3) for seed in (0, 1, 2)),
    *(("lemon", seed, 1) for seed in (1, 2)),
    *(("pile", seed, 3) for seed in (0, 1, 3, 4)),
    *(("pile", seed, 1) for seed in (0, 1, 3)),
    *(("tower", seed, 3) for seed in (1, 2)),
    *(("tower", seed, 1) for seed in (0, 1)),
)
"""Scene, seed, cameras; some go wrong, and have to go wrong in the same way."""

PLANS = (("tower", 0, "panda"), ("dishes", 0, "panda-suction"), ("tower", 0, "iiwa"))
"""Built-in scene, seed, arm."""

PILES = 12  # of our own
PILES_QUICK = 2
SPARSE = 20  # of recorded piles and frames, every so manieth is in the quick subset
FRAMES_APART = 45  # [frames] of a tracked scene: what happens in it takes some seconds
TABLE = "1"  # the label of the table in frames that have one


@dataclass(frozen=True)
class Item:
    """Something that is frozen.

    Attributes:
        what: What it is, unlike all others.
        digest: Part -> digest, see `topple.benchmarks.behaviour`.
        summary: For a reader, what came of it; it does not count.
    """

    what: str
    digest: Mapping[str, str]
    summary: str


@dataclass(frozen=True)
class Case:
    """Something to be computed, in any process.

    Attributes:
        what: What it is; that of its items begins with it.
        work: Computes them.
        given: What it is called with, after `what`.
        recorded: Whether it takes data that is no part of topple.
    """

    what: str
    work: Callable[..., tuple[Item, ...]]
    given: tuple[Any, ...]
    recorded: bool = False

    def items(self) -> tuple[Item, ...]:
        """Compute."""
        return self.work(self.what, *self.given)


def cases(quick: bool, data: Path | None, piles: Path | None) -> list[Case]:
    """List what is computed.

    Args:
        quick: A subset that takes below a minute.
        data: A folder with frames (`*.npz`) in folders, tracked scenes in one called `sequences`.
        piles: A folder of recorded piles; `piles` beside `data` where None.

    Returns:
        What takes longest first, so that two processes end together.

    Raises:
        InvalidInput: A folder lacks what it should hold.
    """
    count, some = (PILES_QUICK, slice(1)) if quick else (PILES, slice(None))
    found = [
        Case(f"episode {name} {seed}, {_eyes(cameras)}", _episode, (name, seed, cameras))
        for name, seed, cameras in EPISODES[some]
    ]
    found += [Case(f"plan {name} {seed}, {arm}", _plan, (name, seed, arm)) for name, seed, arm in PLANS[some]]
    found += [Case(f"generated pile {number}", _generated, (number,)) for number in range(count)]
    beside = None if data is None else data.resolve().parent / "piles"
    folder = beside if piles is None and beside is not None and beside.is_dir() else piles
    recorded = [] if folder is None else list(_piles(folder))
    recorded += [] if data is None else list(_frames(data))
    return found + recorded[:: SPARSE if quick else 1]


def _piles(folder: Path) -> Iterator[Case]:
    for path, case in zip(sorted(folder.glob("*.npz")), recorded_piles(folder), strict=True):
        for view, scene in case.scenes.items():
            yield Case(f"{path.stem}, {VIEWS[view]}", _scene, (scene,), recorded=True)


def _frames(folder: Path) -> Iterator[Case]:
    paths = sorted(folder.rglob("*.npz"))
    if not paths:
        raise InvalidInput(f"{folder}: no frames (*.npz) in this folder or below")
    for path in paths:
        what = path.relative_to(folder).with_suffix("").as_posix()
        yield Case(what, _sequence if path.parent.name == "sequences" else _frame, (path,), recorded=True)


def _episode(what: str, name: str, seed: int, cameras: int) -> tuple[Item, ...]:
    def play() -> dict[str, Any]:
        with scenario_called(name, seed) as stage:
            record = loop_in(stage, seed=seed, cameras=cameras).run()
        document = record.to_json()  # with milliseconds, halves of which steps of 1/240 s often come to
        for entry, step in zip(document["steps"], record.steps, strict=True):
            entry["robot_seconds"] = step.robot_seconds
        return document

    return (_item(what, play, EPISODE, _of_episode),)


def _plan(what: str, name: str, seed: int, arm: str) -> tuple[Item, ...]:
    def make() -> dict[str, Any]:
        with scenario_called(name, seed) as stage:
            scene = seen(stage)
        made = plan(scene, stage.goal, arm, base=stage.pose_base_to_world, seed=seed)
        return json.loads(plan_to_json(made))

    return (_item(what, make, PLAN, _of_plan),)


def _generated(what: str, number: int) -> tuple[Item, ...]:
    seed = FIRST_PILE + number
    pile = make_pile(seed)
    views = {words: observe(pile, cameras, seed) for cameras, words in VIEWS.items()}
    return tuple(item for words, scene in views.items() for item in _scene(f"{what}, {words}", scene))


def _frame(what: str, path: Path) -> tuple[Item, ...]:
    try:
        scene = load_scene(path, fixed=[TABLE])
    except UnknownObject:
        scene = load_scene(path)
    return _scene(what, scene)


def _sequence(what: str, path: Path) -> tuple[Item, ...]:
    frames = enumerate(load_sequence(path))
    kept = ((number, scene) for number, scene in frames if number % FRAMES_APART == 0)
    return tuple(item for number, scene in kept for item in _scene(f"{what} frame {number}", scene))


def _scene(what: str, scene: Scene) -> tuple[Item, ...]:
    return (
        _item(f"{what}: relations", lambda: relate(scene).to_json(), RELATIONS, _of_relations),
        _item(f"{what}: order", lambda: order(scene).to_json(), ORDER, _of_order),
    )


def _item(
    what: str, work: Callable[[], dict[str, Any]], paths: Paths, words: Callable[[dict[str, Any]], str]
) -> Item:
    """Digest what comes of something; that it is refused, or fails, is a result too."""
    try:
        document = work()
    except Exception as error:
        kind = type(error).__name__
        return Item(what, digest({"error": kind}, {"error": ("error",)}), f"{kind}: {error}")
    return Item(what, digest(document, paths), words(document))


def _of_episode(run: Mapping[str, Any]) -> str:
    steps: Sequence[Mapping[str, Any]] = run["steps"]
    done = ", ".join(f"{step['action']} {step['object']}" for step in steps)
    seconds = sum(step["robot_seconds"] or 0.0 for step in steps)
    ended = "success" if run["success"] else "; ".join([run["stopped"] or "failed", *run["violations"]])
    return f"{done}: {ended}, {seconds:.2f} s"


def _of_plan(made: Mapping[str, Any]) -> str:
    steps = ", ".join(f"{step['action']} {step['object']}" for step in made["steps"])
    return f"{steps}: {made['seconds']:.2f} s" + ("" if made["certified"] else ", not certified")


def _of_relations(found: Mapping[str, Any]) -> str:
    pairs: dict[str, list[str]] = {}
    for pair in found["relations"]:
        pairs.setdefault(pair["relation"], []).append(f"{pair['a']}-{pair['b']}")
    apart = len(pairs.pop("disjoint", []))
    said = [f"{relation} {' '.join(some)}" for relation, some in sorted(pairs.items())]
    return "; ".join([*said, f"{apart} disjoint", f"deviation {1000 * found['deviation']:.2f} mm"])


def _of_order(found: Mapping[str, Any]) -> str:
    reasons = Counter(edge["reason"] for edge in found["dependencies"])
    said = [" ".join(found["order"]), *(f"{count} {reason}" for reason, count in sorted(reasons.items()))]
    return "; ".join([*said, f"{len(found['supports'])} supports"])


def _eyes(cameras: int) -> str:
    return "1 camera" if cameras == 1 else f"{cameras} cameras"
