"""Runs with a fixture: it keeps a thing still while others go, and lets go once the hand holds it."""

import pytest
from on_table import balance

from topple.planner.execution.demo import demo
from topple.planner.execution.run import run
from topple.planner.planning.plan_format import plan_from_json


@pytest.mark.slow
def test_one_arm_takes_a_plank_off_that_would_tip(tmp_path):
    record = demo("hold", seed=5, clamped=["plank"], folder=tmp_path)
    assert record.success, record.violations
    assert [step.object for step in record.steps] == ["weight", "load", "plank"]
    assert "keep plank clamped" in record.steps[0].reason
    document = plan_from_json((tmp_path / "plan.json").read_text())
    assert document.clamped == ["plank"] and document.order[-1] == "plank"
    assert "a fixture keeps plank where it stands until it is taken" in document.assumptions


@pytest.mark.slow
def test_without_it_the_plank_tips():
    record = run(balance(), "free plank", "panda")
    assert any(text.startswith("weight: plank fell") for text in record.violations)
    kept = run(balance(), "free plank", "panda", clamped="plank")
    assert not any(text.startswith("weight:") for text in kept.violations), kept.violations
    assert "a fixture keeps plank where it stands until it is taken" in kept.notes


@pytest.mark.slow
def test_mujoco_has_fixtures_as_well():
    pytest.importorskip("mujoco")
    kept = run(balance(), "free plank", "panda", clamped="plank", engine="mujoco")
    assert not any(text.startswith("weight:") for text in kept.violations), kept.violations
