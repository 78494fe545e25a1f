"""What a notebook's cell shows: each page in a frame of its own, small, and complete."""

import re
import subprocess
import sys
from html import unescape

import pytest

from topple.planner.formats.plan_structs import DependencyData, ObjectData
from topple.planner.formats.run_record import RunRecord, StepRecord
from topple.planner.planning.order import order
from topple.planner.planning.plan_format import Plan
from topple.topology import Scene
from topple.topology.relations.relate import relate

MOST = 700_000  # characters: fifty such cells are a notebook of 35 MB


def framed(thing) -> str:
    """The page in the frame of a cell."""
    html = thing._repr_html_()
    assert html.startswith('<iframe srcdoc="') and html.endswith("</iframe>") and len(html) < MOST
    (page,) = re.findall(r'srcdoc="([^"]*)"', html)  # nothing in it ends the attribute
    return unescape(page)


@pytest.fixture(scope="module")
def plan() -> Plan:
    cube = [[x, y, z] for x in (0.0, 0.1) for y in (0.0, 0.1) for z in (0.0, 0.1)]
    high = [[x, y, z + 0.1] for x, y, z in cube]
    flat = [[x, y, z] for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (-0.02, 0.0)]
    return Plan(
        goal="free <box>",
        robot="panda",
        joints=["a"],
        seed=0,
        pose_base_to_world=[[1.0, 0, 0, 0], [0, 1.0, 0, 0], [0, 0, 1.0, 0], [0, 0, 0, 1.0]],
        base_searched=False,
        q_start=[0.0],
        order=["can", "<box>"],
        dependencies=[DependencyData("can", "<box>", "supported", 0.9)],
        steps=[],
        objects=[
            ObjectData("<box>", False, [cube]),
            ObjectData("can", False, [high]),
            ObjectData("table", True, [flat]),
        ],
        assumptions=["weights are guessed"],
    )


def test_a_scene_is_its_clouds_and_nothing_is_related_for_it(stack):
    page = framed(stack[0])
    assert "<canvas" in page and "; fixed: table; " in page
    assert '"relations":[]' in page


def test_relations_come_with_their_scene_and_their_table(stack):
    page = framed(stack[1])
    assert "<canvas" in page and "Rows read “A relation B”" in page
    assert '"relation":"touch"' in page


def test_an_order_is_its_graph_and_its_reasons(stack):
    page = framed(stack[2])
    assert "<svg" in page and '<ol class="order">' in page and "this is a target" in page
    assert "<script>\n\n</script>" in page  # no view, nothing to run


def test_a_plan_shows_its_objects_and_its_dependencies(plan):
    page = framed(plan)
    assert "free &lt;box&gt;, " in page and "<box>" not in page
    assert "<canvas" in page and "weights are guessed" in page
    assert "can rests on it" in page


def test_a_run_shows_its_steps_and_leaves_its_pictures_out(stack):
    scene, relations, found = stack
    step = StepRecord(
        "tin", "remove", True, picture_before=b"\x89PNG" * 500_000, scene=scene, relations=relations.to_json()
    )
    page = framed(RunRecord("free crate", "panda", 0, True, (), (step,), scene=scene, order=found.to_json()))
    assert "Step 1 of 1: remove tin" in page and '"pictures":[]' in page


def test_cells_follow_light_and_dark(stack):
    for thing in stack:
        page = framed(thing)
        assert "prefers-color-scheme: dark" in page and "<body class=cell>" in page


def test_a_scene_that_cannot_be_drawn_falls_back_to_its_text():
    class Sketch(Scene):
        """Of a type that nothing draws."""

    assert Sketch({"dot": [[0.0, 0, 0], [0.01, 0, 0]]})._repr_html_() is None


def test_scenes_of_one_point_and_of_a_line_are_drawn():
    for points in ([[0.0, 0, 0]], [[0.0, 0, 0], [0.1, 0, 0]]):
        scene = Scene({"dot": points})
        assert "<canvas" in framed(scene)


def test_a_notebook_costs_nothing_until_a_cell_shows_something():
    code = "import sys, topple; topple.Scene; print('topple.planner.report.notebook' in sys.modules)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout == "False\n"


def test_what_order_gives_shows_itself():
    scene = Scene({"a": [[0.0, 0, 0], [0.1, 0, 0], [0, 0.1, 0], [0, 0, 0.1]]}, up=[0, 0, 1])
    relations = relate(scene)
    assert "<canvas" in framed(relations)
    assert "<svg" in framed(order(scene, relations=relations))
