"""The pool: scenes of four generators that are unlike, with what simulation says of each, kept in a file.

`python -m topple.benchmarks.truth.pool` makes the scenes that the file lacks: hours, and it goes on where it
was stopped. Each object in turn is lifted straight up, rigidly, and taken away at three frictions; whatever
moves had to go first (`oracle`). Relations are those of the exact shapes, where they are beyond doubt
(`geometry`).
"""

import argparse
import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache, cached_property
from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from topple.benchmarks.piles import make_pile
from topple.benchmarks.scores import Labels
from topple.benchmarks.truth.built import built
from topple.benchmarks.truth.designed import designed, leaning
from topple.benchmarks.truth.geometry import RelationLabels, relations_of
from topple.benchmarks.truth.oracle import labels_of
from topple.benchmarks.truth.resting import FRICTION, RestingScene
from topple.planner.cli.console import print_text
from topple.planner.simulate.lifts import set_friction
from topple.robots.poses import pose_from
from topple.robots.world.bodies import Body
from topple.topology.base.errors import InvalidInput, ToppleError
from topple.topology.base.files import write_whole
from topple.topology.base.workers import WorkerPool

FILE = Path(__file__).with_name("pool.npz")
UNIT = 2e-5  # [m] of the corners in the file: a fiftieth of a camera's noise
FIRST_SEED = 44_000_000
WRITTEN = 20  # scenes after which the file is written
SETS: Mapping[str, int] = {"settled": 300, "built": 400, "designed": 500, "leaning": 240}
SIGNS = {"1": 1, "0": 0, "?": None}


@dataclass(frozen=True, eq=False)
class PoolScene:
    """A scene of the pool.

    Attributes:
        set: The generator's name.
        kind: What it was to make.
        seed: Of the generator.
        shapes: Bodies and poses, as `shapes_of` gives them.
        labels: then -> first -> 1 had to go first, 0 not, None too close to call.
        relations: (a, b) -> relation of the exact shapes, "a relation b", pairs beyond doubt alone.
    """

    set: str
    kind: str
    seed: int
    shapes: Mapping[str, Any]
    labels: Labels
    relations: RelationLabels

    @cached_property
    def resting(self) -> RestingScene:
        """Bodies and poses: of few scenes in a pool they are asked, and their masses take a while."""
        return resting(self.shapes)

    @property
    def name(self) -> str:
        """Set and seed."""
        return f"{self.set} {self.seed}"


def _settled(seed: int) -> tuple[str, RestingScene]:
    pile = make_pile(seed)
    return "pile", RestingScene(pile.bodies, pile.poses)


_GENERATORS: Mapping[str, Callable[[int], tuple[str, RestingScene]]] = {
    "settled": _settled, "built": built, "designed": designed, "leaning": leaning,
}  # fmt: skip


def made(which: str, seed: int) -> dict[str, Any]:
    """Make and label a scene, as JSON data.

    Args:
        which: The generator.
        seed: Its seed.

    Returns:
        The entry; `failed` says why there is none.
    """
    head = {"set": which, "seed": seed}
    try:
        kind, scene = _GENERATORS[which](seed)
        bodies = tuple(_body(body.name, _rounded(body), body.mass, body.rolling) for body in scene.bodies)
        with RestingScene(bodies, scene.poses, scene.fixed).world() as world:
            world.settle(3.0)
            rest = RestingScene(bodies, {name: world.pose(name) for name in scene.poses}, scene.fixed)
        with rest.world() as world:
            movable = [name for name in rest.poses if name not in rest.fixed]
            labels = labels_of(world, movable)
            set_friction(world, *FRICTION)
            relations = relations_of(rest, world)
    except ToppleError as error:
        return {**head, "failed": str(error)}
    signs = {value: sign for sign, value in SIGNS.items()}
    rows = ["".join("-" if a == b else signs[labels[b][a]] for a in movable) for b in movable]
    return {
        **head,
        "kind": kind,
        **shapes_of(rest),
        "labels": rows,
        "relations": [[*pair, relation] for pair, relation in relations.items()],
    }


def shapes_of(scene: RestingScene) -> dict[str, Any]:
    """Bodies and poses as JSON data, corners in whole `UNIT`s.

    Args:
        scene: The scene; its poses are in the order of its bodies.
    """
    return {
        "names": list(scene.poses),
        "fixed": sorted(scene.fixed),
        "parts": [[part.tolist() for part in _rounded(body)] for body in scene.bodies],
        "mass": [round(body.mass, 4) for body in scene.bodies],
        "rolling": [body.rolling for body in scene.bodies],
        "poses": [_flat(pose) for pose in scene.poses.values()],
    }


def resting(shapes: Mapping[str, Any]) -> RestingScene:
    """The scene of what `shapes_of` gave."""
    names = shapes["names"]
    bodies = tuple(map(_body, names, shapes["parts"], shapes["mass"], shapes["rolling"]))
    poses = {name: pose_from(pose[:3], pose[3:]) for name, pose in zip(names, shapes["poses"], strict=True)}
    return RestingScene(bodies, poses, frozenset(shapes["fixed"]))


def _rounded(body: Body) -> list[np.ndarray[Any, Any]]:
    return [np.unique(np.rint(part / UNIT).astype(np.int16), axis=0) for part in body.parts]


def _body(name: str, parts: Sequence[Any], mass: float, rolling: float) -> Body:
    return Body.of(name, [np.asarray(part, dtype=float) * UNIT for part in parts], mass=mass, rolling=rolling)


def _flat(pose: Any) -> list[float]:
    return [round(float(x), 7) for x in (*pose[:3, 3], *Rotation.from_matrix(pose[:3, :3]).as_quat())]


def pack(entries: Sequence[Mapping[str, Any]], path: Path) -> None:
    """Write scenes as a pool: corners and poses as arrays, all else as JSON.

    Args:
        entries: As `made` gives them; those that failed are left out.
        path: Where.
    """
    kept = [entry for entry in entries if "failed" not in entry]
    kept.sort(key=lambda entry: (list(SETS).index(entry["set"]), entry["seed"]))
    parts = [np.asarray(part, dtype=np.int16) for entry in kept for body in entry["parts"] for part in body]
    heads = [{**entry, "parts": [len(body) for body in entry["parts"]]} for entry in kept]
    for head in heads:
        del head["poses"]
    buffer = BytesIO()
    np.savez_compressed(
        buffer,
        corners=np.concatenate(parts),
        sizes=np.array([len(part) for part in parts], dtype=np.uint16),
        poses=np.array([pose for entry in kept for pose in entry["poses"]]),
        scenes=np.array(json.dumps(heads)),
    )
    write_whole(path, buffer.getvalue())


def entries_in(path: Path) -> list[dict[str, Any]]:
    """What `pack` wrote.

    Args:
        path: The pool; none holds nothing.
    """
    if not path.is_file():
        return []
    with np.load(path, allow_pickle=False) as held:
        ends = np.cumsum(held["sizes"].astype(np.int64))
        parts = iter(np.split(held["corners"], ends[:-1]))
        poses = iter(held["poses"].tolist())
        heads: list[dict[str, Any]] = json.loads(str(held["scenes"]))
    for head in heads:
        head["parts"] = [[next(parts) for _ in range(count)] for count in head["parts"]]
        head["poses"] = [next(poses) for _ in head["names"]]
    return heads


@cache
def pool(path: Path = FILE) -> tuple[PoolScene, ...]:
    """Read the pool.

    Args:
        path: The file.

    Returns:
        Its scenes, by set and seed.

    Raises:
        InvalidInput: It is not there: wheels come without it.
    """
    if not path.is_file():
        raise InvalidInput(f"{path} is not there: the pool of scenes comes with a checkout, not with a wheel")
    return tuple(map(_scene, entries_in(path)))


def _scene(entry: Mapping[str, Any]) -> PoolScene:
    movable = [name for name in entry["names"] if name not in entry["fixed"]]
    labels = {
        then: {first: SIGNS[sign] for first, sign in zip(movable, row, strict=True) if first != then}
        for then, row in zip(movable, entry["labels"], strict=True)
    }
    relations = {(a, b): word for a, b, word in entry["relations"]}
    return PoolScene(entry["set"], entry["kind"], entry["seed"], entry, labels, relations)


def _made(job: tuple[str, int]) -> dict[str, Any]:
    return made(*job)


def main() -> None:
    """Make what the pool lacks; it is written as it grows."""
    parser = argparse.ArgumentParser(description="Make the pool of labelled scenes, or go on with it.")
    parser.add_argument("--most", type=int, default=max(SETS.values()), help="scenes of a set to come to")
    most: int = parser.parse_args().most
    entries = entries_in(FILE)
    there = {(entry["set"], entry["seed"]) for entry in entries}
    jobs = [
        (which, FIRST_SEED + number)
        for number in range(most)
        for which, count in SETS.items()
        if number < count and (which, FIRST_SEED + number) not in there
    ]
    with WorkerPool(2) as workers:
        for done, entry in enumerate(workers.map(_made, jobs, chunksize=1), 1):
            entries.append(entry)
            said = f"{done} of {len(jobs)}: {entry['set']} {entry.get('kind', entry.get('failed'))}"
            print_text(f"{said} {entry['seed']}")
            if done % WRITTEN == 0 or done == len(jobs):
                pack(entries, FILE)


if __name__ == "__main__":
    main()
