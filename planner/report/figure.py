"""The picture of one scene: surfaces and relation lines at the left, graph and order at the right."""

from collections.abc import Iterator, Sequence
from functools import cache
from itertools import pairwise
from typing import TYPE_CHECKING, Any

import numpy as np

from topple.planner.formats.pictures import png
from topple.planner.report.drawing import Drawing, DrawnObject
from topple.planner.report.graph import DrawnGraph, arrow_head
from topple.planner.report.layout import Point
from topple.planner.report.palette import FIXED_COLOUR, RELATION_COLOURS, Colour, ink_on
from topple.planner.report.pen import INK, PAPER, draw_graph
from topple.planner.report.raster import Projection, render_clouds
from topple.planner.report.view import Document, Documented, document, object_index, view_data
from topple.planner.report.words import order_in_words, ordinal, shortened
from topple.topology.arrays import FloatArray
from topple.topology.scene import Scene

if TYPE_CHECKING:
    from PIL import Image

SOFT: Colour = (93, 97, 103)
WIDTH, HEIGHT, SIDE = 1000, 780, 620
"""Size of the view and width of the column beside it [px]."""
FINE = 2
"""Everything is drawn this many times larger and then shrunk, which smooths lines and text."""


def show_picture(
    scene: Scene, relations: Documented | Document, order: Documented | Document | None = None
) -> bytes:
    """Draw a scene as a PNG picture, in the colours of the page.

    Args:
        scene: The scene; `up` may be unknown.
        relations: What `relate` found in it, or the JSON document of that.
        order: What `order` found, or the JSON document of that; None draws the relations alone.

    Returns:
        The bytes of a PNG file, 780 pixels high or higher where graph and order need it.
    """
    found = document(relations)
    planned = None if order is None else document(order)
    drawing = Drawing.of(scene)
    view = _view(drawing, view_data(drawing, found, planned))
    if planned is None:
        return png(view.resize((WIDTH, HEIGHT)))
    return png(_composed(view, _graph_image(scene, drawing, planned), drawing, planned))


def _composed(view: "Image.Image", graph: "Image.Image", drawing: Drawing, order: Document) -> "Image.Image":
    """View at the left, graph at the right; the order below the graph, or below the view where it is long."""
    from PIL import Image

    words = _order_image(drawing, order, SIDE)
    place = (view.width, graph.height)
    if graph.height + words.height > view.height:
        words, place = _order_image(drawing, order, WIDTH), (0, view.height)
    height = max(view.height, graph.height, place[1] + words.height)
    whole = Image.new("RGB", (view.width + graph.width, height), PAPER)
    whole.paste(view, (0, 0))
    whole.paste(graph, (view.width, 0))
    whole.paste(words, place)
    return whole.resize((whole.width // FINE, height // FINE))


def caption(picture: "Image.Image", words: str) -> "Image.Image":
    """A picture with up to two lines of words under it."""
    from PIL import Image

    lines = _wrapped(words, picture.width - 32.0)[:2]
    below = Image.new("RGB", (picture.width * FINE, 52 * FINE), PAPER)
    pen = _Pen(below)
    for row, line in enumerate(lines):
        pen.text(16, 16 + 19 * row, line, size=13)
    whole = Image.new("RGB", (picture.width, picture.height + 52), PAPER)
    whole.paste(picture, (0, 0))
    whole.paste(below.resize((picture.width, 52), Image.Resampling.LANCZOS), (0, picture.height))
    return whole


class _Pen:
    """Draws in the coordinates of the final picture."""

    def __init__(self, image: "Image.Image") -> None:
        from PIL import ImageDraw

        self.draw: ImageDraw.ImageDraw = ImageDraw.Draw(image)

    def line(self, points: Sequence[Point], colour: Colour, width: float, *, dashed: bool = False) -> None:
        for part in _dashes(points) if dashed else [points]:
            self.draw.line([(x * FINE, y * FINE) for x, y in part], fill=colour, width=round(width * FINE))

    def polygon(self, points: Sequence[Point], colour: Colour) -> None:
        self.draw.polygon([(x * FINE, y * FINE) for x, y in points], fill=colour)

    def box(
        self, left: float, top: float, right: float, low: float, fill: Colour, edge: Colour | None = None
    ) -> None:
        corners = [(left * FINE, top * FINE), (right * FINE, low * FINE)]
        self.draw.rectangle(corners, fill=fill, outline=edge, width=FINE)

    def text(
        self, x: float, y: float, text: str, *, size: float = 13, colour: Colour = INK, anchor: str = "lm"
    ) -> None:
        self.draw.text((x * FINE, y * FINE), text, fill=colour, font=_font(size), anchor=anchor)

    def width(self, text: str, size: float) -> float:
        return float(_font(size).getlength(text)) / FINE


def _dashes(points: Sequence[Point], dash: float = 6.0, gap: float = 5.0) -> Iterator[list[Point]]:
    """The dashes [px] of a line."""
    for start, end in pairwise(np.asarray(points, dtype=np.float64)):
        length = max(float(np.linalg.norm(end - start)), 1e-6)
        for begin in np.arange(0.0, length, dash + gap):
            parts = (start + (end - start) * min(at / length, 1.0) for at in (begin, begin + dash))
            yield [_point(part) for part in parts]


@cache
def _font(size: float) -> Any:
    from PIL import ImageFont

    return ImageFont.load_default(size=size * FINE)


def _width(text: str, size: float) -> float:
    return float(_font(size).getlength(text)) / FINE


def _view(drawing: Drawing, data: dict[str, Any]) -> "Image.Image":
    """The 3-D view: surfaces, relation lines with arrows, names, legend."""
    from PIL import Image

    projection = Projection(drawing, WIDTH, HEIGHT)
    image = Image.fromarray(render_clouds(drawing, Projection(drawing, WIDTH * FINE, HEIGHT * FINE), PAPER))
    pen = _Pen(image)
    for line in data["relations"]:
        _draw_relation(pen, projection, drawing, line)
    _draw_names(pen, projection, drawing, data["places"])
    _draw_legend(pen)
    return image


def _draw_relation(pen: _Pen, projection: Projection, drawing: Drawing, line: dict[str, Any]) -> None:
    a, b = drawing.objects[line["a"]], drawing.objects[line["b"]]
    places, depth = projection.pixels(np.stack([_anchor(drawing, a, b), _anchor(drawing, b, a)]))
    if not np.isfinite(depth).all():
        return
    colour = _rgb(line["colour"])
    start, end = places
    width = 1.2 if line["faint"] else 2.4
    pen.line([_point(start), _point(end)], colour, width, dashed=line["dashed"])
    length = float(np.linalg.norm(end - start))
    if not line["faint"] and length > 18:
        middle = start + (end - start) * 0.62
        pen.polygon(arrow_head([_point(start), _point(middle)], 9.0), colour)


def _anchor(drawing: Drawing, drawn: DrawnObject, other: DrawnObject) -> FloatArray:
    """A line to a table ends below or beside the other object, not at the middle of the table."""
    if not drawn.fixed or other.fixed:
        return drawn.centre
    return other.centre + drawing.up * float((drawn.centre - other.centre) @ drawing.up)


def _draw_names(pen: _Pen, projection: Projection, drawing: Drawing, places: list[int] | None) -> None:
    """Names with their place in the order, near objects first; one that would cover another is left out."""
    taken: list[tuple[float, float, float, float]] = []
    at, depth = projection.pixels(np.stack([drawn.top for drawn in drawing.objects]))
    for number in np.argsort(depth):
        drawn = drawing.objects[number]
        if drawn.fixed or not np.isfinite(depth[number]):
            continue
        place = places[number] if places else 0
        name = shortened(drawn.name)
        badge = max(18.0, _width(ordinal(place), 12) + 10) if place else 4.0
        width = badge + _width(name, 12) + 10
        left, top = float(at[number, 0]) - width / 2, float(at[number, 1]) - 18
        if any(
            abs(left - x) < (w + width) / 2 + abs(w - width) / 2 and abs(top - y) < 19 for x, y, w, _ in taken
        ):
            continue
        taken.append((left, top, width, 18.0))
        pen.box(left, top, left + width, top + 18, PAPER)
        pen.box(left, top, left + badge, top + 18, drawn.colour)
        pen.text(left + badge + 5, top + 9, name, size=12)
        if place:
            pen.text(
                left + badge / 2, top + 9, ordinal(place), size=12, colour=ink_on(drawn.colour), anchor="mm"
            )


def _draw_legend(pen: _Pen) -> None:
    x = 16.0
    pen.box(0, HEIGHT - 36, WIDTH, HEIGHT, PAPER)
    for relation, colour in RELATION_COLOURS.items():
        if relation == "disjoint":
            continue
        pen.line([(x, HEIGHT - 20), (x + 20, HEIGHT - 20)], colour, 3)
        pen.text(x + 26, HEIGHT - 20, str(relation), size=12, colour=SOFT)
        x += 44 + _width(str(relation), 12)
    pen.text(x, HEIGHT - 20, "disjoint: no line; dashed: inferred; hatched: guessed", size=12, colour=SOFT)


def _graph_image(scene: Scene, drawing: Drawing, order: Document) -> "Image.Image":
    """The dependency graph, shrunk to the column where it is wider."""
    from PIL import Image

    graph = DrawnGraph.of(scene.movable, order, row=SIDE - 40.0)
    shrink = min(1.0, (SIDE - 40) / max(graph.layout.width, 1.0))
    height = round(46 + graph.layout.height * shrink + 10)
    image = Image.new("RGB", (SIDE * FINE, height * FINE), PAPER)
    pen = _Pen(image)
    pen.text(16, 26, "Dependency graph: an arrow from a to b says a goes before b", size=13, colour=SOFT)
    draw_graph(pen, graph, {drawn.name: drawn.colour for drawn in drawing.objects}, 16, 46, shrink)
    return image


def _order_image(drawing: Drawing, order: Document, width: int) -> "Image.Image":
    """The order in words, wrapped to a width [px]."""
    from PIL import Image

    colours = {drawn.name: drawn.colour for drawn in drawing.objects}
    lines = _order_lines(order, object_index(drawing), width - 60.0)
    image = Image.new("RGB", (width * FINE, (62 + 19 * len(lines)) * FINE), PAPER)
    pen = _Pen(image)
    pen.text(16, 18, "Safe order", size=15)
    for row, (name, text) in enumerate(lines):
        y = 46 + 19 * row
        if name:
            pen.box(16, y - 7, 30, y + 7, colours.get(name, FIXED_COLOUR))
        pen.text(38, y, text, size=12.5)
    return image


def _order_lines(order: Document, known: dict[str, int], width: float) -> list[tuple[str, str]]:
    """Lines of the order wrapped to a width; the first of each object carries its name."""
    lines: list[tuple[str, str]] = []
    for place, (name, sentence) in enumerate(order_in_words(order), start=1):
        for row, text in enumerate(_wrapped(f"{place}. {shortened(name)}: {sentence}", width)):
            lines.append((name if row == 0 and name in known else "", text))
    for cycle in order.get("unresolved", ()):
        names = [cycle] if isinstance(cycle, str) else [str(name) for name in cycle]
        lines += [("", text) for text in _wrapped("No safe order among " + ", ".join(names) + ".", width)]
    return lines


def _wrapped(text: str, width: float) -> list[str]:
    lines = [""]
    for word in text.split():
        longer = f"{lines[-1]} {word}".strip()
        if _width(longer, 12.5) <= width or not lines[-1]:
            lines[-1] = longer
        else:
            lines.append(word)
    return lines


def _point(place: FloatArray) -> Point:
    return float(place[0]), float(place[1])


def _rgb(colour: str) -> Colour:
    return int(colour[1:3], 16), int(colour[3:5], 16), int(colour[5:7], 16)
