"""The relation of every pair at one look: a square of letters, each in its relation's colour."""

from collections.abc import Mapping
from html import escape
from typing import Any

from topple.planner.report.limits import LIMITS
from topple.planner.report.palette import RELATION_COLOURS, css, ink_on, relation_colour
from topple.planner.report.view import is_inferred
from topple.planner.report.words import shortened
from topple.topology.sixim.table import Relation

Document = Mapping[str, Any]

LETTERS: dict[str, str] = {
    Relation.TOUCH: "T",
    Relation.CROSS: "X",
    Relation.WITHIN: "W",
    Relation.PARTIAL_WITHIN: "PW",
    Relation.CONTAIN: "C",
    Relation.PARTIAL_CONTAIN: "PC",
    Relation.DISJOINT: "D",
}
"""What a cell says of its relation besides its colour."""


def relation_matrix(relations: Document, index: Mapping[str, int]) -> str:
    """All relations as a square of coloured cells with a legend.

    Args:
        relations: A `topple.relations` document.
        index: Object -> its number in the viewer.

    Returns:
        HTML, every name escaped; nothing above `LIMITS.matrix` objects, where letters no longer fit.
    """
    pairs = list(relations.get("relations", ()))
    names = list(dict.fromkeys(str(pair[end]) for pair in pairs for end in ("a", "b")))
    if not pairs or len(names) > LIMITS.matrix:
        return ""
    cells: dict[tuple[str, str], tuple[str, bool]] = {}
    for pair in pairs:
        a, b, relation = str(pair["a"]), str(pair["b"]), Relation(pair["relation"])
        cells[a, b] = str(relation), is_inferred(pair)
        cells[b, a] = str(relation.converse), is_inferred(pair)
    head = "".join(
        f'<th scope="col" title="{escape(b)}"><span>{escape(shortened(b))}</span></th>' for b in names
    )
    rows = "".join(
        f'<tr><th scope="row" title="{escape(a)}">{escape(shortened(a))}</th>'
        f"{''.join(_cell(a, b, cells.get((a, b)), index) for b in names)}</tr>"
        for a in names
    )
    legend = "".join(
        f'<span class="key"><b{_paint(relation)}>{LETTERS[relation]}</b>{escape(str(relation))}</span>'
        for relation in RELATION_COLOURS
    )
    return (
        f'<div class="scroll" tabindex="0"><table class="matrix"><thead><tr><td></td>{head}</tr></thead>'
        f'<tbody>{rows}</tbody></table></div><p class="legend matrix">{legend}<span class="note">Read a row: '
        "the object at its left is in this relation to the one above. Dashed: inferred.</span></p>"
    )


def _cell(a: str, b: str, found: tuple[str, bool] | None, index: Mapping[str, int]) -> str:
    if found is None:
        return "<td></td>"
    relation, inferred = found
    told = f"{a} {relation} {b}{', inferred' if inferred else ''}"
    return (
        f'<td data-ends="{index.get(a, -1)} {index.get(b, -1)}" title="{escape(told)}">'
        f"<b{_paint(relation, inferred)}>{LETTERS[relation]}</b></td>"
    )


def _paint(relation: str, inferred: bool = False) -> str:
    """Class and colours of a cell; disjoint pairs, which are most, stay in the background."""
    if relation == Relation.DISJOINT:
        return ' class="apart"'
    colour = relation_colour(relation)
    style = f' style="background:{css(colour)};color:{css(ink_on(colour))}"'
    return (' class="inferred"' if inferred else "") + style
