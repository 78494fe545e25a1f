"""The page and the picture of a check: what stands and by how much, with forces and margins as arrows."""

from collections.abc import Mapping, Sequence
from html import escape
from typing import Any

import numpy as np

from topple.planner.decide.names import Colour, spoken
from topple.planner.decide.words import CHECK_HEADINGS, MARGINS, check_cells
from topple.planner.report.drawing import Document, Drawing, view_data
from topple.planner.report.figure import draw_list, draw_view, side_by_side
from topple.planner.report.html import table, view_page
from topple.planner.report.palette import css
from topple.planner.report.photo import photo
from topple.planner.report.tables import object_name, sentence_list
from topple.topology.base.arguments import checked_arguments
from topple.topology.base.arrays import FloatArray
from topple.topology.scene.scene import Scene

CARRIES: Colour = (26, 150, 65)
PUSHED: Colour = (204, 120, 0)
ASIDE: Colour = (43, 105, 214)
FAILS: Colour = (214, 39, 40)
LONGEST = 0.35
"""Length of the longest arrow of a force, as a share of the radius of the view."""
KEYS = {
    "carries": CARRIES,
    "least push that moves it": PUSHED,
    "its weight may be as far aside": ASIDE,
    "does not stand": FAILS,
}


@checked_arguments
def check_page(scene: Scene, found: Document, title: str) -> str:
    """Draw a check as one self-contained page: the verdict first.

    Args:
        scene: The scene that was checked.
        found: The JSON of `topple check`.
        title: Title of the page.

    Examples:
        >>> "stands" in check_page(scene, check(scene).to_json(), "A desk")
        True
    """
    scene, found = spoken(scene, (scene, found))
    drawing = Drawing.of(scene)
    verdict, *reasons = str(found["verdict"]).split("; ")
    head = f'<header><h1>{escape(verdict)}</h1><p class="lead">{escape("; ".join([title, *reasons]))}.</p>'
    beside = photo(scene, drawing, None) + _table(found["objects"], drawing.index)
    beside += sentence_list(list(found["assumptions"]), "Assumptions")
    return view_page(title, head + "</header>", _view(drawing, found), ("", beside))


def check_picture(scene: Scene, found: Document) -> bytes:
    """Draw a check as a PNG picture: the view with its arrows, and a sentence for each object."""
    scene, found = spoken(scene, (scene, found))
    drawing = Drawing.of(scene)
    lines = [
        (None if each["stands"] else FAILS, _sentence(each))
        for each in sorted(found["objects"], key=lambda one: one["stands"])
    ]
    verdict = str(found["verdict"]).partition("; ")[0]
    return side_by_side(draw_view(drawing, _view(drawing, found)), draw_list(verdict, lines))


def _sentence(found: Document) -> str:
    """Say how an object stands, and which disturbances it withstands."""
    margins = found.get("margins")
    if not margins:
        return found["sentence"]
    aside, tilt, push = (margins[key] for key in MARGINS)
    return f"{found['sentence']}; moves at {push:.2g} N, {tilt:.2g}° or with its weight {aside:.2g} mm aside"


def _view(drawing: Drawing, found: Document) -> dict[str, Any]:
    arrows = [
        {"from": start.tolist(), "to": end.tolist(), "colour": css(colour), "object": number}
        for start, end, colour, number in _arrows(drawing, found)
    ]
    return {**view_data(drawing, {}, None), "arrows": arrows, "keys": KEYS}


def _arrows(drawing: Drawing, found: Document) -> list[tuple[FloatArray, FloatArray, Colour, int]]:
    """From where to where (3,) [m], in which colour and of which object arrows are."""
    index = drawing.index
    standing = [each for each in found["objects"] if "margins" in each]
    most = max((each["margins"]["push_newton"] for each in standing), default=1.0) or 1.0
    carried = [carry["newton"] for each in found["objects"] for carry in each.get("carried_by", ())]
    heaviest = max(carried, default=1.0) or 1.0
    long = LONGEST * drawing.radius
    drawn: list[tuple[FloatArray, FloatArray, Colour, int]] = []
    for each in found["objects"]:
        number = index[each["object"]]
        shown = drawing.objects[number]
        if not each["stands"]:
            drawn.append((shown.top, shown.top - long * drawing.up, FAILS, number))
        for carry in each.get("carried_by", ()):
            end = np.asarray(carry["at"], np.float64)
            length = long * float(np.sqrt(carry["newton"] / heaviest))
            drawn.append((end - length * drawing.up, end, CARRIES, number))
        if margins := each.get("margins"):
            way = np.asarray(margins["centre_along"], np.float64)
            far = min(1e-3 * margins["centre_mm"], long)
            drawn.append((shown.centre, shown.centre + far * way, ASIDE, number))
            length = long * float(np.sqrt(margins["push_newton"] / most))
            way = np.asarray(margins["push_along"], np.float64)
            drawn.append((shown.top - length * way, shown.top, PUSHED, number))
    return drawn


def _table(objects: Sequence[Mapping[str, Any]], index: Mapping[str, int]) -> str:
    """A row for each object, those that do not stand first; without columns in which nothing stands."""
    first = sorted(objects, key=lambda one: one["stands"])
    columns = list(zip(CHECK_HEADINGS, zip(*map(check_cells, first), strict=True), strict=False))[1:]
    shown, numbers = [(title, cells) for title, cells in columns if any(cells)], CHECK_HEADINGS[3:6]
    rows = "".join(
        f"<tr><td>{object_name(each['object'], index)}</td>"
        + "".join(
            f"<td{' class=number' if title in numbers else ''}>{escape(cells[row])}</td>"
            for title, cells in shown
        )
        + "</tr>"
        for row, each in enumerate(first)
    )
    headings = [CHECK_HEADINGS[0], *(title for title, _ in shown)]
    return "<h2>Objects</h2>" + table(headings, rows, numbers=numbers)
