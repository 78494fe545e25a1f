"""The dependency graph as a layered drawing: what to show of it, and its SVG."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from html import escape
from typing import Any

import networkx as nx

from topple.planner.report.layout import BADGE, NODE_HEIGHT, GraphLayout, Point, layered
from topple.planner.report.limits import LIMITS
from topple.planner.report.palette import FIXED_COLOUR, REASON_COLOURS, Colour, css, ink_on, reason_colour
from topple.planner.report.words import because, ordinal, places, said, shortened

Document = Mapping[str, Any]


@dataclass(frozen=True, eq=False)
class DrawnGraph:
    """A dependency graph ready to be drawn.

    Attributes:
        layout: Places of boxes and arrows.
        labels: Name -> text in its box: its name, shortened.
        places: Name -> its place in the order, from 1; absent for objects that stay.
        reasons: (first, then) -> the reasons of the arrow, one or several.
        confidence: (first, then) -> the highest confidence of these.
        targets: Names of the targets.
        hidden: Arrows left out because they follow from others.
    """

    layout: GraphLayout
    labels: Mapping[str, str]
    places: Mapping[str, int]
    reasons: Mapping[tuple[str, str], tuple[str, ...]]
    confidence: Mapping[tuple[str, str], float]
    targets: frozenset[str]
    hidden: int

    @staticmethod
    def of(names: Sequence[str], order: Document, row: float = 620.0) -> "DrawnGraph":
        """Lay out the graph of an order.

        Args:
            names: The objects that can be taken, in the scene's order.
            order: A `topple.order` document.
            row: Width at which rows of unconnected objects wrap [px].

        Returns:
            The graph; above `LIMITS.graph_edges` arrows without those that follow from others.
        """
        reasons: dict[tuple[str, str], tuple[str, ...]] = {}
        confidence: dict[tuple[str, str], float] = {}
        for dependency in order.get("dependencies", ()):
            edge = (str(dependency["first"]), str(dependency["then"]))
            if edge[0] == edge[1]:
                continue
            reasons[edge] = (*reasons.get(edge, ()), said(dependency))
            confidence[edge] = max(confidence.get(edge, 0.0), float(dependency.get("confidence", 1.0)))
        kept = _kept(list(reasons))
        place = places(order)
        nodes = list(dict.fromkeys([*place, *names, *(name for edge in kept for name in edge)]))
        labels = {name: shortened(name) for name in nodes}
        texts = {edge: ", ".join(reasons[edge]) for edge in kept}
        return DrawnGraph(
            layout=layered(nodes, texts, labels, row),
            labels=labels,
            places=place,
            reasons={edge: reasons[edge] for edge in kept},
            confidence=confidence,
            targets=frozenset(str(name) for name in order.get("targets", ())),
            hidden=len(reasons) - len(kept),
        )


def graph_svg(graph: DrawnGraph, colours: Mapping[str, Colour], index: Mapping[str, int]) -> str:
    """Draw the graph as inline SVG.

    Args:
        graph: The graph.
        colours: Object -> colour of the bar in its box.
        index: Object -> its number in the viewer, which links the drawing to the 3-D view.

    Returns:
        An `<svg>` element; every text in it is escaped.
    """
    layout = graph.layout
    used = {reason for reasons in graph.reasons.values() for reason in reasons}
    parts = [
        f'<svg class="graph" role="img" aria-label="dependency graph" width="{layout.width:.0f}" '
        f'height="{layout.height:.0f}" viewBox="0 0 {layout.width:.0f} {layout.height:.0f}">',
        graph_shapes(graph, colours, index),
        "</svg>",
    ]
    return "".join(parts) + _legend(used, graph.hidden)


def graph_shapes(graph: DrawnGraph, colours: Mapping[str, Colour], index: Mapping[str, int]) -> str:
    """What is inside the `<svg>` element of `graph_svg`."""
    layout = graph.layout
    parts = [_arrow(graph, edge, index) for edge in layout.routes]
    parts += [_label(graph, edge, index) for edge in layout.labels]
    parts += [_box(graph, name, colours.get(name), index) for name in layout.centres]
    return "".join(parts)


def arrow_head(route: Sequence[Point], size: float = 8.0) -> tuple[Point, Point, Point]:
    """The triangle at the end of an arrow."""
    (x, y), (u, v) = route[-2], route[-1]
    length = max(((u - x) ** 2 + (v - y) ** 2) ** 0.5, 1e-6)
    along = ((u - x) / length, (v - y) / length)
    back = (u - along[0] * size, v - along[1] * size)
    side = (-along[1] * size * 0.45, along[0] * size * 0.45)
    return (u, v), (back[0] + side[0], back[1] + side[1]), (back[0] - side[0], back[1] - side[1])


def _kept(edges: list[tuple[str, str]]) -> list[tuple[str, str]]:
    """All edges of a small graph, the transitive reduction of a large one without cycles."""
    graph: nx.DiGraph[str] = nx.DiGraph(edges)
    if len(edges) <= LIMITS.graph_edges or not nx.is_directed_acyclic_graph(graph):
        return edges
    reduced = nx.transitive_reduction(graph)
    return [edge for edge in edges if reduced.has_edge(*edge)]


def _arrow(graph: DrawnGraph, edge: tuple[str, str], index: Mapping[str, int]) -> str:
    route = graph.layout.routes[edge]
    colour = css(reason_colour(graph.reasons[edge][0]))
    sure = graph.confidence[edge]
    dashes = "" if sure >= 0.5 else ' stroke-dasharray="5 4"'
    line = " L".join(f"{x:.1f},{y:.1f}" for x, y in route)
    head = " ".join(f"{x:.1f},{y:.1f}" for x, y in arrow_head(route))
    told = f"{edge[0]} before {edge[1]}: {', '.join(because([edge[0]], r) for r in graph.reasons[edge])}"
    return (
        f'<g class="arrow" {_ends(edge, index)}><title>{escape(told)} (confidence {sure:.2f})</title>'
        f'<path d="M{line}" fill="none" stroke="{colour}" stroke-width="{1.2 + 0.8 * sure:.1f}"'
        f'{dashes}/><polygon points="{head}" fill="{colour}"/></g>'
    )


def _label(graph: DrawnGraph, edge: tuple[str, str], index: Mapping[str, int]) -> str:
    x, y = graph.layout.labels[edge]
    text = escape(", ".join(graph.reasons[edge]))
    return f'<text class="reason" {_ends(edge, index)} x="{x:.1f}" y="{y + 4:.1f}">{text}</text>'


def _box(graph: DrawnGraph, name: str, colour: Colour | None, index: Mapping[str, int]) -> str:
    x, y = graph.layout.centres[name]
    width = graph.layout.widths[name]
    left, top = x - width / 2, y - NODE_HEIGHT / 2
    kind = "node target" if name in graph.targets else "node"
    link = f'data-object="{index[name]}" tabindex="0"' if name in index else ""
    place, paint = graph.places.get(name), colour or FIXED_COLOUR
    number = (
        ""
        if place is None
        else f'<text class="place" style="fill:{css(ink_on(paint))}" x="{left + BADGE / 2:.1f}" '
        f'y="{y + 4.5:.1f}">{ordinal(place)}</text>'
    )
    return (
        f'<g class="{kind}" {link}><title>{escape(name)}</title>'
        f'<rect class="box" x="{left:.1f}" y="{top:.1f}" width="{width:.1f}" height="{NODE_HEIGHT:.0f}"/>'
        f'<rect x="{left:.1f}" y="{top:.1f}" width="{BADGE:.0f}" height="{NODE_HEIGHT:.0f}" '
        f'fill="{css(paint)}"/>{number}'
        f'<text x="{x + BADGE / 2:.1f}" y="{y + 4.5:.1f}">{escape(graph.labels[name])}</text></g>'
    )


def _ends(edge: tuple[str, str], index: Mapping[str, int]) -> str:
    """The two objects of an arrow, for the page to light it up with either."""
    return f'data-ends="{index.get(edge[0], -1)} {index.get(edge[1], -1)}"'


def _legend(used: set[str], hidden: int) -> str:
    known = [reason for reason in REASON_COLOURS if reason in used]
    items = [
        f'<span class="key"><i style="background:{css(reason_colour(reason))}"></i>{escape(reason)}</span>'
        for reason in [*known, *sorted(used - set(known))]
    ]
    note = "An arrow from a to b: a goes before b. " if used else "No arrows: nothing has to go first. "
    note += "1st, 2nd, ... is the place in the order; a bold frame marks a target."
    if hidden:
        note += f" {hidden} arrows that follow from others are left out."
    return f'<p class="legend">{"".join(items)}<span class="note">{note}</span></p>'
