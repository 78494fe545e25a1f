"""The frame of a page: assets inlined, data embedded, nothing fetched from anywhere."""

import json
from collections.abc import Collection, Iterable, Mapping, Sequence
from html import escape
from importlib.resources import files
from typing import Any

from topple.planner.decide.names import Colour
from topple.planner.report.palette import RELATION_COLOURS, css

View = Mapping[str, Any]
Span = tuple[str, float, float]  # a part of a time line: its name, from when and until when [s]

_LETTER = 0.016  # share of a time line that a letter takes: a name with less room is left to the tooltip

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
    style, *code = (
        files("topple.planner.report").joinpath("assets").joinpath(name).read_text(encoding="utf-8")
        for name in ("page.css", *scripts)
    )
    text = json.dumps(data, separators=(",", ":"), allow_nan=False)
    for mark in "<>&":  # none can end the script element
        text = text.replace(mark, f"\\u{ord(mark):04x}")
    return (
        '<!doctype html>\n<html lang="en"><head><meta charset="utf-8">'
        '<meta name="viewport" content="width=device-width, initial-scale=1">'
        '<meta name="color-scheme" content="light dark">'
        f'<meta http-equiv="Content-Security-Policy" content="{_POLICY}">'
        f"<title>{escape(title)}</title><style>\n{style}</style></head>\n"
        f"<body{' class=cell' if compact else ''}>\n{body}\n"
        f'<script type="application/json" id="data">{text}</script>\n'
        f"<script>\n{chr(10).join(code)}\n</script>\n</body></html>\n"
    )


def view_page(
    title: str, head: str, view: View, sides: tuple[str, str], *, arm: Any = None, compact: bool = False
) -> str:
    """Build the page of one scene: its 3-D view, more below it and beside it.

    Args:
        title: Plain text of the title.
        head: HTML above.
        view: What `drawing.view_data` gave. What links to objects by their numbers in it, `data-object="3"`
            or `data-ends="3 4"`, lights up with them.
        sides: HTML below the view, and beside it.
        arm: What `played.arm_shape` gave, where the view has a motion.
        compact: Without margins and in smaller letters, for a notebook's cell.
    """
    data, scripts = (
        {"views": [view], "arm": arm},
        ("light.js", "viewer.js", "motion.js", "page.js", "show.js"),
    )
    return page(title, head + columns(viewer(0, view) + sides[0], sides[1]), data, scripts, compact=compact)


def columns(left: str, right: str) -> str:
    """The main part of a page in two columns, one above the other where it is narrow."""
    return f'<main class="columns"><div>{left}</div><div>{right}</div></main>'


def beside(left: str, right: str) -> str:
    """Two parts of a page side by side, one above the other where it is narrow."""
    return f'<div class="columns even"><div>{left}</div><div>{right}</div></div>'


def glance(photo: str, words: str, graph: str) -> str:
    """Lay out the top of a page: photo and words beside the graph; nothing where there is none of them."""
    return beside(photo + words, graph) if photo or words or graph else ""


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


def plain_table(headings: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """A table of plain text."""
    cells = ("".join(f"<td>{escape(cell)}</td>" for cell in row) for row in rows)
    return table(headings, "".join(f"<tr>{row}</tr>" for row in cells))


def fold(summary: str, html: str) -> str:
    """A part that opens on demand."""
    return f"<details><summary>{summary}</summary>{html}</details>"


def bullets(lines: Sequence[str]) -> str:
    """A list of plain sentences; nothing where there are none."""
    return f"<ul>{''.join(f'<li>{escape(line)}</li>' for line in lines)}</ul>" if lines else ""


def key(colour: Colour, word: str) -> str:
    """An entry of a legend: a line in its colour, and what it stands for."""
    return f'<span class="key"><i style="background:{css(colour)}"></i>{escape(word)}</span>'


def legend(view: View) -> Mapping[str, Colour]:
    """Key to the colours of the lines of a view."""
    relations = {str(name): colour for name, colour in RELATION_COLOURS.items() if name != "disjoint"}
    return view.get("keys", relations)


def viewer(number: int, view: View) -> str:
    """The element that the viewer script fills with the view of that number in the page's data."""
    motion: Sequence[Span] = view["motion"]["bands"] if view["motion"] else ()
    lines = "arrows" if "arrows" in view else "relations"
    switches = {"surfaces": "surfaces", "hulls": "hulls", lines: lines, "names": "names"}
    switches |= {"order": "order numbers"} if view["places"] is not None else {}
    switches |= {"path": "tool path"} if view["path"] else {}
    switches |= {"arm": "arm"} if motion else {}
    boxes = "".join(
        f'<label><input type="checkbox" data-show="{show}"{" checked" * (show != "hulls")}> {words}</label>'
        for show, words in switches.items()
    )
    keys = "".join(key(colour, word) for word, colour in legend(view).items())
    return (
        f'<figure class="viewer" data-view="{number}"><div class="switches">{boxes}'
        '<button type="button" data-reset>reset view</button></div>'
        '<div class="stage"><canvas tabindex="0" role="img" aria-label="3-D view of the scene"></canvas>'
        f'<div class="info" hidden></div></div>{_player(motion) if motion else ""}<figcaption>{keys}'
        '<span class="note">Drag to turn, shift-drag to move, wheel to zoom; click an object to keep it lit. '
        f"Hatched surface is guessed: no camera saw it.{'' if 'arrows' in view else _LINES}</span>"
        "</figcaption></figure>"
    )


def _player(motion: Sequence[Span]) -> str:
    """The time line of an arm's motion: played, scrubbed, or entered at what the arm does."""
    last = motion[-1][2]
    bands = "".join(
        f'<span style="flex-grow:{max(until - since, 0.01):.2f}" title="{escape(kind)}, {since:.1f} to '
        f'{until:.1f} s">{escape(kind) if until - since > last * len(kind) * _LETTER else ""}</span>'
        for kind, since, until in motion
    )
    return (
        '<div class="player"><button type="button" data-play>play</button>'
        f'<div class="track"><input type="range" min="0" max="{last:.2f}" step="0.02" value="0" '
        f'aria-label="time in the arm\'s motion"><div class="bands" aria-hidden="true">{bands}</div></div>'
        "<output></output></div>"
    )
