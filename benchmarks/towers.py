"""Towers of others: `topple check` against the labels of 12,000 towers of blocks, and plain statics.

Blocks of Learning-and-Intelligent-Systems/stacking on GitHub (no licence file, so nothing of it is here; a
checkout is given as `--data DIR`): box, mass, centre of mass and pose of each of 2 to 5 blocks, stacked with
their sides parallel, and whether the tower can be built so. The peer is what they were labelled by: all that
is above a face has its common centre of mass over it; the labels ask that of a tower as it grows, too, which
neither says. Pickles are read by a loader that makes arrays and nothing else.
"""

import pickle
from collections import Counter
from collections.abc import Iterator, Mapping
from dataclasses import replace
from importlib import import_module
from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from topple.benchmarks.row import Progress, Row
from topple.planner.stability.check import check
from topple.robots.collision.convex import hull_of
from topple.topology.base.arrays import FloatArray
from topple.topology.base.errors import InvalidInput
from topple.topology.io.limits import read_bytes
from topple.topology.scene.mesh import Mesh
from topple.topology.scene.scene import Scene

FILES = ("learning/data/random_blocks_(x2000).pkl", "learning/data/10block_set_(x1000).pkl")
SAMPLED = 25
"""With --quick every so-many tower counts."""
MASS, CENTRE, SIZE, PLACE, TURN = 0, slice(1, 4), slice(4, 7), slice(7, 10), slice(10, 14)
"""Columns of a block: mass [kg], centre of mass beside its middle, box, place of it [m], quaternion."""
ARRAYS = {("numpy", "ndarray"), ("numpy", "dtype"), ("numpy._core.multiarray", "_reconstruct")}
CUBE = np.array([[x, y, z] for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (-0.5, 0.5)])
FACES = hull_of(CUBE)[1]
TABLE = Mesh(CUBE * [4, 4, 0.04] - [0, 0, 0.02], FACES)


class _Arrays(pickle.Unpickler):
    """Makes arrays, and refuses whatever else a pickle asks for."""

    def find_class(self, module_name: str, global_name: str, /) -> Any:
        module = module_name.replace("numpy.core", "numpy._core")  # as numpy 1 wrote it
        if (module, global_name) not in ARRAYS:
            raise InvalidInput(f"it asks for {module}.{global_name}: expected arrays of numpy alone")
        return getattr(import_module(module), global_name)


def towers(path: Path) -> Iterator[tuple[FloatArray, bool]]:
    """The towers of a file, (blocks, columns), the lowest first, and whether each stands.

    Args:
        path: A pickle of {"3block": {"towers": (N, 3, columns), "labels": (N,)}, ...}.

    Raises:
        InvalidInput: It is none, or asks for more than arrays.
    """
    try:
        groups = _Arrays(BytesIO(read_bytes(path, path.name))).load()
        found = [
            (np.asarray(g["towers"], np.float64), np.asarray(g["labels"], bool)) for g in groups.values()
        ]
    except (pickle.UnpicklingError, EOFError, KeyError, TypeError, ValueError, AttributeError) as error:
        raise InvalidInput(f"{path.name} is no file of towers: {type(error).__name__}") from error
    for some, labels in found:
        yield from zip(some, labels.tolist(), strict=True)


def as_scene(tower: FloatArray, centres: bool) -> Scene:
    """A tower on a table, with the true centres of mass or without."""
    meshes = {"table": TABLE}
    turns = Rotation.from_quat(tower[:, TURN])
    known = dict(zip(names := [f"block_{k}" for k in range(len(tower))], _centres(tower), strict=True))
    for name, row, turn in zip(names, tower, turns, strict=True):
        meshes[name] = Mesh(turn.apply(CUBE * row[SIZE]) + row[PLACE], FACES)
    masses = {f"block_{k}": float(row[MASS]) for k, row in enumerate(tower)}
    clouds = {name: mesh.vertices for name, mesh in meshes.items()}
    return Scene(clouds, ["table"], (0, 0, 1), meshes=meshes, masses=masses, centres=known if centres else {})


def _centres(tower: FloatArray) -> FloatArray:
    """(blocks, 3) centres of mass [m]."""
    return np.asarray(tower[:, PLACE] + Rotation.from_quat(tower[:, TURN]).apply(tower[:, CENTRE]))


def statics(tower: FloatArray) -> bool:
    """Whether everything above each face has its common centre of mass over it: plain rigid statics."""
    centres, masses, places = _centres(tower)[:, :2], tower[:, MASS], tower[:, PLACE][:, :2]
    half = np.abs(np.einsum("nij,nj->ni", Rotation.from_quat(tower[:, TURN]).as_matrix(), tower[:, SIZE])) / 2
    low, high = places - half[:, :2], places + half[:, :2]
    for k in range(1, len(tower)):
        middle = masses[k:] @ centres[k:] / masses[k:].sum()
        if (middle < low[k - 1 : k + 1]).any() or (middle > high[k - 1 : k + 1]).any():
            return False
    return True


def rows(quick: bool, seed: int, progress: Progress, data: Path | None = None) -> list[dict[str, Any]]:
    """Measure.

    Args:
        quick: One tower of 25 alone.
        seed: Which ones.
        progress: Called before each part.
        data: A checkout of the towers.

    Raises:
        InvalidInput: Nothing of it is there.
    """
    if data is None:
        raise InvalidInput(
            "towers need --data DIR: a checkout of Learning-and-Intelligent-Systems/stacking from GitHub"
        )
    found: list[dict[str, Any]] = []
    for file in FILES:
        right: Counter[str] = Counter()
        some = list(towers(data / file))[seed % SAMPLED if quick else 0 :: SAMPLED if quick else 1]
        for number, (tower, label) in enumerate(some):
            if number % 100 == 0:
                progress(f"{Path(file).stem}: {number} of {len(some)}")
            right["centres"] += check(as_scene(tower, True), margins=False).stands == label
            right["masses"] += check(as_scene(tower, False), margins=False).stands == label
            right["statics"] += statics(tower) == label
        found += _rows(Path(file).stem, right, len(some))
    return found


def _rows(name: str, right: Mapping[str, int], tried: int) -> list[dict[str, Any]]:
    share = {key: 100 * count / tried for key, count in right.items()}
    least = f">= {max(share['statics'] - 1, 0.0):.1f}"
    told = {"centres": "true centres of mass", "masses": "masses alone"}
    peer: dict[str, Any] = {"baseline": "plain statics", "baseline_value": share["statics"], "bar": least}
    counted = {
        key: Row(f"{name}: {told[key]}", share[key], "%", tried=tried, held=right[key]) for key in told
    }
    return [replace(counted["centres"], **peer).to_json(), counted["masses"].to_json()]
