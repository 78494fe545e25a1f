"""Scenes that do not quite stand do after shifts of millimetres, and what is beyond help is said."""

import json

import numpy as np
import pytest

from topple.benchmarks.check import cases
from topple.planner.cli.main import main
from topple.planner.stability.check import check
from topple.planner.stability.mend import mend
from topple.topology import InvalidInput, Scene

MENDED = {"floats by 2 mm", "2 mm deep", "centre 2 mm beyond the edge"}
NOT = {"floats by 20 mm", "10 mm deep", "block on too steep a slope", "leaning past the friction cone"}


def test_small_faults_are_mended_by_as_much_and_large_ones_are_told():
    seen = set[str]()
    for case in cases("blocks", 2, 1):
        if case.spoil not in MENDED | NOT:
            continue
        seen.add(case.spoil)
        found = mend(case.scene)
        if case.spoil in MENDED:
            assert not found.left, f"{case.spoil}: {found.left}"
            assert check(found.scene, margins=False).stands
            assert set(found.shifts) == {"odd"}
            assert float(np.linalg.norm(found.shifts["odd"])) == pytest.approx(0.002, abs=0.0008)
        else:
            assert "odd" in found.left, case.spoil
            assert not found.shifts
    assert seen == MENDED | NOT


def test_the_command_writes_poses(tmp_path, typed):
    grid = np.stack(np.meshgrid(np.arange(-0.2, 0.2, 0.005), np.arange(-0.2, 0.2, 0.005), 0.0), -1)
    cube = np.random.default_rng(0).uniform(-0.5, 0.5, (6000, 3))
    cube[np.arange(6000), np.arange(6000) % 3] = np.sign(cube[np.arange(6000), np.arange(6000) % 3]) * 0.5
    block = cube * 0.08 + np.array([0, 0, 0.0445])
    Scene({"table": grid.reshape(-1, 3), "block": block}, ["table"], (0, 0, 1)).save(tmp_path / "scene.npz")
    arguments = [str(tmp_path / "scene.npz"), "--mend", str(tmp_path / "mended.json")]
    assert main(["check", *arguments[:1], "--no-margins"]) == 1
    assert "block 4.5 mm moved" in typed("check", *arguments).out
    written = json.loads((tmp_path / "mended.json").read_text())
    assert written["stands"]
    assert written["poses"]["block"][2][3] == pytest.approx(-0.0045, abs=2e-4)
    assert main(["check", arguments[0], arguments[0], *arguments[1:]]) == 2


def test_what_cameras_saw_is_not_mended():
    with pytest.raises(InvalidInput, match="cameras saw"):
        mend(Scene({"a": np.random.default_rng(0).random((50, 3))}, up=(0, 0, 1), viewpoints=[(0, 0, 2)]))
