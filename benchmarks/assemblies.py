"""Assemblies of others: `topple check` against rigid block equilibrium, whole and without each block.

The samples of compas-cra 0.8 (MIT), arches, shelves of books, what is wedged and a shell of 399 stones, are
prepared and judged by it in an environment of its own:

    python3.11 -m venv .peers/assemblies
    .peers/assemblies/bin/pip install compas-cra==0.8.0
    .peers/assemblies/bin/python benchmarks/peers/compas_assemblies.py DIR

`--data DIR` reads what that writes. The peer is given the faces that blocks share and looks for forces on
their corners that only push; `topple check` is given the meshes, at a tenth of their size: statics knows
no size, and objects are shorter than 2 m.
"""

import json
import time
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from topple.benchmarks.row import Progress, Row
from topple.planner.stability.check import check
from topple.topology.base.errors import InvalidInput
from topple.topology.scene.mesh import Mesh
from topple.topology.scene.scene import Scene

SCALE = 0.1
LARGE = 100
"""Blocks from which an assembly has a row of its own for its time."""


def as_scene(document: Mapping[str, Any], without: str | None = None) -> Scene:
    """An assembly as a scene of meshes, with or without one block."""
    blocks = {name: block for name, block in document["blocks"].items() if name != without}
    meshes = {
        name: Mesh(SCALE * np.asarray(block["vertices"], np.float64), np.asarray(block["faces"]))
        for name, block in blocks.items()
    }
    free = [name for name in blocks if name not in document["fixed"]]
    return Scene(
        {name: mesh.vertices for name, mesh in meshes.items()},
        document["fixed"],
        (0, 0, 1),
        meshes=meshes,
        masses={name: blocks[name]["volume"] for name in free},  # [kg] at 1,000 kg/m3
        centres={name: SCALE * np.asarray(blocks[name]["centre"]) for name in free},
        friction={name: float(document["friction"]) ** 0.5 for name in blocks},  # of two it is the product
    )


def stands(document: Mapping[str, Any], without: str | None = None) -> bool:
    """Whether an assembly stands by `topple check`, with or without one block."""
    scene = as_scene(document, without)
    return not scene.movable or check(scene, margins=False).stands


def rows(quick: bool, seed: int, progress: Progress, data: Path | None = None) -> list[dict[str, Any]]:
    """Measure.

    Args:
        quick: None of the large ones.
        seed: Nothing hangs on it.
        progress: Called before each assembly.
        data: The folder that `compas_assemblies.py` wrote.

    Raises:
        InvalidInput: Nothing of it is there.
    """
    found = [] if data is None else [(p.stem, json.loads(p.read_text())) for p in sorted(data.glob("*.json"))]
    if not found:
        raise InvalidInput(
            "assemblies need --data DIR: the folder that benchmarks/peers/compas_assemblies.py writes"
        )
    wholes: dict[str, bool] = {}
    removals: dict[str, bool] = {}
    timed: list[Row] = []
    for name, document in found:
        if quick and len(document["blocks"]) > LARGE:
            continue
        progress(name)
        begun = time.process_time()
        whole = stands(document)
        seconds = time.process_time() - begun
        if document["stands"] is not None:
            wholes[name] = whole == document["stands"]
        for block, peer in document["without"].items():
            if peer is not None:
                removals[f"{name} without {block}"] = stands(document, block) == peer
        if len(document["blocks"]) > LARGE:
            what = f"check of {name}, {len(document['blocks'])} blocks"
            timed.append(Row(what, seconds, "s", "the peer", document["seconds"]["whole"], bar="<= 10"))
    shares = [
        _row("assemblies that stand or not as rigid block equilibrium says", wholes),
        _row("the same without one block", removals),
    ]
    return [row.to_json() for row in (*shares, *timed)]


def _row(what: str, agreeing: Mapping[str, bool]) -> Row:
    wrong = tuple(name for name, same in agreeing.items() if not same)
    held = len(agreeing) - len(wrong)
    share = 100 * held / max(len(agreeing), 1)
    return Row(what, share, "%", bar="100", tried=len(agreeing), held=held, wrong=wrong)
