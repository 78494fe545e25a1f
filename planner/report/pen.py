"""A pen, and the dependency graph drawn with it: in a picture or on the page of a PDF."""

from collections.abc import Mapping, Sequence
from typing import Protocol

from topple.planner.report.graph import DrawnGraph, arrow_head
from topple.planner.report.layout import BADGE, NODE_HEIGHT, Point
from topple.planner.report.palette import FIXED_COLOUR, Colour, ink_on, reason_colour
from topple.planner.report.words import ordinal

PAPER: Colour = (255, 255, 255)
INK: Colour = (28, 30, 33)
LINE: Colour = (217, 217, 213)
SMALLEST = 7.0
"""Height below which letters are not shrunk [px]."""


class Pen(Protocol):
    """Draws in pixels of the final drawing, y downwards."""

    def line(self, points: Sequence[Point], colour: Colour, width: float, *, dashed: bool = False) -> None:
        """Draw a line through points."""
        ...

    def polygon(self, points: Sequence[Point], colour: Colour) -> None:
        """Fill a polygon."""
        ...

    def box(
        self, left: float, top: float, right: float, low: float, fill: Colour, edge: Colour | None = None
    ) -> None:
        """Fill a rectangle, with a line around it where `edge` gives its colour."""
        ...

    def text(
        self, x: float, y: float, text: str, *, size: float = 13, colour: Colour = INK, anchor: str = "lm"
    ) -> None:
        """Write a line of text, its middle at `y`: from `x` to the right ("lm"), or about `x` ("mm")."""
        ...

    def width(self, text: str, size: float) -> float:
        """How wide a text is."""
        ...


def draw_graph(
    pen: Pen, graph: DrawnGraph, colours: Mapping[str, Colour], left: float, top: float, shrink: float = 1.0
) -> None:
    """Draw a dependency graph.

    Args:
        pen: What to draw with.
        graph: The graph.
        colours: Object -> colour of the field with its place in the order.
        left: Left edge of the drawing [px].
        top: Upper edge of the drawing [px].
        shrink: Scale of the drawing.
    """

    def placed(point: Point) -> Point:
        return left + point[0] * shrink, top + point[1] * shrink

    for edge, route in graph.layout.routes.items():
        colour = reason_colour(graph.reasons[edge][0])
        points = [placed(point) for point in route]
        pen.line(points, colour, 1.6, dashed=graph.confidence[edge] < 0.5)
        pen.polygon(arrow_head(points, 8 * shrink), colour)
    size = max(SMALLEST, 11 * shrink)
    for edge, centre in graph.layout.labels.items():
        text = ", ".join(graph.reasons[edge])
        x, y = placed(centre)
        half = pen.width(text, size) / 2 + 2
        pen.box(x - half, y - size / 2, x + half, y + size / 2, PAPER)
        pen.text(x, y, text, size=size, colour=reason_colour(graph.reasons[edge][0]), anchor="mm")
    size = max(SMALLEST, 12 * shrink)
    for name, centre in graph.layout.centres.items():
        (x, y), half, high = placed(centre), graph.layout.widths[name] / 2 * shrink, NODE_HEIGHT / 2 * shrink
        badge, paint = BADGE * shrink, colours.get(name, FIXED_COLOUR)
        pen.box(x - half, y - high, x + half, y + high, PAPER, INK if name in graph.targets else LINE)
        pen.box(x - half, y - high, x - half + badge, y + high, paint)
        if name in graph.places:
            place = ordinal(graph.places[name])
            pen.text(x - half + badge / 2, y, place, size=size, colour=ink_on(paint), anchor="mm")
        pen.text(x + badge / 2, y, graph.labels[name], size=size, anchor="mm")
