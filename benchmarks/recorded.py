"""What others recorded to score orders on: piles with a lift oracle's verdicts, and annotated frames."""

import json
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from topple.benchmarks.labels import read_truth
from topple.benchmarks.scores import Labels
from topple.topology.base.errors import InvalidInput
from topple.topology.io.load import load_scene
from topple.topology.scene.scene import Scene

UNIT = 1e-4
"""Length [m] of one step of the stored clouds."""

KEYS = {0: "full", 1: "view1", 3: "view3"}
"""Cameras -> the view of the archive that they saw."""


@dataclass(frozen=True, eq=False)
class Case:
    """One pile, seen.

    Attributes:
        seed: Of what is drawn for it.
        labels: then -> first -> 1, 0 or None.
        scenes: Cameras, 0 for whole surfaces -> what they see.
    """

    seed: int
    labels: Labels
    scenes: dict[int, Scene]


@dataclass(frozen=True, eq=False)
class Frame:
    """One annotated camera frame.

    Attributes:
        name: Of its file.
        scene: What the camera saw.
        needed: (first, then) that must be found directly.
        doubtful: Pairs the annotator was not sure of, which count nowhere.
    """

    name: str
    scene: Scene
    needed: frozenset[tuple[str, str]]
    doubtful: frozenset[tuple[str, str]]


def recorded_piles(folder: Path) -> tuple[Case, ...]:
    """Read a folder of piles.

    Args:
        folder: Holds archives that `topple.topology.io.pile` reads, each with all three views.

    Returns:
        One case per archive, in the order of their names.

    Raises:
        InvalidInput: There is no archive, or one lacks its labels or a view.
    """
    paths = sorted(folder.glob("*.npz"))
    if not paths:
        raise InvalidInput(f"{folder}: no piles (*.npz) in this folder")
    cases: list[Case] = []
    for seed, path in enumerate(paths):
        labels = read_truth(path).labels
        with np.load(path) as archive:
            try:
                scenes = {cameras: _pile_scene(archive, cameras) for cameras in KEYS}
            except KeyError as error:
                raise InvalidInput(f"{path}: {error.args[0]}; a pile has labels and clouds") from error
        cases.append(Case(seed, labels, scenes))
    return tuple(cases)


def _pile_scene(archive: "np.lib.npyio.NpzFile", view: int) -> Scene:
    """One view of a pile, multiplied as when behaviour was frozen: a division differs in the last bits."""
    prefix = f"{KEYS[view]}/"
    clouds = {key[len(prefix) :]: archive[key] * UNIT for key in archive.files if key.startswith(prefix)}
    viewpoints = archive[f"viewpoints{view}"] if view else None
    fixed = [str(name) for name in archive["fixed"]]
    return Scene(clouds, fixed=fixed, up=archive["up"], viewpoints=viewpoints)


def recorded_frames(folder: Path) -> Iterator[Frame]:
    """Read the annotated frames of a folder of RGB-D frames.

    Args:
        folder: Holds `NAME.npz` beside `NAME.gt.json` with `removal_constraints`, `doubtful` and
            `uncertain_pairs`, ids for names and 1 for the table; frames without constraints are left out.

    Yields:
        The frames, in the order of their names.

    Raises:
        InvalidInput: No frame has constraints.
    """
    found = False
    for path in sorted(folder.glob("**/*.gt.json")):
        truth = json.loads(path.read_text(encoding="utf-8"))
        pairs = [(str(first), str(then)) for first, then in truth.get("removal_constraints", ())]
        if not pairs:
            continue
        found = True
        unsure = [pairs[k] for k in truth.get("doubtful", {}).get("removal_constraints", ())]
        for a, b, *_ in truth.get("uncertain_pairs", ()):
            unsure += [(str(a), str(b)), (str(b), str(a))]
        scene = load_scene(path.with_name(path.name.replace(".gt.json", ".npz")), fixed=["1"])
        yield Frame(path.name, scene, frozenset(pairs).difference(unsure), frozenset(unsure))
    if not found:
        raise InvalidInput(f"{folder}: no frames with removal constraints (NAME.npz beside NAME.gt.json)")
