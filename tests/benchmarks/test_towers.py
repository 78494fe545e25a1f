"""Files of towers are read as arrays alone, and what is counted of them is what their blocks do."""

import pickle
from pathlib import Path

import numpy as np
import pytest

from topple.benchmarks.towers import FILES, rows, towers
from topple.topology import InvalidInput


class Harm:
    def __reduce__(self) -> tuple[object, tuple[str]]:
        return eval, ("open('harmed', 'w')",)


def tower(aside: float, centre: float) -> np.ndarray:
    """Two cubes of 10 cm, the upper one aside and with its centre of mass aside of its middle [m]."""
    blocks = np.zeros((2, 17))
    blocks[:, 0], blocks[:, 4:7], blocks[:, 13] = 0.5, 0.1, 1.0
    blocks[:, 9] = 0.05, 0.15
    blocks[1, [1, 7]] = centre, aside
    return blocks


def test_towers_with_their_true_centres_are_told_as_statics_tells_them(tmp_path):
    some = np.stack([tower(0.03, 0.0), tower(0.06, 0.0), tower(0.03, 0.03), tower(0.06, -0.02)])
    labels = np.array([True, False, False, True])
    for name in FILES:
        path = tmp_path / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(pickle.dumps({"2block": {"towers": some, "labels": labels}}))
    found = rows(False, 0, lambda _: None, tmp_path)
    assert [row["held"] for row in found] == [4, 2, 4, 2]
    assert found[0]["baseline_value"] == 100
    assert found[0]["ok"]


def test_a_pickle_that_asks_for_more_than_arrays_is_refused(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    path = tmp_path / "a.pkl"
    path.write_bytes(pickle.dumps({"2block": {"towers": Harm(), "labels": []}}))
    with pytest.raises(InvalidInput, match="expected arrays of numpy alone"):
        list(towers(path))
    assert not Path("harmed").exists()
    with pytest.raises(InvalidInput, match="towers need --data DIR"):
        rows(True, 0, lambda _: None)
