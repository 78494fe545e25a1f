"""The dependency graph as a layered drawing: what must go first stands above what it holds up."""

import math
from collections.abc import Hashable, Mapping, Sequence
from dataclasses import dataclass
from html import escape
from itertools import accumulate, pairwise
from typing import Any

import networkx as nx
import numpy as np

from topple.planner.decide.names import Colour, spoken
from topple.planner.decide.words import WORDS, because, ordinal, places, said, shorten
from topple.planner.report.html import key
from topple.planner.report.limits import LIMITS
from topple.planner.report.palette import (
    FIXED_COLOUR,
    REASON_COLOURS,
    css,
    ink_on,
    object_colours,
    reason_colour,
)
from topple.topology.scene.scene import Scene

Document = Mapping[str, Any]
Point = tuple[float, float]
Edge = tuple[str, str]
Box = tuple[float, float, float]  # centre and width; the height is `HIGH`

HIGH = 30.0  # height of a box [px]
BADGE = 34.0  # width of the coloured field of a box that carries the number [px]
GAP = 30.0  # between boxes of a layer, and parts of the graph [px]
LAYER = 88.0  # from the middle of a layer to that of the next [px]
MARGIN = 8.0  # white around the drawing [px]
LETTER = 7.4  # width of a letter at 13 px in the fonts in use; widths of boxes and labels follow from it [px]
BEND = 10.0  # width that an arrow takes in a layer that it passes [px]
PARTS = (
    0.5 + np.array([0, *(side * part for part in range(1, 23) for side in (-1, 1))]) / 48
)  # of an arrow, to label
SWEEPS = 6  # times that every layer is sorted: more change nothing on graphs of twenty objects
STYLE = (
    "text{font:13px Helvetica,Arial,'DejaVu Sans',sans-serif;fill:#111;text-anchor:middle}"
    ".box{fill:#fff;stroke:#999}.target .box{stroke:#111;stroke-width:2}"
    "text.reason{font-size:12px;stroke:#fff;stroke-width:4px;paint-order:stroke}"
)
"""Of a graph that stands alone: a page has its own, which follows light and dark."""


@dataclass(frozen=True, eq=False)
class DrawnGraph:
    """A dependency graph ready to be drawn, in pixels, y downwards."""

    width: float
    height: float
    boxes: Mapping[str, Box]
    routes: Mapping[Edge, Sequence[Point]]  # along each arrow, from the rim of one box to that of the other
    labels: Mapping[Edge, Point]  # centre of each arrow's label
    places: Mapping[str, int]  # in the order, from 1; absent for objects that stay
    reasons: Mapping[Edge, tuple[str, ...]]  # of each arrow (first, then)
    confidence: Mapping[Edge, float]  # the highest of these
    targets: frozenset[str]
    hidden: int  # arrows left out because they follow from others

    def label(self, edge: Edge) -> str:
        """The words on an arrow: how its first object lies to its second one."""
        return _label(self.reasons[edge])

    @staticmethod
    def of(names: Sequence[str], order: Document, row: float = 620.0) -> "DrawnGraph":
        """Lay out the graph of an order in layers, each connected part by itself, the parts in rows.

        Args:
            names: The objects that can be taken, in the scene's order.
            order: A `topple.order` document. On a cycle its order decides which object stands above.
            row: Width at which a row of parts wraps [px].

        Returns:
            The graph; above `LIMITS.graph_edges` arrows without those that follow from others.
        """
        reasons: dict[Edge, tuple[str, ...]] = {}
        confidence: dict[Edge, float] = {}
        for dependency in order.get("dependencies", ()):
            edge = (str(dependency["first"]), str(dependency["then"]))
            if edge[0] != edge[1]:
                reasons[edge] = (*reasons.get(edge, ()), said(dependency))
                sure = float(dependency.get("confidence", 1.0))
                confidence[edge] = max(confidence.get(edge, 0.0), sure)
        place = places(order)
        graph: nx.DiGraph[str] = nx.DiGraph(_kept(list(reasons)))
        rank = {n: at for at, n in enumerate(dict.fromkeys([*place, *names, *graph]))}
        graph.add_nodes_from(rank)
        boxes, routes, low = _place_parts(graph, rank, row)
        kept = {edge: reasons[edge] for edge in graph.edges}
        labels = _label_places(routes, kept, boxes)
        ends = [x + width / 2 for x, _, width in boxes.values()]
        ends += [x + len(_label(kept[edge])) * LETTER / 2 for edge, (x, _) in labels.items()]
        ends += [x for route in routes.values() for x, _ in route]
        width, hidden = max(ends, default=0.0) + MARGIN, len(reasons) - len(kept)
        targets = frozenset(str(name) for name in order.get("targets", ()))
        return DrawnGraph(
            width, low + MARGIN, boxes, routes, labels, place, kept, confidence, targets, hidden
        )


def _label(reasons: Sequence[str]) -> str:
    return ", ".join(WORDS.get(reason, reason) for reason in reasons)


def graph_box(graph: DrawnGraph, colours: Mapping[str, Colour], index: Mapping[str, int]) -> str:
    """Draw the graph for a page, with a legend.

    Args:
        graph: The graph.
        colours: Object -> colour of the field in its box.
        index: Object -> its number in the viewer, which links the drawing to the 3-D view.
    """
    used = dict.fromkeys(reason for reasons in graph.reasons.values() for reason in reasons)
    keys = "".join(
        key(reason_colour(reason), WORDS.get(reason, reason))
        for reason in [*filter(used.__contains__, REASON_COLOURS), *(used.keys() - REASON_COLOURS.keys())]
    )
    note = "An arrow from a to b: a goes before b. " if used else "No arrows: nothing has to go first. "
    note += "1st, 2nd, ... is the place in the order; a bold frame marks a target."
    note += f" {graph.hidden} arrows that follow from others are left out." if graph.hidden else ""
    legend = f'<p class="legend">{keys}<span class="note">{note}</span></p>'
    return f'<div class="graph-box">{_svg(graph, colours, index)}{legend}</div>'


def graph_file(scene: Scene, order: Document) -> str:
    """Draw the dependency graph of an order as an SVG file that stands alone, black on white."""
    scene, order = spoken(scene, (scene, order))
    colours = object_colours(scene.names, scene.fixed)
    drawn = _svg(DrawnGraph.of(scene.movable, order, row=440.0), colours, {})
    alone = f'><style>{STYLE}</style><rect width="100%" height="100%" fill="#fff"/>'
    return drawn.replace(">", alone, 1).replace("<svg", '<svg xmlns="http://www.w3.org/2000/svg"', 1)


def arrow_head(route: Sequence[Point], size: float = 8.0) -> tuple[Point, Point, Point]:
    """The triangle at the end of an arrow."""
    (x, y), (u, v) = route[-2], route[-1]
    length = max(math.hypot(u - x, v - y), 1e-6)
    a, b = (u - x) / length * size, (v - y) / length * size
    return (u, v), (u - a - b * 0.45, v - b + a * 0.45), (u - a + b * 0.45, v - b - a * 0.45)


def _kept(edges: list[Edge]) -> list[Edge]:
    """All edges of a small graph, the transitive reduction of a large one without cycles."""
    graph: nx.DiGraph[str] = nx.DiGraph(edges)
    if len(edges) <= LIMITS.graph_edges or not nx.is_directed_acyclic_graph(graph):
        return edges
    reduced = nx.transitive_reduction(graph)
    return [edge for edge in edges if reduced.has_edge(*edge)]


def _place_parts(
    graph: "nx.DiGraph[str]", rank: Mapping[str, int], row: float
) -> tuple[dict[str, Box], dict[Edge, list[Point]], float]:
    """Boxes and routes of all parts, and where the lowest ends."""
    parts = [sorted(part, key=rank.__getitem__) for part in nx.weakly_connected_components(graph)]
    parts.sort(key=lambda part: (len(part) == 1, rank[part[0]]))  # what stands alone comes last
    boxes: dict[str, Box] = {}
    routes: dict[Edge, list[Point]] = {}
    left, top, low, before = MARGIN, MARGIN, MARGIN, 0
    for part in parts:
        wide = {name: len(shorten(name)) * LETTER + BADGE + 18.0 for name in part}
        at, lines = _part(graph.subgraph(part), rank, wide)
        right = max(at[name][0] + wide[name] / 2 for name in part)
        right = max([right, *(x for line in lines.values() for x, _ in line)])
        if left > MARGIN and (left + right > row or len(part) == 1 < before):
            left, top = MARGIN, low + GAP
        boxes |= {name: (at[name][0] + left, at[name][1] + top, wide[name]) for name in part}
        routes |= {edge: [(x + left, y + top) for x, y in line] for edge, line in lines.items()}
        low = max(low, top + max(y for _, y in at.values()) + HIGH / 2)
        left, before = left + right + GAP, len(part)
    return boxes, routes, low


def _part(
    graph: "nx.DiGraph[str]", rank: Mapping[str, int], wide: Mapping[str, float]
) -> tuple[dict[Hashable, Point], dict[Edge, list[Point]]]:
    """Centres of one connected part from (0, 0) on, and the routes of its arrows."""
    cycle = {n: number for number, part in enumerate(nx.strongly_connected_components(graph)) for n in part}
    back = [(a, b) for a, b in graph.edges if cycle[a] == cycle[b] and rank[a] > rank[b]]
    forward = nx.DiGraph(graph)
    forward.remove_edges_from(back)
    level = {name: depth for depth, layer in enumerate(nx.topological_generations(forward)) for name in layer}
    bent: nx.DiGraph[Hashable] = nx.DiGraph()  # long arrows have a bend in every layer that they pass
    bent.add_nodes_from(sorted(graph, key=rank.__getitem__))
    chains: dict[Edge, list[Hashable]] = {}
    for a, b in forward.edges:
        chains[a, b] = [a, *((a, b, depth) for depth in range(level[a] + 1, level[b])), b]
        nx.add_path(bent, chains[a, b])
    layers = [list(layer) for layer in nx.topological_generations(bent)]
    width: dict[Hashable, float] = {**dict.fromkeys(bent, BEND), **wide}
    x = _columns(bent, layers, width)
    corner = min(x[knot] - width[knot] / 2 for knot in bent)
    centres = {
        knot: (x[knot] - corner, depth * LAYER + HIGH / 2)
        for depth, layer in enumerate(layers)
        for knot in layer
    }
    routes = {edge: _route([centres[knot] for knot in chain], wide, edge) for edge, chain in chains.items()}
    rim = max(centres[name][0] + wide[name] / 2 for name in graph)
    for turn, (a, b) in enumerate(back):
        (start, y), (end, v) = ((centres[n][0] + wide[n] / 2, centres[n][1] + 5.0) for n in (a, b))
        side = rim + 26.0 + 12.0 * turn  # back up, around the right of all
        routes[a, b] = [(start, y), (side, y), (side, v), (end, v)]
    return centres, routes


def _columns(
    graph: "nx.DiGraph[Hashable]", layers: Sequence[list[Hashable]], wide: Mapping[Hashable, float]
) -> dict[Hashable, float]:
    """Sort every layer by the middle of its neighbours, and pull all there as far as there is room."""
    x = dict.fromkeys(graph, 0.0)
    around: Mapping[Hashable, Any] = {knot: {**graph.pred[knot], **graph.succ[knot]} for knot in graph}
    for beside in [graph.pred, graph.succ] * SWEEPS + [around] * SWEEPS:
        for layer in layers:
            wanted = {knot: float(np.mean([x[other] for other in beside[knot] or [knot]])) for knot in layer}
            layer.sort(key=wanted.__getitem__)
            steps = ((wide[a] + wide[b]) / 2 + GAP for a, b in pairwise(layer))
            starts = np.fromiter(accumulate(steps, initial=0.0), dtype=np.float64)
            free = np.array([wanted[knot] for knot in layer]) - starts
            low, high = np.minimum.accumulate(free[::-1])[::-1], np.maximum.accumulate(free)
            x.update(zip(layer, (starts + (low + high) / 2).tolist(), strict=True))
    return x


def _route(points: list[Point], wide: Mapping[str, float], edge: Edge) -> list[Point]:
    """An arrow from rim to rim, straight down through layers that it passes, spread over the boxes' rims."""
    (x, y), (u, v) = points[0], points[-1]
    leave = x + float(np.clip((points[1][0] - x) / 300.0, -0.35, 0.35)) * wide[edge[0]]
    arrive = u + float(np.clip((points[-2][0] - u) / 300.0, -0.35, 0.35)) * wide[edge[1]]
    bends = [(x, y + half) for x, y in points[1:-1] for half in (-HIGH / 2, HIGH / 2)]
    corners = [(leave, y + HIGH / 2), *bends, (arrive, v - HIGH / 2)]
    if not bends:
        return corners
    rise = np.linspace(0.0, 1.0, 10)[:, None]
    share = np.hstack([rise**2 * (3.0 - 2.0 * rise), rise])  # upright at both ends
    curves = [a + share * np.subtract(b, a) for a, b in pairwise(corners)]
    return [(float(x), float(y)) for x, y in np.concatenate(curves)]


def _label_places(
    routes: Mapping[Edge, Sequence[Point]], reasons: Mapping[Edge, tuple[str, ...]], boxes: Mapping[str, Box]
) -> dict[Edge, Point]:
    """Put each label on its arrow where it covers no box, and as few other labels as can be."""
    taken = [(x, y, width, HIGH, len(routes)) for x, y, width in boxes.values()]
    labels: dict[Edge, Point] = {}
    for edge, route in routes.items():
        size = len(_label(reasons[edge])) * LETTER + 8.0, 14.0
        spots = [_along(route, part) for part in PARTS]
        labels[edge] = spots[int(np.argmin([_count_covered(spot, size, taken) for spot in spots]))]
        taken.append((*labels[edge], *size, 1))
    return labels


def _count_covered(at: Point, size: Point, taken: Sequence[tuple[float, float, float, float, int]]) -> int:
    """How much of what is drawn a label would cover."""
    return sum(
        weight
        for x, y, width, high, weight in taken
        if abs(at[0] - x) <= (size[0] + width) / 2 and abs(at[1] - y) <= (size[1] + high) / 2
    )


def _along(route: Sequence[Point], part: float) -> Point:
    """The point a given part of the way along a polyline."""
    way = list(accumulate((math.dist(a, b) for a, b in pairwise(route)), initial=0.0))
    x, y = (float(np.interp(part * way[-1], way, [point[axis] for point in route])) for axis in (0, 1))
    return x, y


def _svg(graph: DrawnGraph, colours: Mapping[str, Colour], index: Mapping[str, int]) -> str:
    parts = [_arrow(graph, edge, index) for edge in graph.routes]
    parts += [
        f'<text class="reason" {_ends(edge, index)} x="{x:.1f}" y="{y + 4:.1f}">'
        f"{escape(graph.label(edge))}</text>"
        for edge, (x, y) in graph.labels.items()
    ]
    parts += [_box(graph, name, colours.get(name, FIXED_COLOUR), index) for name in graph.boxes]
    width, height = f"{graph.width:.0f}", f"{graph.height:.0f}"
    return (
        f'<svg class="graph" role="img" aria-label="dependency graph" style="--width: {width}px" '
        f'width="{width}" height="{height}" viewBox="0 0 {width} {height}">{"".join(parts)}</svg>'
    )


def _arrow(graph: DrawnGraph, edge: Edge, index: Mapping[str, int]) -> str:
    route, sure = graph.routes[edge], graph.confidence[edge]
    colour = css(reason_colour(graph.reasons[edge][0]))
    dashes = "" if sure >= 0.5 else ' stroke-dasharray="5 4"'
    line, head = (" ".join(f"{x:.1f},{y:.1f}" for x, y in points) for points in (route, arrow_head(route)))
    told = f"{edge[0]} before {edge[1]}: {', '.join(because([edge[0]], r) for r in graph.reasons[edge])}"
    return (
        f'<g class="arrow" {_ends(edge, index)}><title>{escape(told)} (confidence {sure:.2f})</title>'
        f'<polyline points="{line}" fill="none" stroke="{colour}" stroke-width="{1.2 + 0.8 * sure:.1f}"'
        f'{dashes}/><polygon points="{head}" fill="{colour}"/></g>'
    )


def _box(graph: DrawnGraph, name: str, paint: Colour, index: Mapping[str, int]) -> str:
    x, y, width = graph.boxes[name]
    left, top = x - width / 2, y - HIGH / 2
    link = f'data-object="{index[name]}" tabindex="0"' if name in index else ""
    place, ink = ordinal(graph.places[name]) if name in graph.places else "", css(ink_on(paint))
    return (
        f'<g class="node{" target" if name in graph.targets else ""}" {link}><title>{escape(name)}</title>'
        f'<rect class="box" x="{left:.1f}" y="{top:.1f}" width="{width:.1f}" height="{HIGH:.0f}"/>'
        f'<rect x="{left:.1f}" y="{top:.1f}" width="{BADGE:.0f}" height="{HIGH:.0f}" fill="{css(paint)}"/>'
        f'<text class="place" style="fill:{ink}" x="{left + BADGE / 2:.1f}" y="{y + 4.5:.1f}">{place}</text>'
        f'<text x="{x + BADGE / 2:.1f}" y="{y + 4.5:.1f}">{escape(shorten(name))}</text></g>'
    )


def _ends(edge: Edge, index: Mapping[str, int]) -> str:
    """The two objects of an arrow, for the page to light it up with either."""
    return f'data-ends="{index.get(edge[0], -1)} {index.get(edge[1], -1)}"'
