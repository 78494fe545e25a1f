"""The demo says what the loop decides by, and how often it comes off."""

import json
from pathlib import Path

import pytest
from documents import contradictions

from topple.planner.cli.main import main
from topple.planner.execution.demo_seeds import default_seed, seed_count


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("demo")


@pytest.mark.slow
def test_what_is_printed_is_the_order_that_the_first_action_is_of(folder, capfd):
    assert main(["demo", "lemon", "-o", str(folder)]) == 0
    printed = capfd.readouterr().out
    run = json.loads((folder / "run.json").read_text())
    order = json.loads((folder / "order.json").read_text())
    first = run["steps"][0]
    assert contradictions(order, [first["object"]]) == []
    made = json.loads((folder / "plan.json").read_text())
    assert contradictions(made, [step["object"] for step in made["steps"]]) == []
    assert f"decided from the first look: {first['action']} {first['object']}" in printed
    assert printed.startswith(f"lemon, seed {default_seed('lemon')}; {seed_count('lemon')}\n")
