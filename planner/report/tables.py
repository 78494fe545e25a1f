"""Tables of the pages as HTML: relations, the order in words, risks, what bars the way."""

from collections.abc import Mapping, Sequence
from html import escape
from typing import Any, NamedTuple

from topple.planner.decide.words import (
    contact,
    millimetres,
    number_of,
    order_notes,
    order_rows,
    phrase,
    sentences,
    shorten,
)
from topple.planner.report.drawing import Document, is_inferred
from topple.planner.report.html import bullets, fold, table
from topple.planner.report.limits import LIMITS
from topple.planner.report.palette import RELATION_COLOURS, css, ink_on, relation_colour
from topple.planner.verify.verification import Verification
from topple.topology.sixim.table import Relation

_UNSEEN = "not seen"
LETTERS = dict(zip(RELATION_COLOURS, ("T", "X", "W", "PW", "C", "PC", "D"), strict=True))
"""What a cell says of its relation besides its colour."""


def relation_table(relations: Document, index: Mapping[str, int]) -> str:
    """The 6IM relation of every pair as HTML; disjoint pairs stand in a part that opens on demand."""
    pairs = list(relations.get("relations", ()))
    meeting = [pair for pair in pairs if pair["relation"] != Relation.DISJOINT]
    apart = [pair for pair in pairs if pair["relation"] == Relation.DISJOINT]
    apart.sort(key=lambda pair: float(pair.get("gap") or 0.0))
    html = '<p class="note">No two objects meet: all are disjoint.</p>'
    html = _pair_table(meeting, index) if meeting else html
    html += fold(number_of(len(apart), "disjoint pair"), _pair_table(apart, index)) if apart else ""
    if (deviation := relations.get("deviation")) is not None:
        html += (
            '<p class="note">Rows read “A relation B”. Evidence: seen or inferred, and the share of such '
            "evidence that was right on scenes of known truth. "
            f"Deviation δ = {millimetres(float(deviation))}.</p>"
        )
    return html


def relation_matrix(relations: Document, index: Mapping[str, int]) -> str:
    """All relations as a square of letters; nothing above `LIMITS.matrix` objects, where they do not fit."""
    pairs = list(relations.get("relations", ()))
    names = list(dict.fromkeys(str(pair[end]) for pair in pairs for end in ("a", "b")))
    if not pairs or len(names) > LIMITS.matrix:
        return ""
    cells: dict[tuple[str, str], str] = {}
    for pair in pairs:
        ends, inferred = (str(pair["a"]), str(pair["b"])), is_inferred(pair)
        relation = Relation(pair["relation"])
        for (x, y), word in ((ends, relation), (ends[::-1], relation.converse)):
            said_so = escape(f"{x} {word} {y}") + ", inferred" * inferred
            both = f"{index.get(x, -1)} {index.get(y, -1)}"
            cells[x, y] = f'<td data-ends="{both}" title="{said_so}">{_letter(word, inferred)}</td>'
    head = "".join(
        f'<th scope="col" title="{escape(b)}"><span>{escape(shorten(b))}</span></th>' for b in names
    )
    rows = "".join(
        f'<tr><th scope="row" title="{escape(a)}">{escape(shorten(a))}</th>'
        f"{''.join(cells.get((a, b), '<td></td>') for b in names)}</tr>"
        for a in names
    )
    legend = "".join(f'<span class="key">{_letter(each)}{escape(each)}</span>' for each in RELATION_COLOURS)
    return (
        f'<div class="scroll" tabindex="0"><table class="matrix"><thead><tr><td></td>{head}</tr></thead>'
        f'<tbody>{rows}</tbody></table></div><p class="legend matrix">{legend}<span class="note">Read a row: '
        "the object at its left is in this relation to the one above. Dashed: inferred.</span></p>"
    )


def _letter(relation: str, inferred: bool = False) -> str:
    """A relation in its colour; disjoint pairs, which are most, stay in the background."""
    if relation == Relation.DISJOINT:
        return '<b class="apart">D</b>'
    colour, kind = relation_colour(relation), ' class="inferred"' if inferred else ""
    style = f"background:{css(colour)};color:{css(ink_on(colour))}"
    return f'<b{kind} style="{style}">{LETTERS[relation]}</b>'


def _pair_table(pairs: Sequence[Mapping[str, Any]], index: Mapping[str, int]) -> str:
    rows = "".join(_pair_row(pair, index) for pair in pairs)
    return table(("A", "relation", "B", "gap", "evidence"), rows, numbers=("gap",))


def _pair_row(pair: Mapping[str, Any], index: Mapping[str, int]) -> str:
    a, b, relation, gap = str(pair["a"]), str(pair["b"]), str(pair["relation"]), pair.get("gap")
    shown = "" if gap is None else ("" if pair.get("gap_exact", True) else "≥ ") + millimetres(float(gap))
    sure = "" if pair.get("confidence") is None else f", {float(pair['confidence']):.2f}"
    notes = ", ".join(str(pair[key]) for key in ("kind", "reason") if pair.get(key))
    title = "" if pair.get("matrix") is None else f' title="6IM matrix {escape(str(pair["matrix"]))}"'
    return (
        f'<tr data-ends="{index.get(a, -1)} {index.get(b, -1)}"{title}><td>{object_name(a, index)}</td>'
        f'<td class=relation><i class="dot" style="background:{css(relation_colour(relation))}"></i>'
        f"{escape(relation)}{_aside(notes)}</td><td>{object_name(b, index)}</td><td class=number>{shown}</td>"
        f"<td class=evidence>{'inferred' if is_inferred(pair) else 'observed'}{sure}</td></tr>"
    )


def _aside(words: str) -> str:
    return f' <span class="kind">{escape(words)}</span>' if words else ""


def object_name(name: str, index: Mapping[str, int]) -> str:
    """A name that lights its object up in the view."""
    if name not in index:
        return escape(name)
    return f'<span class="name" data-object="{index[name]}">{escape(name)}</span>'


def order_list(order: Document, index: Mapping[str, int]) -> str:
    """The order with the reason for each place as HTML, and what its `topple.order` document says besides."""
    items = "".join(
        f'<li data-object="{index.get(name, -1)}" tabindex="0"><b class="name">{escape(name)}</b>: '
        f"{escape(sentence)}{_aside('' if sure == 'sure' else sure)}</li>"
        for _, name, sentence, sure in order_rows(order)
    )
    html = f'<ol class="order">{items}</ol>' if items else '<p class="note">There is nothing to take.</p>'
    return html + _certificates(order, index)


def _certificates(order: Document, index: Mapping[str, int]) -> str:
    """Groups, unresolved cycles, what carries what, and what only bars the gripper's way."""

    def names_html(names: Sequence[Any] | str) -> str:
        some = [names] if isinstance(names, str) else names
        return phrase([object_name(str(name), index) for name in some])

    lines = [("", escape(words)) for words in order_notes(order)]
    for cycle in order.get("unresolved", ()):
        lines.append((" bad", f"No safe order among {names_html(cycle)}: each holds another."))
    html = "".join(f'<p class="certificate{kind}">{words}</p>' for kind, words in lines)
    if supports := list(order.get("supports") or ()):
        rows = "".join(f"<li>{_support(order, support, index)}</li>" for support in supports)
        weakest = min(supports, key=lambda support: float(support.get("confidence", 1.0)))
        html += f'<p class="note">Weakest contact: {_support(order, weakest, index)}.</p>'
        html += fold(f"What carries what ({len(supports)})", f"<ul>{rows}</ul>")
    if access := list(order.get("access") or ()):
        rows = "".join(
            f"<li>{names_html(str(bar['first']))} bars the way to {names_html(str(bar['then']))}"
            f"{': ' + escape(str(bar['reason'])) if bar.get('reason') else ''}</li>"
            for bar in access
        )
        html += fold(f"{len(access)} in the gripper's way", f"<ul>{rows}</ul>")
    return html


def _support(order: Document, support: Mapping[str, Any], index: Mapping[str, int]) -> str:
    evidence = "inferred" if support.get("inferred", False) else "observed"
    sure = f"{evidence}, confidence {float(support.get('confidence', 1.0)):.2f}"
    return contact(order, support, lambda name: object_name(name, index)) + _aside(f"({sure})")


def sentence_list(lines: Sequence[str], title: str) -> str:
    """A titled list of sentences; nothing where there are none."""
    told = [line for text in lines for line in sentences(text)]
    return f"<h2>{escape(title)}</h2>{bullets(told)}" if told else ""


def proof_rows(checked: Verification) -> list[tuple[str, str, str]]:
    """List the claims of a verification, each with its means and its steps."""
    steps: dict[tuple[str, str], list[str]] = {}
    numbered = [(str(one.step + 1), one.proofs) for one in checked.steps]
    for number, proofs in (*numbered, ("plan", checked.whole)):
        for proof in proofs:
            told = {True: proof.what, False: f"NOT SO: {proof.what}", None: f"not shown: {proof.what}"}
            means = f"{proof.means}: {proof.detail}" if proof.shown is None else proof.means
            steps.setdefault((told[proof.shown], means), []).append(number)
    return [
        (told, means, "all" if len(which) == len(checked.steps) > 1 else ", ".join(which))
        for (told, means), which in steps.items()
    ]


class Change(NamedTuple):
    """A pair whose relation is not the predicted one: "a relation b", or "not seen".

    `counts` says that it is a contradiction: in contact instead of apart, or the other way round, and both
    were observed; or an object is gone. The loop counts the same (`execution.look.find_unexpected`).
    """

    a: str
    b: str
    predicted: str
    observed: str
    counts: bool


def relation_changes(predicted: Document, observed: Document) -> list[Change]:
    """Pairs whose relation in one `topple.relations` document is not that of another, of what was seen."""
    expected, seen = _by_pair(predicted), _by_pair(observed)
    changes: list[Change] = []
    for pair in dict.fromkeys([*expected, *seen]):
        before, sure_before = expected.get(pair, (_UNSEEN, True))
        after, sure_after = seen.get(pair, (_UNSEEN, True))
        apart = (before == Relation.DISJOINT) != (after == Relation.DISJOINT)
        counts = after == _UNSEEN or (apart and before != _UNSEEN and sure_before and sure_after)
        if before != after:
            changes.append(Change(*pair, before, after, counts))
    return changes


def _by_pair(relations: Document) -> dict[tuple[str, str], tuple[str, bool]]:
    """Relation of each pair, and whether it was observed, oriented by name: so two documents compare."""
    found: dict[tuple[str, str], tuple[str, bool]] = {}
    for pair in relations.get("relations", ()):
        a, b, relation = str(pair["a"]), str(pair["b"]), Relation(pair["relation"])
        said = str(relation if a <= b else relation.converse)
        found[(a, b) if a <= b else (b, a)] = said, bool(pair.get("observed", True))
    return found
