"""The page of one scene: what is where, what depends on what, and the order to take it apart."""

from html import escape
from typing import Any

from topple.planner.report.drawing import Drawing
from topple.planner.report.graph import DrawnGraph, graph_svg
from topple.planner.report.html import page, viewer
from topple.planner.report.matrix import relation_matrix
from topple.planner.report.photo import photo
from topple.planner.report.tables import order_list, relation_table, sentence_list
from topple.planner.report.view import Document, Documented, document, object_index, view_data
from topple.planner.report.words import listed, places, sentences
from topple.topology.photo import Photo
from topple.topology.scene import Scene


def show_page(
    scene: Scene,
    relations: Documented | Document,
    order: Documented | Document | None = None,
    *,
    title: str = "",
) -> str:
    """Draw a scene as one self-contained HTML page.

    Args:
        scene: The scene; `up` may be unknown.
        relations: What `relate` found in it, or the JSON document of that.
        order: What `order` found, or the JSON document of that; None shows the relations alone.
        title: Title of the page; the number of objects where none is given.

    Returns:
        The page: a 3-D view to turn and zoom, the relation table, the dependency graph, the order with its
        reasons, the assumptions. It fetches nothing and stays below some 4 MB.
    """
    found = document(relations)
    planned = None if order is None else document(order)
    drawing = Drawing.of(scene)
    index = object_index(drawing)
    body = _head(scene, planned, title)
    body += '<main class="columns"><div>' + viewer(0, ordered=planned is not None)
    if planned is not None:
        body += dependency_section(scene, drawing, planned)
    body += "</div><div>" + photo_section(scene, drawing, planned)
    if planned is not None:
        body += "<h2>Safe order</h2>" + order_list(planned, index)
    body += "<h2>Relations</h2>" + relation_matrix(found, index) + relation_table(found, index)
    body += sentence_list(_assumptions(scene, order, planned), "Assumptions")
    body += "</div></main>"
    return page(
        title or "topple: what is where",
        body,
        {"views": [view_data(drawing, found, planned)]},
        ["viewer.js", "motion.js", "page.js", "show.js"],
    )


def dependency_section(scene: Scene, drawing: Drawing, order: Document) -> str:
    """The dependency graph under its heading."""
    graph = DrawnGraph.of(scene.movable, order, row=760.0)
    colours = {drawn.name: drawn.colour for drawn in drawing.objects}
    svg = graph_svg(graph, colours, object_index(drawing))
    return f'<h2>Dependency graph</h2><div class="graph-box">{svg}</div>'


def photo_section(scene: Scene, drawing: Drawing, order: Document | None, taken: Photo | None = None) -> str:
    """The photo with its masks in the colours of the drawing; nothing where the scene has none."""
    colours = {drawn.name: drawn.colour for drawn in drawing.objects}
    return photo(scene, colours, object_index(drawing), {} if order is None else places(order), taken)


def _head(scene: Scene, order: Document | None, title: str) -> str:
    points = sum(len(cloud) for cloud in scene.clouds.values())
    facts = [f"{len(scene.names)} objects, {points:,} points"]
    if scene.fixed:
        facts.append(f"fixed: {listed(sorted(scene.fixed))}")
    if scene.up is None:
        facts.append("which way is up is not known, so the view may lie on its side")
    if order is not None:
        targets = [str(name) for name in order.get("targets", ())]
        facts.append(
            f"to free: {listed(targets)}"
            if targets and len(targets) < len(scene.movable)
            else "to clear everything"
        )
    heading = title or f"Scene of {len(scene.names)} objects"
    return f'<header><h1>{escape(heading)}</h1><p class="lead">{escape("; ".join(facts))}.</p></header>'


def _assumptions(scene: Scene, order: Any, planned: Document | None) -> list[str]:
    """What the scene and the order assumed, each once."""
    of_order = None if planned is None else planned.get("assumptions") or getattr(order, "assumptions", None)
    return list(dict.fromkeys([*scene.assumptions, *sentences(of_order)]))
