"""The dependency graph as a file for a paper: an SVG that stands alone, drawn in black on white."""

from collections.abc import Mapping
from dataclasses import dataclass
from html import escape
from typing import Any

from topple.planner.report.graph import DrawnGraph, graph_shapes
from topple.planner.report.palette import Colour, css, object_colours, reason_colour
from topple.planner.report.words import listed
from topple.topology.scene import Scene

Document = Mapping[str, Any]

COLUMN = 440.0
"""Width at which rows wrap [px]; scaled to a column of 84 mm the text is 7 pt high, as captions are."""
MARGIN = 8.0
"""White around the drawing [px]."""
ROW = 20.0
"""Height of a row of the legend [px]."""
STYLE = (
    "text{font:13px Helvetica,Arial,'DejaVu Sans',sans-serif;fill:#111;text-anchor:middle}"
    "text.place{font-size:12px;font-weight:bold}.box{fill:#fff;stroke:#999}"
    ".target .box{stroke:#111;stroke-width:2}"
    "text.reason{font-size:12px;stroke:#fff;stroke-width:4px;paint-order:stroke}text.key{text-anchor:start}"
)


@dataclass(frozen=True, eq=False)
class PaperGraph:
    """A dependency graph on a sheet of its own, in pixels.

    Attributes:
        graph: The graph; it begins `MARGIN` below and beside the sheet's corner.
        colours: Object -> its colour.
        keys: Each reason in the graph, and where its line in the legend begins: (reason, x, y).
        width: Width of the sheet.
        height: Height of the sheet.
        title: What the sheet shows, in words.
    """

    graph: DrawnGraph
    colours: Mapping[str, Colour]
    keys: tuple[tuple[str, float, float], ...]
    width: float
    height: float
    title: str

    @staticmethod
    def of(scene: Scene, order: Document) -> "PaperGraph":
        """Lay out the graph of an order, with a legend below it."""
        graph = DrawnGraph.of(scene.movable, order, row=COLUMN)
        wide, x, y = max(graph.layout.width, COLUMN), MARGIN, MARGIN + graph.layout.height
        keys: list[tuple[str, float, float]] = []
        for reason in dict.fromkeys(reason for reasons in graph.reasons.values() for reason in reasons):
            long = 44 + 8.0 * len(reason)
            if x + long > wide + MARGIN:
                x, y = MARGIN, y + ROW
            keys.append((reason, x, y + 8))
            x += long
        width = max(graph.layout.width, max((key[1] + 44 + 8.0 * len(key[0]) for key in keys), default=0.0))
        title = f"Dependency graph: take {listed(list(graph.places))}" if graph.places else "Dependency graph"
        colours = object_colours(scene.names, scene.fixed)
        return PaperGraph(
            graph, colours, tuple(keys), width + 2 * MARGIN, y + ROW * bool(keys) + MARGIN, title
        )


def graph_file(scene: Scene, order: Document) -> str:
    """Draw the dependency graph of an order.

    Args:
        scene: The scene, for the colours that its page gives the objects.
        order: A `topple.order` document.

    Returns:
        An SVG document without scripts, fetched fonts or links; each arrow's and box's title says what it is.
    """
    paper = PaperGraph.of(scene, order)
    drawn = graph_shapes(paper.graph, paper.colours, {})
    keys = "".join(
        f'<rect x="{x:.0f}" y="{y - 1.5:.1f}" width="18" height="3" fill="{css(reason_colour(reason))}"/>'
        f'<text class="key" x="{x + 24:.0f}" y="{y + 4.5:.1f}">{escape(reason)}</text>'
        for reason, x, y in paper.keys
    )
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{paper.width:.0f}" height="{paper.height:.0f}" '
        f'viewBox="0 0 {paper.width:.0f} {paper.height:.0f}"><title>{escape(paper.title)}</title>'
        f'<style>{STYLE}</style><rect width="100%" height="100%" fill="#fff"/>'
        f'<g transform="translate({MARGIN:.0f} {MARGIN:.0f})">{drawn}</g>{keys}</svg>\n'
    )
