"""Piles of a second generator: of models and formulas, settled, each with a target that carries something."""

import json
from pathlib import Path

import numpy as np
import pytest

from topple.benchmarks.other_piles import LONGEST, SHAPES, models_in, other_pile
from topple.robots.world.bodies import Body
from topple.topology.base.errors import InvalidInput


def _model(folder: Path, half: float, mass: float) -> None:
    folder.mkdir(parents=True)
    corners = [(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]
    lines = ["o part0", *(f"v {half * x} {0.02 * y} {0.02 * z}" for x, y, z in corners)]
    (folder / "collision.obj").write_text("\n".join(lines) + "\n")
    (folder / "meta.json").write_text(json.dumps({"mass_kg": mass}))


@pytest.mark.parametrize("kind", SHAPES)
def test_a_shape_by_formula_is_a_thing_that_a_hand_holds(kind):
    for seed in range(20):
        body = Body.of(kind, SHAPES[kind](np.random.default_rng(seed)), density=1000.0)
        extents = np.sort(body.upper - body.lower)
        assert 0.01 < extents[0] and extents[2] < LONGEST
        assert 0.002 < body.mass < 1.0


def test_models_that_no_arm_takes_are_left_out(tmp_path):
    _model(tmp_path / "a" / "007_bar", 0.08, 0.2)
    _model(tmp_path / "beam", 0.2, 0.2)
    _model(tmp_path / "anvil", 0.08, 5.0)
    assert [place.name for place in models_in(tmp_path)] == ["007_bar"]
    (tmp_path / "none").mkdir()
    with pytest.raises(InvalidInput, match="no model below"):
        models_in(tmp_path / "none")


def test_a_pile_rests_and_its_target_carries_something(tmp_path):
    _model(tmp_path / "007_bar", 0.08, 0.2)
    poses: list[dict[str, np.ndarray]] = []
    for _ in range(2):
        with other_pile(3, tmp_path) as stage:
            poses.append(stage.world.poses())
            (target,) = stage.targets
            touched = {name for pair in stage.world.contacts() for name in (pair.a, pair.b)}
            assert stage.goal == f"free {target}" and target in touched
            assert 5 <= len(stage.world.movable) <= 9
            assert any(name.startswith("bar_") for name in stage.world.movable)
    for name, pose in poses[0].items():
        assert np.array_equal(pose, poses[1][name])
