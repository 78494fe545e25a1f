"""What a notebook's cell shows of a scene, relations, an order, a plan or a run: the pages, made smaller."""

from collections.abc import Mapping
from html import escape
from typing import TYPE_CHECKING, Any

import numpy as np
from msgspec import to_builtins

from topple.planner.report.drawing import Drawing
from topple.planner.report.graph import DrawnGraph, graph_svg
from topple.planner.report.html import page, viewer
from topple.planner.report.limits import LIMITS
from topple.planner.report.palette import object_colours
from topple.planner.report.run_page import run_page
from topple.planner.report.tables import order_list, relation_table, sentence_list
from topple.planner.report.view import object_index, view_data
from topple.planner.report.words import listed
from topple.topology.geometry.samples import sampled
from topple.topology.scene import Scene

if TYPE_CHECKING:
    from topple.planner.decide.arrange import Order
    from topple.planner.formats.plan_format import Plan
    from topple.planner.formats.plan_structs import Step
    from topple.planner.formats.run_record import RunRecord
    from topple.topology.relations import Relations

_SCRIPTS = ("viewer.js", "page.js", "show.js")
_NONE: Mapping[str, Any] = {"relations": ()}
_SPACING = 0.004  # [m] of points on the parts of a plan's objects
_TALL, _LOW = 560, 360  # [px] of a cell with a view, and of one without


def scene_cell(scene: Scene) -> str:
    """The surfaces of a scene, to turn and zoom; nothing is related for it."""
    drawing = Drawing.of(scene, LIMITS.cell_points)
    facts = [f"{len(scene.movable)} objects"]
    facts += [f"fixed: {listed(sorted(scene.fixed))}"] if scene.fixed else []
    facts += [] if scene.up is not None else ["up is not known"]
    body = _lead("; ".join(facts)) + viewer(0, ordered=False)
    return _cell("Scene", body + sentence_list(scene.assumptions, "Assumptions"), drawing, _NONE)


def relations_cell(relations: "Relations") -> str:
    """The scene with a line per relation, and the table beside it."""
    drawing, found = Drawing.of(relations.scene, LIMITS.cell_points), relations.to_json()
    table = relation_table(found, object_index(drawing))
    return _cell("Relations", _columns(viewer(0, ordered=False), table), drawing, found)


def order_cell(order: "Order") -> str:
    """The dependency graph, and the order with its reasons; an order has no clouds to show."""
    found = order.to_json()
    names = order.graph.names
    svg = graph_svg(DrawnGraph.of(names, found, row=560.0), object_colours(names), {})
    graph = f'<div class="graph-box">{svg}</div>'
    words = order_list(found, {}) + sentence_list(order.assumptions, "Assumptions")
    return _framed(page("Order", _columns(graph, words), {}, (), compact=True), _LOW)


def plan_cell(plan: "Plan") -> str:
    """What the plan took the objects for, the way of the tool, and its steps."""
    clouds = {
        thing.name: sampled([np.asarray(part) for part in thing.whole or thing.parts], _SPACING)
        for thing in plan.objects
    }
    facts = f"{plan.goal} with {plan.robot}: {len(plan.steps)} steps, {plan.seconds:.0f} s of motion"
    lead = _lead(f"{facts}, {'all' if plan.certified else 'not all'} proven free between samples")
    steps = f'<ol class="order">{"".join(map(_step, plan.steps))}</ol>'
    words = steps + sentence_list(plan.assumptions, "Assumptions")
    if not clouds:
        return _framed(page("Plan", lead + words, {}, (), compact=True), _LOW)
    scene = Scene(clouds, [thing.name for thing in plan.objects if thing.fixed], plan.up)
    drawing = Drawing.of(scene, LIMITS.cell_points)
    order = {"order": plan.order, "dependencies": to_builtins(plan.dependencies)}
    body = lead + _columns(viewer(0, ordered=True), words)
    return _cell("Plan", body, drawing, _NONE, order)


def run_cell(record: "RunRecord") -> str:
    """The page of a run without its pictures, which would make a notebook of a hundred megabytes."""
    return _framed(run_page(record, points=2 * LIMITS.cell_points, photos=False, compact=True), _TALL)


def _step(step: "Step") -> str:
    place, width = step.placement, f"{1e3 * step.grasp.width:.0f}"
    where = f", {place.words}" if place.into or place.how else ""
    return (
        f"<li><b>{escape(step.action)} {escape(step.object)}</b>{escape(where)}: {escape(step.reason)} "
        f'<span class="kind">{escape(step.grasp.kind)}, pads {width} mm apart</span></li>'
    )


def _lead(text: str) -> str:
    return f'<p class="lead">{escape(text)}.</p>'


def _columns(left: str, right: str) -> str:
    return f'<main class="columns"><div>{left}</div><div>{right}</div></main>'


def _cell(
    title: str,
    body: str,
    drawing: Drawing,
    relations: Mapping[str, Any],
    order: Mapping[str, Any] | None = None,
) -> str:
    """A page with one view, framed."""
    views = {"views": [view_data(drawing, relations, order)]}
    return _framed(page(title, body, views, _SCRIPTS, compact=True), _TALL)


def _framed(html: str, height: int) -> str:
    """A page in a frame of its own, so that its styles and scripts stay out of the notebook."""
    return (
        f'<iframe srcdoc="{escape(html)}" sandbox="allow-scripts" loading="lazy" '
        f'style="width:100%;height:{height}px;border:0;resize:vertical;overflow:auto"></iframe>'
    )
