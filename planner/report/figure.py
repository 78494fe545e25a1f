"""Pictures of one scene: surfaces, relations, graph and order as PNG; the order as a moving GIF."""

import io
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from functools import cache
from itertools import pairwise
from typing import TYPE_CHECKING, Any

import numpy as np

from topple.planner.decide.names import Colour, spoken
from topple.planner.decide.words import order_in_words, order_rows, ordinal, shorten
from topple.planner.formats.pictures import png
from topple.planner.report.drawing import Document, Documented, Drawing, DrawnObject, document, view_data
from topple.planner.report.graph import BADGE, HIGH, DrawnGraph, Point, arrow_head
from topple.planner.report.html import legend
from topple.planner.report.limits import LIMITS
from topple.planner.report.palette import FIXED_COLOUR, ink_on, reason_colour, relation_colour
from topple.planner.report.raster import Projection, render_clouds
from topple.planner.report.show import with_look
from topple.topology.base.arrays import FloatArray
from topple.topology.base.errors import InvalidInput
from topple.topology.scene.scene import Scene

if TYPE_CHECKING:
    from PIL import Image

PAPER: Colour = (255, 255, 255)
INK: Colour = (28, 30, 33)
SOFT: Colour = (93, 97, 103)
LINE: Colour = (217, 217, 213)
WIDTH, HEIGHT, SIDE, ROW = 1000, 780, 620, 19  # [px]: the view, the column beside it, a line of words
FINE = 2  # everything is drawn this many times larger and then shrunk, which smooths lines and text
SIZE = (640, 480)  # width and height of a moving picture [px], without the words below
RISE, LIFT = 6, 0.9  # pictures in which an object rises, and how far, in radii of the scene
WAITS = (1400, 70, 2200)  # [ms] that a picture stands: before something is taken, as it rises, at the end


def show_picture(
    scene: Scene, relations: Documented | Document, order: Documented | Document | None = None
) -> bytes:
    """Draw a scene as a PNG picture, in the colours of the page, as high as graph and order need.

    Args:
        scene: The scene; `up` may be unknown.
        relations: What `relate` found in it, or the JSON document of that.
        order: What `order` found, or the JSON document of that; None draws the relations alone.
    """
    both = document(relations), None if order is None else document(order)
    scene, (found, planned) = spoken(scene, (scene, both))
    planned = None if planned is None else with_look(scene, planned)
    drawing = Drawing.of(scene)
    view = draw_view(drawing, view_data(drawing, found, planned))
    if planned is None:
        return side_by_side(view)
    return side_by_side(view, _graph(scene, drawing, planned), _order(drawing, planned))


def side_by_side(view: "Image.Image", *column: "Image.Image") -> bytes:
    """A view and what is drawn in the column at its right, one below the other, as PNG."""
    size = WIDTH + SIDE * bool(column), max(view.height, sum(part.height for part in column)) // FINE
    whole, low = _Pen(*size).image, 0
    whole.paste(view, (0, 0))
    for part in column:
        whole.paste(part, (view.width, low))
        low += part.height
    return png(whole.resize(size))


def order_gif(
    scene: Scene, order: Documented | Document, progress: Callable[[str], None] | None = None
) -> bytes:
    """Animate an order as a GIF: before each object rises and is gone, which one and why.

    Args:
        scene: The scene.
        order: What `order` found in it, or the JSON document of that.
        progress: Called with a line before each object is drawn.

    Raises:
        InvalidInput: The order takes nothing.
    """
    scene, planned = spoken(scene, (scene, document(order)))
    told = order_in_words(planned)
    if not told:
        raise InvalidInput("nothing to animate: the order takes nothing")
    drawing = Drawing.of(scene, LIMITS.cell_points)
    fine, coarse = (Projection(drawing, SIZE[0] * scale, SIZE[1] * scale) for scale in (FINE, 1))
    frames: list[tuple[Image.Image, int]] = []
    left = {drawn.name: drawn for drawn in drawing.objects}
    for place, (name, why) in enumerate(told, start=1):
        if name not in left:  # it made room before
            continue
        words = f"{place}. {name}: {why}"
        if progress is not None:
            progress(f"drawing how {name} is taken: {place} of {len(told)}")
        frames.append((_frame(drawing, [*left.values()], fine, words), WAITS[0]))
        taken = left.pop(name)
        for step in range(1, RISE):
            way = drawing.up * LIFT * drawing.radius * (step / RISE) ** 2
            lifted = replace(taken, points=taken.points + way)
            frames.append((_frame(drawing, [*left.values(), lifted], coarse, words), WAITS[1]))
    frames.append((_frame(drawing, drawing.objects, fine, f"Order: {', '.join(dict(told))}."), WAITS[2]))
    first, *others = (picture.quantize(128) for picture, _ in frames)
    waits, buffer = [wait for _, wait in frames], io.BytesIO()
    first.save(buffer, "GIF", save_all=True, append_images=others, duration=waits, loop=0, optimize=True)
    return buffer.getvalue()


def _frame(
    drawing: Drawing, objects: Sequence[DrawnObject], projection: Projection, words: str
) -> "Image.Image":
    """One picture of a moving one, with up to two lines of words under it."""
    from PIL import Image

    shown = replace(drawing, objects=tuple(objects))
    pixels = render_clouds(shown, projection, PAPER) if objects else None
    pen = _Pen(SIZE[0], SIZE[1] + 52)
    for row, line in enumerate(_wrap(words, SIZE[0] - 32.0, 13)[:2]):
        pen.text(16, SIZE[1] + 16 + ROW * row, line)
    whole = pen.image.resize((SIZE[0], SIZE[1] + 52), Image.Resampling.LANCZOS)
    view = _Pen(*SIZE, pixels).image
    whole.paste(view.resize(SIZE, Image.Resampling.LANCZOS), (0, 0))
    return whole


class _Pen:
    """Draws in the coordinates of the final picture, y downwards."""

    def __init__(self, width: int, height: int, pixels: Any = None) -> None:
        from PIL import Image, ImageDraw

        size = (width * FINE, height * FINE)
        self.image = Image.new("RGB", size, PAPER) if pixels is None else Image.fromarray(pixels)
        self.draw = ImageDraw.Draw(self.image)

    def line(self, points: Sequence[Point], colour: Colour, width: float, *, dashed: bool = False) -> None:
        for part in _dashes(points) if dashed else [points]:
            self.draw.line(_fine(part), fill=colour, width=round(width * FINE))

    def polygon(self, points: Sequence[Point], colour: Colour) -> None:
        self.draw.polygon(_fine(points), fill=colour)

    def box(
        self, left: float, top: float, right: float, low: float, fill: Colour, edge: Colour | None = None
    ) -> None:
        self.draw.rectangle(_fine([(left, top), (right, low)]), fill=fill, outline=edge, width=FINE)

    def text(
        self, x: float, y: float, text: str, *, size: float = 13, colour: Colour = INK, anchor: str = "lm"
    ) -> None:
        """Write a line, its middle at `y`: from `x` to the right ("lm"), or about `x` ("mm")."""
        self.draw.text((x * FINE, y * FINE), text, fill=colour, font=_font(size), anchor=anchor)


def _fine(points: Sequence[Point]) -> list[Point]:
    return [(x * FINE, y * FINE) for x, y in points]


def _dashes(points: Sequence[Point]) -> Iterator[list[Point]]:
    """The dashes of a line: six pixels, and five between them."""
    for (x, y), (u, v) in pairwise(points):
        length = max(float(np.hypot(u - x, v - y)), 1e-6)
        for begin in np.arange(0.0, length, 11.0).tolist():
            shares = [min(at / length, 1.0) for at in (begin, begin + 6.0)]
            yield [(x + (u - x) * share, y + (v - y) * share) for share in shares]


@cache
def _font(size: float) -> Any:
    from PIL import ImageFont

    return ImageFont.load_default(size=size * FINE)


def _width(text: str, size: float) -> float:
    return float(_font(size).getlength(text)) / FINE


def _wrap(text: str, width: float, size: float) -> list[str]:
    """A text in lines of at most a width [px]."""
    lines = [""]
    for word in text.split():
        longer = f"{lines[-1]} {word}".strip()
        if lines[-1] and _width(longer, size) > width:
            lines.append(word)
        else:
            lines[-1] = longer
    return lines


def draw_view(drawing: Drawing, data: dict[str, Any]) -> "Image.Image":
    """The 3-D view: surfaces, relation lines or other arrows, names, legend."""
    projection = Projection(drawing, WIDTH, HEIGHT)
    surfaces = render_clouds(drawing, Projection(drawing, WIDTH * FINE, HEIGHT * FINE), PAPER)
    pen = _Pen(WIDTH, HEIGHT, surfaces)
    for line in data["relations"]:
        _draw_relation(pen, projection, drawing, line)
    for arrow in data.get("arrows", ()):
        _draw_arrow(pen, projection, arrow)
    _draw_names(pen, projection, drawing, data["places"])
    pen.box(0, HEIGHT - 36, WIDTH, HEIGHT, PAPER)
    x, y = 16.0, HEIGHT - 20.0
    for word, colour in legend(data).items():
        pen.line([(x, y), (x + 20, y)], colour, 3)
        pen.text(x + 26, y, word, size=12, colour=SOFT)
        x += 44 + _width(word, 12)
    lines = (
        "hatched: guessed" if "arrows" in data else "disjoint: no line; dashed: inferred; hatched: guessed"
    )
    pen.text(x, y, lines, size=12, colour=SOFT)
    return pen.image


def _draw_arrow(pen: _Pen, projection: Projection, arrow: dict[str, Any]) -> None:
    ends, depth = projection.pixels(np.array([arrow["from"], arrow["to"]]))
    if np.isfinite(depth).all():
        (x, y), (u, v) = ends.tolist()
        red, green, blue = bytes.fromhex(arrow["colour"].lstrip("#"))
        pen.line([(x, y), (u, v)], (red, green, blue), 2.4)
        if np.hypot(u - x, v - y) > 9:
            pen.polygon(arrow_head([(x, y), (u, v)], 9.0), (red, green, blue))


def _draw_relation(pen: _Pen, projection: Projection, drawing: Drawing, line: dict[str, Any]) -> None:
    a, b = drawing.objects[line["a"]], drawing.objects[line["b"]]
    places, depth = projection.pixels(np.stack([_anchor(drawing, a, b), _anchor(drawing, b, a)]))
    if not np.isfinite(depth).all():
        return
    (x, y), (u, v) = places.tolist()
    colour, width = relation_colour(line["relation"]), 1.2 if line["faint"] else 2.4
    pen.line([(x, y), (u, v)], colour, width, dashed=line["dashed"])
    if not line["faint"] and np.hypot(u - x, v - y) > 18:
        pen.polygon(arrow_head([(x, y), (x + (u - x) * 0.62, y + (v - y) * 0.62)], 9.0), colour)


def _anchor(drawing: Drawing, drawn: DrawnObject, other: DrawnObject) -> FloatArray:
    """A line to a table ends below or beside the other object, not at the middle of the table."""
    if not drawn.fixed or other.fixed:
        return drawn.centre
    return other.centre + drawing.up * float((drawn.centre - other.centre) @ drawing.up)


def _draw_names(pen: _Pen, projection: Projection, drawing: Drawing, places: list[int] | None) -> None:
    """Names with their place in the order, near objects first; one that would cover another is left out."""
    taken: list[tuple[float, float, float]] = []
    at, depth = projection.pixels(np.stack([drawn.top for drawn in drawing.objects]))
    for number in np.argsort(depth):
        drawn = drawing.objects[number]
        if drawn.fixed or not np.isfinite(depth[number]):
            continue
        place, name = places[number] if places else 0, shorten(drawn.name)
        badge = max(18.0, _width(ordinal(place), 12) + 10) if place else 4.0
        width = badge + _width(name, 12) + 10
        left, low = float(at[number, 0]) - width / 2, float(at[number, 1])
        if any(left < x + w and x < left + width and abs(low - y) < ROW for x, y, w in taken):
            continue
        taken.append((left, low, width))
        pen.box(left, low - 18, left + width, low, PAPER)
        pen.box(left, low - 18, left + badge, low, drawn.colour)
        pen.text(left + badge + 5, low - 9, name, size=12)
        if place:
            ink = ink_on(drawn.colour)
            pen.text(left + badge / 2, low - 9, ordinal(place), size=12, colour=ink, anchor="mm")


def _graph(scene: Scene, drawing: Drawing, order: Document) -> "Image.Image":
    """The dependency graph, shrunk to the column where it is wider."""
    graph = DrawnGraph.of(scene.movable, order, row=SIDE - 40.0)
    shrink = min(1.0, (SIDE - 40) / graph.width)
    pen = _Pen(SIDE, round(56 + graph.height * shrink))
    pen.text(16, 26, "Dependency graph: an arrow from a to b says a goes before b", colour=SOFT)

    def shrunk_point(point: Point) -> Point:
        return 16 + point[0] * shrink, 46 + point[1] * shrink

    for edge, route in graph.routes.items():
        colour, points = reason_colour(graph.reasons[edge][0]), [shrunk_point(point) for point in route]
        pen.line(points, colour, 1.6, dashed=graph.confidence[edge] < 0.5)
        pen.polygon(arrow_head(points, 8 * shrink), colour)
    size = max(7.0, 11 * shrink)  # smaller letters cannot be read
    for edge, centre in graph.labels.items():
        (x, y), text = shrunk_point(centre), graph.label(edge)
        half = _width(text, size) / 2 + 2
        pen.box(x - half, y - size / 2, x + half, y + size / 2, PAPER)
        pen.text(x, y, text, size=size, colour=reason_colour(graph.reasons[edge][0]), anchor="mm")
    size, badge, colours = max(7.0, 12 * shrink), BADGE * shrink, drawing.colours
    for name, (across, down, width) in graph.boxes.items():
        (x, y), half, high = shrunk_point((across, down)), width / 2 * shrink, HIGH / 2 * shrink
        pen.box(x - half, y - high, x + half, y + high, PAPER, INK if name in graph.targets else LINE)
        pen.box(x - half, y - high, x - half + badge, y + high, paint := colours.get(name, FIXED_COLOUR))
        if name in graph.places:
            place = ordinal(graph.places[name])
            pen.text(x - half + badge / 2, y, place, size=size, colour=ink_on(paint), anchor="mm")
        pen.text(x + badge / 2, y, shorten(name), size=size, anchor="mm")
    return pen.image


def _order(drawing: Drawing, order: Document) -> "Image.Image":
    """The order in words, and what has none."""
    lines: list[tuple[Colour | None, str]] = []
    for place, name, why, _ in order_rows(order):
        lines.append((drawing.colours.get(name, FIXED_COLOUR), f"{place}. {shorten(name)}: {why}"))
    for cycle in order.get("unresolved", ()):
        names = cycle if isinstance(cycle, str) else ", ".join(str(name) for name in cycle)
        lines.append((None, f"No safe order among {names}."))
    return draw_list("Safe order", lines)


def draw_list(title: str, lines: Sequence[tuple[Colour | None, str]]) -> "Image.Image":
    """A column of sentences, wrapped, each with its colour before it where it has one."""
    wrapped = [(colour, _wrap(text, SIDE - 60.0, 12.5)) for colour, text in lines]
    pen, y = _Pen(SIDE, 62 + ROW * sum(len(texts) for _, texts in wrapped)), 46
    pen.text(16, 18, title, size=15)
    for colour, texts in wrapped:
        if colour:
            pen.box(16, y - 7, 30, y + 7, colour)
        for text in texts:
            pen.text(38, y, text, size=12.5)
            y += ROW
    return pen.image
