"""Assemblies of others are told as their own equilibrium says, whole and without each block."""

import json
from typing import Any

import numpy as np
import pytest

from topple.benchmarks.assemblies import rows, stands
from topple.benchmarks.towers import CUBE, FACES
from topple.topology import InvalidInput


def block(x: float, z: float, size: tuple[float, float, float] = (1.0, 1.0, 1.0)) -> dict[str, Any]:
    vertices = CUBE * size + [x, 0.0, z]
    volume = float(np.prod(size))
    return {"vertices": vertices.tolist(), "faces": FACES.tolist(), "volume": volume, "centre": [x, 0, z]}


LINTEL = {
    "friction": 0.84,
    "fixed": ["ground"],
    "blocks": {
        "ground": block(0.0, -0.5, (6.0, 1.0, 1.0)),
        "left": block(-1.0, 0.5),
        "right": block(1.0, 0.5),
        "lintel": block(0.0, 1.25, (3.0, 1.0, 0.5)),
    },
    "stands": True,
    "without": {"left": False, "right": False, "lintel": True},
    "seconds": {"whole": 0.01},
}


def test_a_lintel_needs_both_of_its_posts():
    assert stands(LINTEL)
    assert stands(LINTEL, "lintel")
    assert not stands(LINTEL, "left")


def test_verdicts_that_differ_from_the_peer_are_named(tmp_path):
    (tmp_path / "lintel.json").write_text(json.dumps(LINTEL))
    (tmp_path / "other.json").write_text(
        json.dumps({**LINTEL, "stands": False, "without": {"left": True, "right": None}})
    )
    whole, removals = rows(False, 0, lambda _: None, tmp_path)
    assert (whole["held"], whole["tried"], whole["wrong"], whole["ok"]) == (1, 2, ["other"], False)
    assert (removals["held"], removals["tried"]) == (3, 4)
    assert removals["wrong"] == ["other without left"]


def test_an_empty_folder_is_refused(tmp_path):
    with pytest.raises(InvalidInput, match="assemblies need --data DIR"):
        rows(False, 0, lambda _: None, tmp_path)
