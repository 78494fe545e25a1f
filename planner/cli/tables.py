"""The documents of the contract as tables for people."""

from collections.abc import Mapping
from math import degrees
from typing import TYPE_CHECKING, Any

from topple.planner.cli.console import print_table, print_text
from topple.planner.rounded import rounded

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
    notes = (
        pair.get("kind"),
        pair.get("reason"),
        "" if pair["observed"] else "not observed",
    )
    gap = f"{'' if pair['gap_exact'] else '> '}{rounded(pair['gap'] * 1000, 1)}"
    matrix = "; ".join(" ".join(str(count) for count in row) for row in pair["matrix"])
    note = ", ".join(note for note in notes if note)
    return (pair["a"], pair["relation"], pair["b"], gap, f"{pair['confidence']:.2f}", matrix, note)


def print_order(title: str, document: Document, movable: int | None = None) -> None:
    """Print what `order` found: the steps with their reasons, what carries what, groups.

    Args:
        title: What it was found in.
        document: A `topple.order` document.
        movable: Number of objects that could be taken, where it is to be told.
    """
    from topple.planner.report.words import holds_in_words, how_sure, listed, order_in_words

    steps = order_in_words(document)
    targets, risk = document["targets"], document["risk"]
    count = f"{len(dict(steps))}" + (" objects" if movable is None else f" of {movable} movable objects")
    purpose = f"to free {listed(targets)}" if targets else "to clear everything"
    print_text(f"{title}: {purpose}, take {count} in this order")
    rows = [(str(i), name, why, how_sure(risk.get(name, 0))) for i, (name, why) in enumerate(steps, start=1)]
    print_table(("", "take", "because", "how sure"), rows, right=(0,))
    if document["supports"]:
        print_text("", "What carries what:")
        rows = [_support(support) for support in document["supports"]]
        print_table(("supporter", "supported", "kind", "confidence", ""), rows, right=(3,))
    for group in document["groups"]:
        print_text(f"{listed(group)} hold each other: take them together, or hold the others.")
    for hold, words in zip(document.get("holds", ()), holds_in_words(document), strict=True):
        by = "With the fixture" if hold.get("fixture") else "With a second hand"
        print_text(f"{by}, {words}.")
    for bar in document.get("access", ()):
        print_text(f"{bar['reason']}: it has to go before a hand gets there.")


def print_next_view(view: Document | None) -> None:
    """Print from where to look next.

    Args:
        view: The entry `next_view` of an order's document.
    """
    if view is None:
        print_text("Next view: none would show anything more that the order depends on.")
        return
    eye, target = ("(" + ", ".join(f"{value:.2f}" for value in view[key]) + ")" for key in ("eye", "target"))
    told = ", ".join(f"{one['a']} and {one['b']}" for one in view["shows"][:3])
    share = f"{100 * view['worth']:.0f} % of what is hidden and matters"
    print_text(f"Next view: from {eye} towards {target} m, which shows {share}: where {told} may meet.")


def print_build(title: str, document: Document) -> None:
    """Print in which order to put things down: the steps with their reasons, and what is held.

    Args:
        title: What is built.
        document: A `topple.order` document of a build order.
    """
    from topple.planner.report.words import how_sure

    names, risk = document["order"], document["risk"]
    print_text(f"{title}: to build it, put {len(names)} objects down in this order")
    reasons = [line.partition(": ")[2] for line in document["explanation"]]
    rows = [
        (str(i), name, why, how_sure(risk.get(name, 0)))
        for i, (name, why) in enumerate(zip(names, reasons, strict=True), start=1)
    ]
    print_table(("", "put down", "because", "how sure"), rows, right=(0,))
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
        print_text(f"{title}: everything lies as it shall")
        return
    print_text(f"{title}: {len(moves)} moves, {buffers} of them to make room; {proven}")
    rows = [
        (
            str(i),
            move["object"],
            "out of the way" if move["buffer"] else "to its place",
            line.partition(": ")[2],
        )
        for i, (move, line) in enumerate(zip(moves, document["explanation"], strict=True), start=1)
    ]
    print_table(("", "move", "where", "because"), rows, right=(0,))


def _support(support: Document) -> tuple[str, ...]:
    inferred = "inferred" if support.get("inferred") else ""
    sure = f"{support['confidence']:.2f}"
    return (support["supporter"], support["supported"], support.get("kind", ""), sure, inferred)


def print_run(title: str, document: Document) -> None:
    """Print what an arm did: a line per action, with what else it moved.

    Args:
        title: What it was done in.
        document: A `topple.run` document.
    """
    steps = document["steps"]
    outcome = {"reached": "done", "not reached": "failed"}.get(document["verdict"], document["verdict"])
    print_text(
        f"{title}: {document['goal']}, {outcome} after {len(steps)} actions, {document['seconds']:.1f} s"
    )
    rows = [_action(i, step) for i, step in enumerate(steps, start=1)]
    print_table(("", "object", "action", "", "disturbed", "relations", "s"), rows, right=(0, 6))
    for i, step in enumerate(steps, start=1):
        print_text(*(f"{i} {step['object']}: {event}" for event in step.get("events", ())))


def _action(number: int, step: Document) -> tuple[str, ...]:
    from topple.planner.tolerances import DISTURBED, TURNED  # which take numpy

    moved = [
        f"{name} {metres * 1000:.1f} mm {degrees(turn):.1f}°"
        for name, (metres, turn) in step["disturbed"].items()
        if metres > DISTURBED or turn > TURNED
    ]
    outcome = "done" if step["success"] else "failed"
    if step["attempts"] > 1:
        outcome += f", attempt {step['attempts']}"
    relations = "as predicted" if step["relations_as_predicted"] else "not as predicted"
    disturbed = ", ".join(moved) or "nothing"
    return (
        str(number),
        step["object"],
        step["action"],
        outcome,
        disturbed,
        relations,
        f"{step['seconds']:.1f}",
    )


def models_in(scene: "Scene") -> dict[str, Any]:
    """The fits of known models, as an entry of a document; none where no models were given."""
    fits = [{"object": name, **fit.to_json()} for name, fit in scene.models.items()]
    return {"models": fits} if fits else {}


def print_assumptions(assumptions: list[str]) -> None:
    """Print what was assumed, a sentence each.

    Args:
        assumptions: The sentences.
    """
    print_text(*(f"Assumed: {assumption.rstrip('.')}." for assumption in assumptions))
