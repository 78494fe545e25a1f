"""The dependency graph as a file for a paper: an SVG that stands alone, drawn in black on white."""

from collections.abc import Mapping
from html import escape
from typing import Any

from topple.planner.report.graph import DrawnGraph, graph_svg
from topple.planner.report.palette import css, object_colours, reason_colour
from topple.planner.report.words import listed
from topple.topology.scene import Scene

Document = Mapping[str, Any]

COLUMN = 640.0
"""Width at which rows wrap [px]; scaled to a column of 84 mm the text is 7 pt high, as captions are."""
MARGIN = 8.0
"""White around the drawing [px]."""
ROW = 20.0
"""Height of the legend [px]."""
STYLE = (
    "text{font:13px Helvetica,Arial,'DejaVu Sans',sans-serif;fill:#111;text-anchor:middle}"
    "text.place{font-size:12px;font-weight:bold}.box{fill:#fff;stroke:#999}"
    ".target .box{stroke:#111;stroke-width:2}"
    "text.reason{font-size:12px;stroke:#fff;stroke-width:4px;paint-order:stroke}text.key{text-anchor:start}"
)


def graph_file(scene: Scene, order: Document) -> str:
    """Draw the dependency graph of an order.

    Args:
        scene: The scene, for the colours that its page gives the objects.
        order: A `topple.order` document.

    Returns:
        An SVG document without scripts, fetched fonts or links; each arrow's and box's title says what it is.
    """
    graph = DrawnGraph.of(scene.movable, order, row=COLUMN)
    colours = object_colours(scene.names, scene.fixed)
    drawn = graph_svg(graph, colours, {}).partition("</svg>")[0].partition(">")[2]
    used = list(dict.fromkeys(reason for reasons in graph.reasons.values() for reason in reasons))
    keys, x = "", 0.0
    for reason in used:
        keys += (
            f'<rect x="{x:.0f}" y="6" width="18" height="3" fill="{css(reason_colour(reason))}"/>'
            f'<text class="key" x="{x + 24:.0f}" y="12">{escape(reason)}</text>'
        )
        x += 44 + 8.0 * len(reason)
    width = max(graph.layout.width, x) + 2 * MARGIN
    height = graph.layout.height + ROW * bool(used) + 2 * MARGIN
    taken = [name for name in graph.places]
    title = f"Dependency graph: take {listed(taken)}" if taken else "Dependency graph"
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{width:.0f}" height="{height:.0f}" '
        f'viewBox="0 0 {width:.0f} {height:.0f}"><title>{escape(title)}</title><style>{STYLE}</style>'
        '<rect width="100%" height="100%" fill="#fff"/>'
        f'<g transform="translate({MARGIN:.0f} {MARGIN:.0f})">{drawn}</g>'
        f'<g transform="translate({MARGIN:.0f} {MARGIN + graph.layout.height:.0f})">{keys}</g></svg>\n'
    )
