"""The documents of the contract as tables for people."""

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from topple.planner.cli.console import in_options, print_table, print_text
from topple.topology.base.values import decimal

if TYPE_CHECKING:
    from topple.topology.scene.scene import Scene

Document = Mapping[str, Any]


def print_relations(title: str, document: Document) -> None:
    """Print what `relate` found.

    Args:
        title: What it was found in.
        document: A `topple.relations` document.
    """
    pairs = document["relations"]
    near = [
        pair for pair in pairs if pair["relation"] != "disjoint" or pair.get("kind") or not pair["observed"]
    ]
    deviation = document["deviation"] * 1000
    print_text(f"{title}: {len(document['objects'])} objects, deviation {deviation:.2f} mm")
    if near:
        headings = ("a", "relation", "b", "gap mm", "confidence", "matrix", "")
        print_table(headings, [_pair(pair) for pair in near], right=(3, 4))
    apart = len(pairs) - len(near)
    if apart:
        which = f"The other {apart} of {len(pairs)} pairs" if near else f"All {apart} pairs"
        print_text(f"{which} are disjoint." if apart > 1 else "One pair is disjoint.")


def _pair(pair: Document) -> tuple[str, ...]:
    notes = (pair.get("kind"), pair.get("reason"), "" if pair["observed"] else "not observed")
    gap = f"{'' if pair['gap_exact'] else '> '}{decimal(pair['gap'] * 1000, 1)}"
    matrix = "; ".join(" ".join(str(count) for count in row) for row in pair["matrix"])
    note = ", ".join(note for note in notes if note)
    return (pair["a"], pair["relation"], pair["b"], gap, f"{pair['confidence']:.2f}", matrix, note)


def print_order(title: str, document: Document, movable: int | None = None, *, explain: bool = False) -> None:
    """Print what `order` found: its first steps with their reasons, the weakest contacts, what is held.

    Args:
        title: What it was found in.
        document: A `topple.order` document.
        movable: Number of objects that could be taken, where it is to be told.
        explain: Print every step, and all that carries something.
    """
    from topple.planner.decide.words import contact, first_rows, order_heading, order_notes, order_rows

    print_text(f"{title}: {order_heading(document, movable)}")
    rows, told = (order_rows(document), []) if explain else first_rows(document)
    print_table(("", "take", "because", "how sure"), rows, right=(0,))
    print_text(*(f"{line}: --explain" if line.startswith("and ") else line for line in told))
    if explain and document["supports"]:
        print_text("", "What carries what:")
        sure = [(f"{each['confidence']:.2f}", "inferred" * each["inferred"]) for each in document["supports"]]
        carried = [contact(document, each) for each in document["supports"]]
        print_table(("", "confidence", ""), [(x, *y) for x, y in zip(carried, sure, strict=True)], right=(1,))
    print_text(*order_notes(document))
    for bar in document.get("access", ()):
        print_text(f"{bar['reason']}: it has to go before a hand gets there.")


def print_build(title: str, document: Document) -> None:
    """Print in which order to put things down: the steps with their reasons, and what is held.

    Args:
        title: What is built.
        document: A `topple.order` document of a build order.
    """
    from topple.planner.decide.words import order_heading, order_rows

    print_text(f"{title}: {order_heading(document)}")
    print_table(("", "put down", "because", "how sure"), order_rows(document), right=(0,))
    holds = document["holds"]
    for hold in holds:
        since = "" if hold["since"] == hold["object"] else f" from when {hold['since']} is put down"
        print_text(f"Hold {hold['object']}{since} until {hold['until']} is down: {hold['because']}.")
    if holds:
        proven = "no order needs fewer" if document["fewest_holds_proven"] else "fewer may do"
        print_text(f"{len(holds)} hold{'s' if len(holds) > 1 else ''}: {proven}.")


def print_moves(title: str, document: Document) -> None:
    """Print in which order things move from one arrangement to another, and how good that is.

    Args:
        title: The start.
        document: A `topple.order` document with `moves`.
    """
    moves, bound = document["moves"], document["bound"]
    buffers = sum(move["buffer"] for move in moves)
    proven = "no sequence has fewer" if document["optimal"] else f"no sequence has fewer than {bound}"
    if not moves:
        print_text(f"{title}: everything is in its place")
        return
    print_text(f"{title}: {len(moves)} moves, {buffers} of them to make room; {proven}")
    how = ("to its place", "out of the way")
    told = enumerate(zip(moves, document["explanation"], strict=True), start=1)
    rows = [(str(i), each["object"], how[each["buffer"]], why.partition(": ")[2]) for i, (each, why) in told]
    print_table(("", "move", "where", "because"), rows, right=(0,))


def print_run(title: str, document: Document) -> None:
    """Print what an arm did: a line per action, with what else it moved.

    Args:
        title: What it was done in.
        document: A `topple.run` document.
    """
    from topple.planner.formats.run_record import run_heading, run_rows

    print_text(f"{title}: {run_heading(document)}")
    print_table(("", "object", "action", "", "disturbed", "relations", "s"), run_rows(document), right=(0, 6))
    for i, step in enumerate(document["steps"], start=1):
        print_text(*(f"{i} {step['object']}: {event}" for event in step.get("events", ())))


def models_in(scene: "Scene") -> dict[str, Any]:
    """The fits of known models, as an entry of a document; none where no models were given."""
    fits = [{"object": name, **fit.to_json()} for name, fit in scene.models.items()]
    return {"models": fits} if fits else {}


def print_assumptions(assumptions: list[str]) -> None:
    """Print what was assumed, a sentence each.

    Args:
        assumptions: The sentences.
    """
    print_text(*(f"Assumed: {in_options(assumption).rstrip('.')}." for assumption in assumptions))
