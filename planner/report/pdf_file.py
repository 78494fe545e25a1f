"""The dependency graph as a page of PDF for a paper, with its letters embedded (extra `pdf`)."""

import io
from collections.abc import Sequence
from typing import Any

from topple.planner.report.layout import Point
from topple.planner.report.palette import FIXED_COLOUR, Colour, reason_colour
from topple.planner.report.pen import INK, draw_graph
from topple.planner.report.svg_file import COLUMN, MARGIN, Document, PaperGraph
from topple.topology.errors import NotInstalled
from topple.topology.scene import Scene

POINTS = 84 / 25.4 * 72 / COLUMN
"""Points of a PDF in a pixel: `COLUMN` is 84 mm wide."""
FONT = "Vera"
"""It comes with ReportLab, as a file that can be embedded: publishers refuse letters that are not."""


def graph_pdf(scene: Scene, order: Document) -> bytes:
    """Draw the dependency graph of an order as `graph_file` does.

    Args:
        scene: The scene, for the colours that its page gives the objects.
        order: A `topple.order` document.

    Returns:
        The bytes of a PDF of one page, as large as the drawing; the same order gives the same bytes. Letters
        that Bitstream Vera lacks, such as Chinese ones, are left blank.

    Raises:
        NotInstalled: ReportLab is not installed.
    """
    paper = PaperGraph.of(scene, order)
    buffer = io.BytesIO()
    pen = _PdfPen(buffer, paper)
    draw_graph(pen, paper.graph, paper.colours, MARGIN, MARGIN)
    for reason, x, y in paper.keys:
        pen.line([(x, y), (x + 18, y)], reason_colour(reason), 3)
        pen.text(x + 24, y, reason)
    pen.canvas.save()
    return buffer.getvalue()


class _PdfPen:
    """Draws pixels, y downwards, on a page in points, y upwards."""

    def __init__(self, buffer: io.BytesIO, paper: PaperGraph) -> None:
        try:
            from reportlab.pdfbase import pdfmetrics, ttfonts
            from reportlab.pdfgen import canvas
        except ImportError as error:
            raise NotInstalled("a graph as PDF needs ReportLab (as .svg it needs nothing)", "pdf") from error
        pdfmetrics.registerFont(ttfonts.TTFont(FONT, f"{FONT}.ttf"))
        self.high = paper.height
        size = paper.width * POINTS, paper.height * POINTS
        sheet: Any = canvas.Canvas
        self.canvas: Any = sheet(buffer, size, invariant=1, initialFontName=FONT)
        self.canvas.setAuthor("")
        self.canvas.setTitle(paper.title)
        self.canvas.scale(POINTS, POINTS)
        self.canvas.setLineWidth(1)

    def line(self, points: Sequence[Point], colour: Colour, width: float, *, dashed: bool = False) -> None:
        self._colour(colour)
        self.canvas.setLineWidth(width)
        self.canvas.setDash([5, 4] if dashed else [])
        self.canvas.drawPath(self._path(points))
        self.canvas.setDash([])
        self.canvas.setLineWidth(1)

    def polygon(self, points: Sequence[Point], colour: Colour) -> None:
        self._colour(colour)
        self.canvas.drawPath(self._path(points), stroke=0, fill=1)

    def box(
        self, left: float, top: float, right: float, low: float, fill: Colour, edge: Colour | None = None
    ) -> None:
        self._colour(fill, edge or FIXED_COLOUR)
        self.canvas.rect(left, self.high - low, right - left, low - top, stroke=edge is not None, fill=1)

    def text(
        self, x: float, y: float, text: str, *, size: float = 13, colour: Colour = INK, anchor: str = "lm"
    ) -> None:
        self._colour(colour)
        self.canvas.setFont(FONT, size)
        write = self.canvas.drawCentredString if anchor == "mm" else self.canvas.drawString
        write(x, self.high - y - 0.36 * size, text)

    def width(self, text: str, size: float) -> float:
        return float(self.canvas.stringWidth(text, FONT, size))

    def _colour(self, fill: Colour, edge: Colour | None = None) -> None:
        self.canvas.setFillColorRGB(*(part / 255 for part in fill))
        self.canvas.setStrokeColorRGB(*(part / 255 for part in edge or fill))

    def _path(self, points: Sequence[Point]) -> Any:
        path = self.canvas.beginPath()
        for place, (x, y) in enumerate(points):
            (path.lineTo if place else path.moveTo)(x, self.high - y)
        return path
