"""The page of one scene: what is where, what depends on what, and the order to take it apart."""

from html import escape

from topple.planner.decide.names import spoken
from topple.planner.decide.words import order_in_words, phrase, sentences
from topple.planner.report.drawing import Document, Documented, Drawing, document, view_data
from topple.planner.report.graph import DrawnGraph, graph_box
from topple.planner.report.html import fold, glance, view_page
from topple.planner.report.photo import photo
from topple.planner.report.tables import order_list, relation_matrix, relation_table, sentence_list
from topple.topology.base.arguments import checked_arguments
from topple.topology.base.errors import ToppleError
from topple.topology.scene.scene import Scene
from topple.topology.situation.situation import Situation


@checked_arguments
def show_page(
    scene: Scene,
    relations: Documented | Document,
    order: Documented | Document | None = None,
    *,
    title: str = "",
) -> str:
    """Draw a scene as one self-contained HTML page: 3-D view, photo, graph, order, relations.

    Args:
        scene: The scene; `up` may be unknown.
        relations: What `relate` found in it, or the JSON document of that.
        order: What `order` found, or the JSON document of that; None shows the relations alone.
        title: Title of the page; the number of objects where none is given.

    Examples:
        >>> "Take cup first" in show_page(scene, relate(scene), order(scene, "book"))
        True
    """
    both = document(relations), None if order is None else document(order)
    scene, (found, planned) = spoken(scene, (scene, both))
    planned = None if planned is None else with_look(scene, planned)
    drawing = Drawing.of(scene)
    head, beneath = _head(scene, planned, title), photo(scene, drawing, planned)
    if planned is not None:
        words = "<h2>Safe order</h2>" + order_list(planned, drawing.index)
        head += glance(beneath, words, dependency_section(scene, drawing, planned))
        beneath = ""
    right = beneath + "<h2>Relations</h2>" + relation_matrix(found, drawing.index)
    right += fold("Every relation with its evidence", relation_table(found, drawing.index))
    right += sentence_list(_assumptions(scene, planned), "Assumptions")
    view = view_data(drawing, found, planned)
    return view_page(title or "topple: what is where", head, view, ("", right))


def with_look(scene: Scene, order: Document) -> Document:
    """The document of an order with the side from which a next look would decide, where there is one."""
    if "next_view" in order or order.get("build") or scene.up is None or not len(scene.viewpoints):
        return order
    from topple.planner.planning.next_view import with_next_view

    try:
        told = with_next_view(Situation.of(scene), order["targets"])
    except ToppleError:  # of what was seen no order can be made anew
        return order
    view = {"next_view": told["next_view"]} if told["next_view"] else {}
    return {**order, "risk": order.get("risk") or told["risk"], **view}


def dependency_section(scene: Scene, drawing: Drawing, order: Document) -> str:
    """The dependency graph under its heading."""
    graph = DrawnGraph.of(scene.movable, order, row=760.0)
    return f"<h2>Dependency graph</h2>{graph_box(graph, drawing.colours, drawing.index)}"


def _head(scene: Scene, order: Document | None, title: str) -> str:
    facts = [f"{len(scene.names)} objects"]
    if scene.fixed:
        facts.append(f"fixed: {phrase(sorted(scene.fixed))}")
    if scene.up is None:
        facts.append("which way is up is not known, so the view may lie on its side")
    if order is not None:
        targets = [str(name) for name in order.get("targets", ())]
        some = targets and len(targets) < len(scene.movable)
        facts.append(f"to free: {phrase(targets)}" if some else "to clear everything")
    heading = _verdict(order) or title or f"Scene of {len(scene.names)} objects"
    facts[:0] = [title] if title and heading != title else []
    return f'<header><h1>{escape(heading)}</h1><p class="lead">{escape("; ".join(facts))}.</p></header>'


def _verdict(order: Document | None) -> str:
    """Say what to do, in one line; empty where no order was asked for."""
    if order is None:
        return ""
    if order.get("unresolved"):
        return f"No safe order: {phrase([str(name) for name in order['unresolved'][0]])} hold each other."
    steps = order_in_words(order)
    return f"Take {steps[0][0]} first: {steps[0][1]}" if steps else "There is nothing to take."


def _assumptions(scene: Scene, order: Document | None) -> list[str]:
    """List the assumptions of the scene and the order, each once."""
    return list(dict.fromkeys([*scene.assumptions, *sentences((order or {}).get("assumptions"))]))
