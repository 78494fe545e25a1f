"""Tables of the pages as HTML: relations, the order in words, risks, what bars the way."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from html import escape
from typing import Any

from topple.planner.formats.verification import Verification
from topple.planner.report.html import table
from topple.planner.report.palette import css, relation_colour
from topple.planner.report.view import is_inferred
from topple.planner.report.words import (
    holds_in_words,
    how_sure,
    listed,
    millimetres,
    order_in_words,
    said,
    sentences,
)
from topple.topology.sixim.table import Relation

Document = Mapping[str, Any]
_UNSEEN = "not seen"


def relation_table(relations: Document, index: Mapping[str, int]) -> str:
    """The 6IM relation of every pair; disjoint pairs stand in a part that opens on demand.

    Args:
        relations: A `topple.relations` document.
        index: Object -> its number in the viewer.

    Returns:
        HTML, every name escaped.
    """
    pairs = list(relations.get("relations", ()))
    meeting = [pair for pair in pairs if pair["relation"] != Relation.DISJOINT]
    apart = [pair for pair in pairs if pair["relation"] == Relation.DISJOINT]
    apart.sort(key=lambda pair: float(pair.get("gap") or 0.0))
    html = (
        _pair_table(meeting, index)
        if meeting
        else '<p class="note">No two objects meet: all are disjoint.</p>'
    )
    if apart:
        html += (
            f"<details><summary>{len(apart)} disjoint pair{'s' if len(apart) > 1 else ''}</summary>"
            f"{_pair_table(apart, index)}</details>"
        )
    deviation = relations.get("deviation")
    if deviation is not None:
        html += (
            '<p class="note">Rows read “A relation B”. Evidence: seen or inferred, and the share of such '
            "evidence that was right on scenes of known truth. "
            f"Deviation δ = {millimetres(float(deviation))}.</p>"
        )
    return html


def _pair_table(pairs: Sequence[Mapping[str, Any]], index: Mapping[str, int]) -> str:
    rows = "".join(_pair_row(pair, index) for pair in pairs)
    return table(("A", "relation", "B", "gap", "evidence"), rows, numbers=("gap",))


def _pair_row(pair: Mapping[str, Any], index: Mapping[str, int]) -> str:
    a, b, relation = str(pair["a"]), str(pair["b"]), str(pair["relation"])
    gap = pair.get("gap")
    shown = "" if gap is None else ("" if pair.get("gap_exact", True) else "≥ ") + millimetres(float(gap))
    sure = "" if pair.get("confidence") is None else f", {float(pair['confidence']):.2f}"
    dot = f'<i class="dot" style="background:{css(relation_colour(relation))}"></i>'
    evidence = "inferred" if is_inferred(pair) else "observed"
    notes = [str(pair[key]) for key in ("kind", "reason") if pair.get(key)]
    note = f' <span class="kind">{escape(", ".join(notes))}</span>' if notes else ""
    matrix = pair.get("matrix")
    title = f' title="6IM matrix {escape(str(matrix))}"' if matrix is not None else ""
    return (
        f'<tr data-ends="{index.get(a, -1)} {index.get(b, -1)}"{title}>'
        f"<td>{object_name(a, index)}</td><td class=relation>{dot}{escape(relation)}{note}</td>"
        f"<td>{object_name(b, index)}</td><td class=number>{shown}</td>"
        f"<td class=evidence>{evidence}{sure}</td></tr>"
    )


def object_name(name: str, index: Mapping[str, int]) -> str:
    """A name that lights its object up in the view."""
    if name not in index:
        return escape(name)
    return f'<span class="name" data-object="{index[name]}">{escape(name)}</span>'


def order_list(order: Document, index: Mapping[str, int]) -> str:
    """The safe order with the reason for each place, and what an order says besides.

    Args:
        order: A `topple.order` document.
        index: Object -> its number in the viewer.

    Returns:
        HTML, every name escaped.
    """
    risk: Mapping[str, float] = order.get("risk") or {}
    items = "".join(
        f'<li data-object="{index.get(name, -1)}" tabindex="0"><b class="name">{escape(name)}</b>: '
        f"{escape(sentence)}{_risk(risk.get(name))}</li>"
        for name, sentence in order_in_words(order)
    )
    html = f'<ol class="order">{items}</ol>' if items else '<p class="note">There is nothing to take.</p>'
    html += _certificates(order, index)
    return html


def _risk(risk: float | None) -> str:
    """How sure a step is, where that is worth a word."""
    word = how_sure(risk or 0.0)
    return "" if word == "sure" else f' <span class="kind">{word}</span>'


def _certificates(order: Document, index: Mapping[str, int]) -> str:
    """Groups, unresolved cycles, what carries what, and what only bars the gripper's way."""
    html = ""
    for group in order.get("groups", ()):
        names = [object_name(str(name), index) for name in group]
        html += f'<p class="certificate">Held or taken together: {listed(names)}.</p>'
    for words in holds_in_words(order):
        html += f'<p class="certificate">With a second hand, {escape(words)}.</p>'
    for cycle in order.get("unresolved", ()):
        members = [cycle] if isinstance(cycle, str) else list(cycle)
        names = [object_name(str(name), index) for name in members]
        html += f'<p class="certificate bad">No safe order among {listed(names)}: each holds another.</p>'
    supports = list(order.get("supports") or ())
    if supports:
        lying = {
            (str(edge["then"]), str(edge["first"])): said(edge) for edge in order.get("dependencies", ())
        }
        rows = "".join(f"<li>{_support(support, index, lying)}</li>" for support in supports)
        html += f"<details><summary>What carries what ({len(supports)})</summary><ul>{rows}</ul></details>"
    access = list(order.get("access") or ())
    if access:
        rows = "".join(f"<li>{_bar(bar, index)}</li>" for bar in access)
        html += f"<details><summary>{len(access)} in the gripper's way</summary><ul>{rows}</ul></details>"
    return html


def _support(
    support: Mapping[str, Any], index: Mapping[str, int], lying: Mapping[tuple[str, str], str]
) -> str:
    names = str(support["supporter"]), str(support["supported"])
    lower, upper = (object_name(name, index) for name in names)
    kind = {"leans": "leans on", "contained": "lies in"}.get(str(support.get("kind")), "rests on")
    if kind == "leans on":
        kind = {"lying": "lies on", "contained": "lies in"}.get(lying.get(names, ""), kind)
    evidence = "inferred" if support.get("inferred", False) else "observed"
    sure = f"{float(support.get('confidence', 1.0)):.2f}"
    return f'{upper} {kind} {lower} <span class="kind">{evidence}, confidence {sure}</span>'


def _bar(bar: Mapping[str, Any], index: Mapping[str, int]) -> str:
    first, then = object_name(str(bar["first"]), index), object_name(str(bar["then"]), index)
    why = f": {escape(str(bar['reason']))}" if bar.get("reason") else ""
    return f"{first} bars the way to {then}{why}"


def sentence_list(lines: Sequence[str], title: str) -> str:
    """A titled list of sentences; nothing where there are none."""
    told = [line for text in lines for line in sentences(text)]
    if not told:
        return ""
    return f"<h2>{escape(title)}</h2><ul>{''.join(f'<li>{escape(line)}</li>' for line in told)}</ul>"


def proof_rows(checked: Verification) -> list[tuple[str, str, str]]:
    """What a verification shows: what, by which means, and of which steps that is so."""
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


@dataclass(frozen=True)
class Change:
    """A pair whose relation is not the predicted one.

    Attributes:
        a: One object.
        b: The other one.
        predicted: "a relation b" as it was predicted; "not seen" where it was not.
        observed: As it was seen.
        counts: It is a contradiction: in contact instead of apart, or the other way round, and both were
            observed; or an object is gone. The loop counts the same (`execution.look.unexpected`).
    """

    a: str
    b: str
    predicted: str
    observed: str
    counts: bool


def relation_changes(predicted: Document, observed: Document) -> list[Change]:
    """Pairs whose relation is not the predicted one.

    Args:
        predicted: A `topple.relations` document.
        observed: Another, of what was seen.
    """
    expected, seen = _by_pair(predicted), _by_pair(observed)
    changes: list[Change] = []
    for pair in dict.fromkeys([*expected, *seen]):
        before, sure_before = expected.get(pair, (_UNSEEN, True))
        after, sure_after = seen.get(pair, (_UNSEEN, True))
        if before == after:
            continue
        apart = (before == Relation.DISJOINT) != (after == Relation.DISJOINT)
        counts = after == _UNSEEN or (apart and before != _UNSEEN and sure_before and sure_after)
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
