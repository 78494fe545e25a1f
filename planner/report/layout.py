"""Layered layout of a dependency graph: what must go first stands above what it holds up."""

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise

import networkx as nx

Point = tuple[float, float]
Knot = tuple[str, int]
"""A place in a layer: an object (its name, -1), or a bend of a long arrow (the edge's name, its layer)."""

NODE_HEIGHT = 30.0
BADGE = 34.0
"""Width of the coloured field of a box that carries the number."""
LAYER_GAP = 58.0
NODE_GAP = 30.0
BEND_WIDTH = 10.0
PART_GAP = 26.0
MARGIN = 8.0
CHARACTER = 7.4
"""Width of a character at 13 px in the fonts in use; node widths in pixels follow from it."""


@dataclass(frozen=True)
class GraphLayout:
    """Where everything of a graph is drawn, in pixels, y downwards.

    Attributes:
        width: Width of the drawing.
        height: Height of the drawing.
        centres: Node -> centre of its box.
        widths: Node -> width of its box (height `NODE_HEIGHT`).
        routes: (first, then) -> points along the arrow, from the rim of one box to the rim of the other.
        labels: (first, then) -> centre of the arrow's label; absent where no room was left.
    """

    width: float
    height: float
    centres: Mapping[str, Point]
    widths: Mapping[str, float]
    routes: Mapping[tuple[str, str], Sequence[Point]]
    labels: Mapping[tuple[str, str], Point]


def layered(
    nodes: Iterable[str], edges: Mapping[tuple[str, str], str], labels: Mapping[str, str], row: float = 620.0
) -> GraphLayout:
    """Lay a directed graph out in layers, each connected part by itself, the parts in rows.

    Args:
        nodes: Names of all objects, in the order they are taken. On a cycle it decides which stands above.
        edges: (first, then) -> text of the arrow's label.
        labels: Name -> text in its box; decides the box's width.
        row: Width at which a row of parts wraps [px].

    Returns:
        The layout.
    """
    names = list(dict.fromkeys(nodes))
    widths = {name: len(labels.get(name, name)) * CHARACTER + BADGE + 18.0 for name in names}
    rank = {name: place for place, name in enumerate(names)}
    graph: nx.DiGraph[str] = nx.DiGraph()
    graph.add_nodes_from(names)
    graph.add_edges_from(edges)
    parts = [sorted(part, key=rank.__getitem__) for part in nx.weakly_connected_components(graph)]
    parts.sort(key=lambda part: (len(part) == 1, rank[part[0]]))  # what stands alone comes last
    centres: dict[str, Point] = {}
    routes: dict[tuple[str, str], list[Point]] = {}
    left, top, low, width = MARGIN, MARGIN, MARGIN, 0.0
    before = 0  # objects in the part before
    for part in parts:
        places, lines, size = _part(graph.subgraph(part), part, widths)
        if left > MARGIN and (left + size[0] > row or len(part) == 1 < before):
            left, top = MARGIN, low + PART_GAP
        centres |= {name: (x + left, y + top) for name, (x, y) in places.items()}
        routes |= {edge: [(x + left, y + top) for x, y in line] for edge, line in lines.items()}
        low, width = max(low, top + size[1]), max(width, left + size[0])
        left, before = left + size[0] + PART_GAP, len(part)
    places = _label_places(routes, edges, centres, widths)
    width = max([width, *(x + _label_width(edges[edge]) / 2 for edge, (x, _) in places.items())])
    return GraphLayout(width + MARGIN, low + MARGIN, centres, widths, routes, places)


def _part(
    graph: "nx.DiGraph[str]", names: Sequence[str], widths: Mapping[str, float]
) -> tuple[dict[str, Point], dict[tuple[str, str], list[Point]], Point]:
    """Places and routes of one connected part from (0, 0) on, and its size."""
    back = _back_edges(graph, names)
    forward = nx.DiGraph(graph)
    forward.remove_edges_from(back)
    layers, chains = _layers(forward, names)
    _order_layers(layers, chains)
    knots = _coordinates(layers, chains, widths)
    shift = -min(
        x - (widths[name] if level < 0 else BEND_WIDTH) / 2 for (name, level), (x, _) in knots.items()
    )
    knots = {knot: (x + shift, y) for knot, (x, y) in knots.items()}
    places = {name: knots[(name, -1)] for name in names}
    routes = _routes(chains, knots, widths)
    for turn, edge in enumerate(back):
        routes[edge] = _return(edge, places, widths, 26.0 + 12.0 * turn)
    right = max(x + widths[name] / 2 for name, (x, _) in places.items())
    right = max([right, *(x for line in routes.values() for x, _ in line)])
    return places, routes, (right, max(y for _, y in places.values()) + NODE_HEIGHT / 2)


def _back_edges(graph: "nx.DiGraph[str]", names: Sequence[str]) -> list[tuple[str, str]]:
    """Edges of cycles that run against the order of the names; without them no cycle is left."""
    rank = {name: place for place, name in enumerate(names)}
    cycle = {
        name: number for number, part in enumerate(nx.strongly_connected_components(graph)) for name in part
    }
    return [(a, b) for a, b in graph.edges if cycle[a] == cycle[b] and rank[a] > rank[b]]


def _layers(
    graph: "nx.DiGraph[str]", names: Sequence[str]
) -> tuple[list[list[Knot]], dict[tuple[str, str], list[Knot]]]:
    """Put each object a layer below all that go before it; long edges get a bend in every layer between."""
    generations = list(nx.topological_generations(graph))
    level = {name: depth for depth, generation in enumerate(generations) for name in generation}
    layers: list[list[Knot]] = [[] for _ in generations]
    for name in names:
        layers[level[name]].append((name, -1))
    chains: dict[tuple[str, str], list[Knot]] = {}
    for first, then in graph.edges:
        bends: list[Knot] = [(f"{first}\0{then}", depth) for depth in range(level[first] + 1, level[then])]
        for bend in bends:
            layers[bend[1]].append(bend)
        chains[(first, then)] = [(first, -1), *bends, (then, -1)]
    return layers, chains


def _neighbours(
    chains: Mapping[tuple[str, str], Sequence[Knot]],
) -> tuple[dict[Knot, list[Knot]], dict[Knot, list[Knot]]]:
    above: dict[Knot, list[Knot]] = {}
    below: dict[Knot, list[Knot]] = {}
    for chain in chains.values():
        for upper, lower in pairwise(chain):
            below.setdefault(upper, []).append(lower)
            above.setdefault(lower, []).append(upper)
    return above, below


def _order_layers(layers: list[list[Knot]], chains: Mapping[tuple[str, str], Sequence[Knot]]) -> None:
    """Sort every layer by the mean place of its neighbours, down and up again, and keep the best found."""
    above, below = _neighbours(chains)
    best = [list(layer) for layer in layers]
    fewest = _crossings(layers, below)
    for sweep in range(8):
        downwards = sweep % 2 == 0
        beside = above if downwards else below
        for layer in layers if downwards else reversed(layers):
            place = {knot: index for other in layers for index, knot in enumerate(other)}
            mean = {
                knot: sum(place[other] for other in beside[knot]) / len(beside[knot])
                if beside.get(knot)
                else place[knot]
                for knot in layer
            }
            layer.sort(key=lambda knot: mean[knot])
        crossings = _crossings(layers, below)
        if crossings < fewest:
            fewest, best = crossings, [list(layer) for layer in layers]
    layers[:] = best


def _crossings(layers: Sequence[Sequence[Knot]], below: Mapping[Knot, Sequence[Knot]]) -> int:
    crossings = 0
    for upper, lower in pairwise(layers):
        place = {knot: index for index, knot in enumerate(lower)}
        ends = [sorted(place[knot] for knot in below.get(start, ()) if knot in place) for start in upper]
        for index, right in enumerate(ends):
            crossings += sum(a > b for left in ends[:index] for a in left for b in right)
    return crossings


def _coordinates(
    layers: Sequence[Sequence[Knot]],
    chains: Mapping[tuple[str, str], Sequence[Knot]],
    widths: Mapping[str, float],
) -> dict[Knot, Point]:
    """Pull every knot towards the mean of its neighbours, as far as the boxes beside it allow."""
    above, below = _neighbours(chains)
    width = {knot: widths[knot[0]] if knot[1] < 0 else BEND_WIDTH for layer in layers for knot in layer}
    x: dict[Knot, float] = {}
    for layer in layers:
        start = -sum(width[knot] + NODE_GAP for knot in layer) / 2
        for knot in layer:
            x[knot] = start + width[knot] / 2
            start += width[knot] + NODE_GAP
    for _ in range(12):
        for layer in layers:
            wanted = [
                sum(x[other] for other in beside) / len(beside)
                if (beside := above.get(knot, []) + below.get(knot, []))
                else x[knot]
                for knot in layer
            ]
            x.update(zip(layer, _apart(wanted, [width[knot] for knot in layer]), strict=True))
    return {
        knot: (x[knot], NODE_HEIGHT / 2 + depth * (NODE_HEIGHT + LAYER_GAP))
        for depth, layer in enumerate(layers)
        for knot in layer
    }


def _apart(wanted: Sequence[float], widths: Sequence[float]) -> list[float]:
    """Places nearest to those wanted, in the same sequence, with `NODE_GAP` between the boxes."""
    reach = [(a + b) / 2 + NODE_GAP for a, b in pairwise(widths)]
    rightwards = list(wanted)
    for index, gap in enumerate(reach, start=1):
        rightwards[index] = max(rightwards[index], rightwards[index - 1] + gap)
    leftwards = list(wanted)
    for index in range(len(reach) - 1, -1, -1):
        leftwards[index] = min(leftwards[index], leftwards[index + 1] - reach[index])
    # Both keep the gaps, so does their mean, which leans to neither side.
    return [(a + b) / 2 for a, b in zip(rightwards, leftwards, strict=True)]


def _routes(
    chains: Mapping[tuple[str, str], Sequence[Knot]],
    places: Mapping[Knot, Point],
    widths: Mapping[str, float],
) -> dict[tuple[str, str], list[Point]]:
    """Arrows from the lower rim of one box to the upper rim of the other."""
    routes: dict[tuple[str, str], list[Point]] = {}
    half = NODE_HEIGHT / 2
    for (first, then), chain in chains.items():
        (x, y), (u, v) = places[chain[0]], places[chain[-1]]
        points = [places[knot] for knot in chain]
        # Arrows leave and arrive spread over the box, so that they do not all share one point.
        leave = max(-0.35, min(0.35, (points[1][0] - x) / 300.0)) * widths[first]
        arrive = max(-0.35, min(0.35, (points[-2][0] - u) / 300.0)) * widths[then]
        points = [(x + leave, y + half), *points[1:-1], (u + arrive, v - half)]
        if len(points) == 2:
            routes[(first, then)] = points
            continue
        route = [points[0]]
        for (a, b), (c, d) in pairwise(points):
            middle = (b + d) / 2
            route += _curve((a, b), (a, middle), (c, middle), (c, d))[1:]
        routes[(first, then)] = route
    return routes


def _return(
    edge: tuple[str, str], places: Mapping[str, Point], widths: Mapping[str, float], bulge: float
) -> list[Point]:
    """An arrow back up, around the right of both boxes."""
    (x, y), (u, v) = places[edge[0]], places[edge[1]]
    x, u = x + widths[edge[0]] / 2, u + widths[edge[1]] / 2
    side = max(x, u) + bulge
    return _curve((x, y + 5), (side, y + 5), (side, v + 5), (u, v + 5))


def _curve(start: Point, leave: Point, arrive: Point, end: Point, steps: int = 12) -> list[Point]:
    """Points of the cubic Bézier curve of four control points, ends included."""
    points: list[Point] = []
    for step in range(steps + 1):
        t = step / steps
        s = 1 - t
        weights = (s**3, 3 * s * s * t, 3 * s * t * t, t**3)
        x, y = (
            sum(
                weight * corner[axis]
                for weight, corner in zip(weights, (start, leave, arrive, end), strict=True)
            )
            for axis in (0, 1)
        )
        points.append((x, y))
    return points


def _label_places(
    routes: Mapping[tuple[str, str], Sequence[Point]],
    texts: Mapping[tuple[str, str], str],
    centres: Mapping[str, Point],
    widths: Mapping[str, float],
) -> dict[tuple[str, str], Point]:
    """Put each label on its arrow where it covers no box and no other label."""
    taken = [(x, y, widths[name], NODE_HEIGHT) for name, (x, y) in centres.items()]
    labels: dict[tuple[str, str], Point] = {}
    for edge, route in routes.items():
        size = (_label_width(texts[edge]), 14.0)
        for part in (0.5, 0.38, 0.62, 0.26, 0.74):
            x, y = _along(route, part)
            clear = all(
                abs(x - u) > (size[0] + w) / 2 or abs(y - v) > (size[1] + h) / 2 for u, v, w, h in taken
            )
            if clear:
                labels[edge] = (x, y)
                taken.append((x, y, *size))
                break
    return labels


def _label_width(text: str) -> float:
    """Width of an arrow's label at 12 px."""
    return len(text) * 7.0 + 8.0


def _along(route: Sequence[Point], part: float) -> Point:
    """The point a given part of the way along a polyline."""
    lengths = [math.dist(a, b) for a, b in pairwise(route)]
    left = part * sum(lengths)
    for (a, b), length in zip(pairwise(route), lengths, strict=True):
        if left <= length and length > 0:
            return (a[0] + (b[0] - a[0]) * left / length, a[1] + (b[1] - a[1]) * left / length)
        left -= length
    return route[-1]
