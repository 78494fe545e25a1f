"""What a notebook's cell shows of a scene, relations, an order, a plan or a run: the pages, made smaller."""

from html import escape
from typing import TYPE_CHECKING

import numpy as np

from topple.planner.decide.names import rename, spoken
from topple.planner.report.drawing import Drawing, view_data
from topple.planner.report.graph import DrawnGraph, graph_box
from topple.planner.report.html import columns, page, view_page
from topple.planner.report.limits import LIMITS
from topple.planner.report.palette import object_colours
from topple.planner.report.plan_page import order_of, step_list
from topple.planner.report.run_page import run_page
from topple.planner.report.tables import order_list, relation_table, sentence_list
from topple.topology.geometry.samples import sample
from topple.topology.scene.scene import Scene

if TYPE_CHECKING:
    from topple.planner.decide.arrange import Order
    from topple.planner.formats.run_record import RunRecord
    from topple.planner.planning.plan_format import Plan
    from topple.topology.relations.relate import Relations

TALL, LOW = 560, 360  # [px] of a cell with a view, and of one without


def scene_cell(scene: Scene) -> str:
    """The surfaces of a scene, to turn and zoom; nothing is related for it."""
    scene = spoken(scene, scene)
    objects, fixed, size, *_ = str(scene).splitlines()
    view = view_data(Drawing.of(scene, LIMITS.cell_points), {}, None)
    below = sentence_list(scene.assumptions, "Assumptions")
    return _frame(view_page("Scene", _lead(f"{objects}; {fixed}; {size}"), view, (below, ""), compact=True))


def relations_cell(relations: "Relations") -> str:
    """The scene with a line per relation, and the table beside it."""
    scene, found = spoken(relations.scene, (relations.scene, relations.to_json()))
    drawing = Drawing.of(scene, LIMITS.cell_points)
    sides = "", relation_table(found, drawing.index)
    return _frame(view_page("Relations", "", view_data(drawing, found, None), sides, compact=True))


def order_cell(order: "Order") -> str:
    """The dependency graph, and the order with its reasons; an order has no clouds to show."""
    found, names = rename((order.to_json(), order.graph.names), order.called)
    graph = graph_box(DrawnGraph.of(names, found, row=560.0), object_colours(names), {})
    words = order_list(found, {}) + sentence_list(order.assumptions, "Assumptions")
    return _frame(page("Order", columns(graph, words), {}, (), compact=True), LOW)


def plan_cell(plan: "Plan") -> str:
    """Show a plan in a notebook: the bodies it assumed, the way of the tool, and its steps."""
    clouds = {
        thing.name: sample([np.asarray(part) for part in thing.whole or thing.parts], LIMITS.parts)
        for thing in plan.objects
    }
    lead = _lead("; ".join(plan.heading()))
    order = order_of(plan)
    if not clouds:
        words = step_list(plan, order, {}) + sentence_list(plan.assumptions, "Assumptions")
        return _frame(page("Plan", lead + words, {}, (), compact=True), LOW)
    scene = Scene(clouds, [thing.name for thing in plan.objects if thing.fixed], plan.up)
    drawing = Drawing.of(scene, LIMITS.cell_points)
    words = step_list(plan, order, drawing.index) + sentence_list(plan.assumptions, "Assumptions")
    return _frame(view_page("Plan", lead, view_data(drawing, {}, order), ("", words), compact=True))


def run_cell(record: "RunRecord") -> str:
    """The page of a run without its pictures, which would make a notebook of a hundred megabytes."""
    return _frame(run_page(record, points=2 * LIMITS.cell_points, photos=False, compact=True))


def _lead(text: str) -> str:
    return f'<p class="lead">{escape(text)}.</p>'


def _frame(html: str, height: int = TALL) -> str:
    """A page in a frame of its own, so that its styles and scripts stay out of the notebook."""
    return (
        f'<iframe srcdoc="{escape(html)}" sandbox="allow-scripts" loading="lazy" '
        f'style="width:100%;height:{height}px;border:0;resize:vertical;overflow:auto"></iframe>'
    )
