"""Plans of real camera frames hold their own check, placements included."""

from pathlib import Path

import pytest

from topple.planner.planning.plan import plan
from topple.topology.io import load_scene

DATA = Path(__file__).resolve().parents[3].parent / "shared" / "data" / "rgbd"


@pytest.mark.skipif(not DATA.is_dir(), reason="../shared/data/rgbd, published camera frames, is absent")
def test_a_carton_whose_foot_was_seen_ragged_is_put_down_so_that_it_stands():
    scene = load_scene(DATA / "osd_test43.npz", fixed=["1"])
    found = plan(scene, ["4"], "panda-suction")
    checked = found.verify(scene)
    assert found.order == ["4"]
    assert checked.ok, checked.failed
    assert not found.steps[0].placement.falls and checked.allowed == ()
