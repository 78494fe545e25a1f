"""Relations held against real frames that a person labelled: RGB-D scenes with masks, and a tracked sequence.

The data are not part of the project: a folder with `rgbd/*.gt.json` beside its frames and
`sequences/*.gt.json` beside its recordings. No tolerance was chosen on them: those of the default rule come
from what a depth camera measures and from rendered piles (`topology/base/tolerances.py`).
"""

import json
from collections.abc import Mapping
from itertools import combinations
from pathlib import Path
from typing import Any

from topple.benchmarks.row import Progress, Row
from topple.topology.io import load_scene, load_sequence
from topple.topology.relations.relate import Relations, relate
from topple.topology.sixim.table import Relation

FIRST_FRAME = 2
"""Number of a recording's first frame, from which its truth counts."""


def rows(data: Path | None, progress: Progress) -> list[Row]:
    """Relate the labelled frames.

    Args:
        data: Folder with `rgbd` and `sequences`; None leaves the rows out.
        progress: Called before each part.

    Returns:
        Rows of what is there.
    """
    if data is None:
        progress("no --data: labelled frames are left out")
        return []
    found: list[Row] = []
    frames = sorted((data / "rgbd").glob("*.gt.json"))
    if frames:
        progress(f"{len(frames)} labelled frames")
        found += _frames(frames)
    for truth in sorted((data / "sequences").glob("*.gt.json")):
        progress(truth.name)
        found.append(_sequence(truth))
    return found


def _frames(truths: list[Path]) -> list[Row]:
    right = wanted = false = 0
    for path in truths:
        truth = json.loads(path.read_text(encoding="utf-8"))
        fixed = ["1"] if "1" in truth["objects"] else []
        relations = relate(load_scene(_beside(path), fixed=fixed))
        left_out = {frozenset(map(str, pair[:2])) for pair in truth["uncertain_pairs"]}
        told = _told(truth["relations"], left_out)
        wanted += len(told)
        right += sum(_answer(relations, *pair) == relation for pair, relation in told.items())
        known = left_out | {frozenset(pair) for pair in told}
        false += sum(
            pair.relation is not Relation.DISJOINT
            for pair in relations.pairs
            if frozenset((pair.a, pair.b)) not in known and {pair.a, pair.b} <= set(truth["objects"])
        )
    what = f"{len(truths)} labelled frames, default rule"
    return [
        Row(f"{what}: non-disjoint pairs right, of {wanted}", right / max(wanted, 1), "", bar=">= 0.92"),
        Row(f"{what}: false contacts a scene", false / len(truths), "", bar="<= 0.3"),
    ]


def truth_of(truth: Mapping[str, Any]) -> dict[tuple[str, str], str]:
    """Relations of all pairs of an annotated frame, those left out that its annotator was not sure of."""
    left_out = {frozenset(map(str, pair[:2])) for pair in truth["uncertain_pairs"]}
    told = _told(truth["relations"], left_out)
    known = left_out | {frozenset(pair) for pair in told}
    others = combinations(truth["objects"], 2)
    return told | {pair: "disjoint" for pair in others if frozenset(pair) not in known}


def _sequence(path: Path) -> Row:
    """Frames right of a recording: every pair as told; each frame updates the relations of the one before."""
    truth = json.loads(path.read_text(encoding="utf-8"))
    relations: Relations | None = None
    right = scored = 0
    for number, scene in enumerate(load_sequence(_beside(path)), start=FIRST_FRAME):
        relations = relate(scene) if relations is None else relations.followed(scene)
        interval = next((i for i in truth["intervals"] if i["first"] <= number <= i["last"]), None)
        if interval is None:
            continue
        told = _told(interval["relations"], set())
        known = {frozenset(pair) for pair in told}
        scored += 1
        right += all(_answer(relations, *pair) == relation for pair, relation in told.items()) and all(
            pair.relation is Relation.DISJOINT
            for pair in relations
            if frozenset((pair.a, pair.b)) not in known
        )
    name = path.name.removesuffix(".gt.json")
    return Row(f"{name}: frames right, of {scored}", right / max(scored, 1), "", bar=">= 0.98")


def _told(entries: list[list[Any]], left_out: set[frozenset[str]]) -> dict[tuple[str, str], str]:
    """What a person says of the pairs that are not disjoint."""
    pairs = {(str(a), str(b)): str(relation) for a, b, relation in entries}
    return {pair: relation for pair, relation in pairs.items() if frozenset(pair) not in left_out}


def _answer(relations: Relations, a: str, b: str) -> str | None:
    """What `relate` says of a pair, None where an object is missing."""
    known = a in relations.objects and b in relations.objects
    return str(relations.between(a, b).relation) if known else None


def _beside(truth: Path) -> Path:
    return truth.with_name(truth.name.replace(".gt.json", ".npz"))
