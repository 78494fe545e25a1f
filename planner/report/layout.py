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
BADGE = 24.0
"""Width of the coloured field of a box that carries the number."""
LAYER_GAP = 58.0
NODE_GAP = 30.0
BEND_WIDTH = 10.0
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
    """Lay a directed graph out in layers.

    Cycles are allowed: the objects of one share a layer. Objects without any edge stand in rows below.

    Args:
        nodes: Names of all objects.
        edges: (first, then) -> text of the arrow's label.
        labels: Name -> text in its box; decides the box's width.
        row: Width at which rows of unconnected objects wrap [px].

    Returns:
        The layout.
    """
    names = list(dict.fromkeys(nodes))
    widths = {name: len(labels.get(name, name)) * CHARACTER + BADGE + 18.0 for name in names}
    graph: nx.DiGraph[str] = nx.DiGraph()
    graph.add_nodes_from(names)
    graph.add_edges_from(edges)
    loose = [name for name in names if graph.degree(name) == 0]
    graph.remove_nodes_from(loose)
    layers, chains = _layers(graph)
    _order_layers(layers, chains)
    places = _coordinates(layers, chains, widths)
    bottom = max(len(layers) * (NODE_HEIGHT + LAYER_GAP) - LAYER_GAP + 24.0, 0.0) if layers else 0.0
    places |= _rows(loose, widths, bottom, row)
    centres = {name: places[(name, -1)] for name in names}
    shift = 8.0 - min((x - widths[name] / 2 for name, (x, _) in centres.items()), default=0.0)
    places = {knot: (x + shift, y) for knot, (x, y) in places.items()}
    centres = {name: places[(name, -1)] for name in names}
    routes = _routes(chains, places, widths)
    return GraphLayout(
        width=max((x + widths[name] / 2 for name, (x, _) in centres.items()), default=0.0) + 8.0,
        height=max((y for _, y in centres.values()), default=0.0) + NODE_HEIGHT / 2 + 10.0,
        centres=centres,
        widths=widths,
        routes=routes,
        labels=_label_places(routes, edges, centres, widths),
    )


def _layers(graph: "nx.DiGraph[str]") -> tuple[list[list[Knot]], dict[tuple[str, str], list[Knot]]]:
    """Put each object a layer below all that go before it; long edges get a bend in every layer between."""
    condensed = nx.condensation(graph)
    level: dict[str, int] = {}
    for depth, generation in enumerate(nx.topological_generations(condensed)):
        for component in generation:
            for name in condensed.nodes[component]["members"]:
                level[name] = depth
    count = max(level.values(), default=-1) + 1
    layers: list[list[Knot]] = [[] for _ in range(count)]
    for name in graph.nodes:
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
        knot: (x[knot], NODE_HEIGHT / 2 + 8.0 + depth * (NODE_HEIGHT + LAYER_GAP))
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


def _rows(names: Sequence[str], widths: Mapping[str, float], top: float, row: float) -> dict[Knot, Point]:
    places: dict[Knot, Point] = {}
    x, y = 0.0, top + NODE_HEIGHT / 2 + 8.0
    for name in names:
        if x > 0 and x + widths[name] > row:
            x, y = 0.0, y + NODE_HEIGHT + 14.0
        places[(name, -1)] = (x + widths[name] / 2, y)
        x += widths[name] + 14.0
    return places


def _routes(
    chains: Mapping[tuple[str, str], Sequence[Knot]],
    places: Mapping[Knot, Point],
    widths: Mapping[str, float],
) -> dict[tuple[str, str], list[Point]]:
    """Arrows from the lower rim of one box to the upper rim of the other; within a layer, an arc."""
    routes: dict[tuple[str, str], list[Point]] = {}
    half = NODE_HEIGHT / 2
    for (first, then), chain in chains.items():
        (x, y), (u, v) = places[chain[0]], places[chain[-1]]
        if y == v:
            below = 1.0 if x < u else -1.0  # the two directions of a cycle take different sides
            rim, bend = y + below * half, y + below * (half + 34.0)
            routes[(first, then)] = _curve(
                (x, rim), (x + (u - x) / 3, bend), (x + (u - x) * 2 / 3, bend), (u, rim)
            )
            continue
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
        size = (len(texts[edge]) * 6.0 + 4.0, 13.0)
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


def _along(route: Sequence[Point], part: float) -> Point:
    """The point a given part of the way along a polyline."""
    lengths = [math.dist(a, b) for a, b in pairwise(route)]
    left = part * sum(lengths)
    for (a, b), length in zip(pairwise(route), lengths, strict=True):
        if left <= length and length > 0:
            return (a[0] + (b[0] - a[0]) * left / length, a[1] + (b[1] - a[1]) * left / length)
        left -= length
    return route[-1]
