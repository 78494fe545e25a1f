"""The facts of a scene as PDDL: a planner of another project finds the safe order, and other goals."""

import io
import json

import numpy as np
import pytest
from on_table import on_table
from solving import solved

from topple.planner import order
from topple.planner.cli.main import main
from topple.planner.export.scene_pddl import scene_pddl
from topple.robots import shapes
from topple.topology import InvalidInput, Scene

pytestmark = pytest.mark.filterwarnings("ignore:.*deprecated")  # how unified-planning calls pyparsing


@pytest.fixture(scope="module")
def scene() -> Scene:
    """A ball in a bowl, and a block on a box."""
    return on_table(
        (shapes.bowl("Bowl 1"), (0.0, 0.0, 0.0)),
        (shapes.ball("ball", diameter=0.04), (0.0, 0.0, 0.006)),
        (shapes.box("box", (0.06, 0.06, 0.06)), (0.0, 0.25, 0.0)),
        (shapes.block("block", 0.04), (0.0, 0.25, 0.06)),
    )


def test_the_facts_are_those_of_the_scene(scene):
    _, problem = scene_pddl(order(scene).to_json())
    init = problem[problem.index("(:init") : problem.index("(:goal")]
    for fact in ("(on o-block o-box)", "(in o-ball o-bowl-1)", "(before o-block o-box)", "(clear o-ball)"):
        assert fact in init
    assert "(clear o-box)" not in init and "(movable o-table)" not in init
    assert init.count("(before ") == 2


def test_another_planner_finds_the_safe_order(scene):
    steps = solved(*scene_pddl(order(scene, "Bowl 1").to_json()))
    assert [step for step in steps if step.startswith("take")] == ["take(o-ball)", "take(o-bowl-1)"]
    assert steps[-1] == "put-aside(o-bowl-1)"


def test_another_goal_is_reached_over_what_is_in_the_way(scene):
    domain, problem = scene_pddl(order(scene, "box").to_json())
    goal = problem.replace("(aside o-box)", "(in o-box o-bowl-1) (on o-ball o-block)")
    steps = solved(domain, goal)
    assert steps.index("take(o-block)") < steps.index("take(o-box)") < steps.index("put-in(o-box, o-bowl-1)")
    assert steps.index("take(o-ball)") < steps.index("put-in(o-box, o-bowl-1)"), "the bowl is cleared first"
    assert "put-on(o-ball, o-block)" in steps


def test_the_command_exports_the_order_it_printed(scene, tmp_path, capsys, typed, monkeypatch):
    np.savez(tmp_path / "scene.npz", **scene.clouds, fixed=["table"], up=[0, 0, 1])
    printed = typed("order", tmp_path / "scene.npz", "--target", "box", "--json").out
    assert main(["export", "nowhere.json", "--to", "pddl"]) == 2
    capsys.readouterr()
    (tmp_path / "order.json").write_text(printed)
    assert main(["export", str(tmp_path / "order.json"), "--to", "pddl", "-o", str(tmp_path)]) == 0
    made = tuple((tmp_path / f"{name}.pddl").read_text() for name in ("domain", "problem"))
    assert made == scene_pddl(json.loads(printed))
    capsys.readouterr()
    monkeypatch.setattr("sys.stdin", io.TextIOWrapper(io.BytesIO(printed.encode())))
    assert typed("export", "-", "--to", "pddl").out.strip() == "\n;; problem\n".join(made).strip()


def test_what_is_no_order_is_refused():
    with pytest.raises(InvalidInput, match="this is no order"):
        scene_pddl({"format": "topple.order", "dependencies": [{"first": "a"}]})
