"""The frame of a page: assets inlined, data embedded, nothing fetched from anywhere."""

import json
from collections.abc import Collection, Sequence
from html import escape
from importlib.resources import files
from typing import Any

from topple.planner.report.palette import RELATION_COLOURS, css

Motion = Sequence[tuple[str, float, float]]
"""What an arm does: the word for it, from when and until when [s]."""

_LETTER = 0.016
"""Share of a time line that a letter takes: a name with less room is left to the tooltip."""

_LINES = (
    " Solid lines were observed, dashed ones inferred; disjoint pairs have no line, or a grey one where one "
    "side alone shows contact."
)

_POLICY = "default-src 'none'; style-src 'unsafe-inline'; script-src 'unsafe-inline'; img-src data:"
"""What a page may load: what it carries itself."""


def page(title: str, body: str, data: Any, scripts: Sequence[str], *, compact: bool = False) -> str:
    """Build one self-contained page.

    Args:
        title: Plain text of the title.
        body: HTML inside `<body>`.
        data: What the scripts read, embedded as JSON under the id `data`.
        scripts: Names of JavaScript assets, in the order they run.
        compact: Without margins and in smaller letters, for a notebook's cell.

    Returns:
        The page. Its content security policy forbids every network access.
    """
    code = "\n".join(asset(name) for name in scripts)
    return (
        '<!doctype html>\n<html lang="en"><head><meta charset="utf-8">'
        '<meta name="viewport" content="width=device-width, initial-scale=1">'
        '<meta name="color-scheme" content="light dark">'
        f'<meta http-equiv="Content-Security-Policy" content="{_POLICY}">'
        f"<title>{escape(title)}</title><style>\n{asset('page.css')}</style></head>\n"
        f"<body{' class=cell' if compact else ''}>\n{body}\n"
        f'<script type="application/json" id="data">{embedded(data)}</script>\n'
        f"<script>\n{code}\n</script>\n</body></html>\n"
    )


def asset(name: str) -> str:
    """Text of a file of the package's `assets` folder."""
    return files("topple.planner.report").joinpath("assets").joinpath(name).read_text(encoding="utf-8")


def table(headings: Sequence[str], rows: str, *, numbers: Collection[str] = ()) -> str:
    """A table that scrolls where it is wider than its place.

    Args:
        headings: One per column.
        rows: HTML of its rows.
        numbers: The headings of columns of numbers.
    """
    head = "".join(f"<th{' class=number' if title in numbers else ''}>{title}</th>" for title in headings)
    return (
        f'<div class="scroll" tabindex="0"><table><thead><tr>{head}</tr></thead>'
        f"<tbody>{rows}</tbody></table></div>"
    )


def embedded(data: Any) -> str:
    """JSON that may stand inside a script element: no character in it can end the element."""
    text = json.dumps(data, separators=(",", ":"), ensure_ascii=True, allow_nan=False)
    return text.replace("<", "\\u003c").replace(">", "\\u003e").replace("&", "\\u0026")


def viewer(
    number: int, *, ordered: bool, path: bool = False, motion: Motion | None = None, arrows: str = ""
) -> str:
    """The element of a 3-D view with its switches.

    Args:
        number: Which view of the page's data it shows.
        ordered: There is an order whose numbers can be shown.
        path: There is a tool path.
        motion: What the arm does one after the other, see `played.spans`; None where it does nothing.
        arrows: The legend of arrows that are drawn in place of relations.

    Returns:
        HTML the viewer script fills.
    """
    switches = ["surfaces", "hulls", "arrows" if arrows else "relations", "names"]
    switches += ["order"] if ordered else []
    switches += ["path"] if path else []
    switches += ["arm"] if motion else []
    words = {"order": "order numbers", "path": "tool path"}
    boxes = "".join(
        f'<label><input type="checkbox" data-show="{show}"{"" if show == "hulls" else " checked"}> '
        f"{words.get(show, show)}</label>"
        for show in switches
    )
    return (
        f'<figure class="viewer" data-view="{number}"><div class="switches">{boxes}'
        '<button type="button" data-reset>reset view</button></div>'
        '<div class="stage"><canvas tabindex="0" role="img" aria-label="3-D view of the scene"></canvas>'
        f'<div class="info" hidden></div></div>{player(motion) if motion else ""}'
        f"<figcaption>{arrows or relation_legend()}"
        '<span class="note">Drag to turn, shift-drag to move, wheel to zoom; click an object to keep it lit. '
        f"Hatched surface is guessed: no camera saw it.{'' if arrows else _LINES}</span>"
        "</figcaption></figure>"
    )


def player(motion: Motion) -> str:
    """The time line of an arm's motion: played, scrubbed, or entered at what the arm does."""
    last = motion[-1][2]
    bands = ""
    for kind, since, until in motion:
        shown = escape(kind) if until - since > last * len(kind) * _LETTER else ""
        title = f"{escape(kind)}, {since:.1f} to {until:.1f} s"
        bands += f'<span style="flex-grow:{max(until - since, 0.01):.2f}" title="{title}">{shown}</span>'
    return (
        '<div class="player"><button type="button" data-play>play</button>'
        f'<div class="track"><input type="range" min="0" max="{last:.2f}" step="0.02" value="0" '
        f'aria-label="time in the arm\'s motion"><div class="bands" aria-hidden="true">{bands}</div></div>'
        "<output></output></div>"
    )


def relation_legend() -> str:
    """What the colours of the relation lines mean."""
    return "".join(
        f'<span class="key"><i style="background:{css(colour)}"></i>{escape(str(relation))}</span>'
        for relation, colour in RELATION_COLOURS.items()
        if relation != "disjoint"
    )
