"""A dependency and an order said in plain words."""

from collections.abc import Mapping, Sequence
from typing import Any

from topple.planner.decide.hold import Hold
from topple.planner.report.limits import LIMITS
from topple.topology.rounded import rounded

Document = Mapping[str, Any]

_BEGINNINGS = (
    "it ",
    "the ",
    "nothing ",
    "a ",
    "an ",
    "no ",
    "what ",
    "bodies ",
    "at ",
    "after ",
    "before ",
    "from ",
)
"""Words that sentences begin with; anything else may be the name of an object."""

UNTIED = "nothing depends on it, and it depends on nothing"
"""Said of what has no place of its own in an order."""

TARGET = "this is a target"

_BECAUSE = {
    "supported": ("rests on {it}", "rest on {it}"),
    "leaning": ("leans on {it}", "lean on {it}"),
    "lying": ("lies on {it}", "lie on {it}"),
    "contained": ("lies in {it}", "lie in {it}"),
    "blocking": ("would be lifted or dragged along with {it}", "would be lifted or dragged along with {it}"),
    "counterweight": ("tips without {it}", "tip without {it}"),
}
"""What an object that goes before has to do with the one that goes after: said of one, said of several."""


def because(first: Sequence[str], reason: str, then: str = "it") -> str:
    """Why some objects have to go before another, as a clause.

    Args:
        first: Names of those that go before, at least one.
        reason: Reason of these dependencies.
        then: What goes after them, in the clause.

    Returns:
        A clause such as "cup and spoon rest on it"; an unknown reason is quoted as it is.
    """
    one, several = _BECAUSE.get(reason, ("goes before {it}, " + reason, "go before {it}, " + reason))
    return f"{listed(first)} {one if len(first) == 1 else several}".replace("{it}", then)


def how_sure(risk: float) -> str:
    """How sure it is that a step moves nothing else, as a word: risks are not good enough for figures."""
    return "sure" if risk < LIMITS.sure else "likely" if risk < LIMITS.guess else "guess"


def said(dependency: Mapping[str, Any]) -> str:
    """The reason of a dependency as a person would say it: what leans on a plate may be said to lie on it."""
    lies = {"on": "lying", "in": "contained"}
    return lies.get(str(dependency.get("lies")), str(dependency["reason"]))


def order_in_words(order: Document) -> list[tuple[str, str]]:
    """Each object of an order with the reason for its place.

    Args:
        order: A `topple.order` document.

    Returns:
        (name, sentence) in the order of removal.
    """
    before: dict[str, list[Mapping[str, Any]]] = {}
    holds: dict[str, list[Mapping[str, Any]]] = {}
    for dependency in order.get("dependencies", ()):
        before.setdefault(str(dependency["then"]), []).append(dependency)
        holds.setdefault(str(dependency["first"]), []).append(dependency)
    together = {
        str(name): [str(other) for other in group] for group in order.get("groups", ()) for name in group
    }
    targets = {str(name) for name in order.get("targets", ())}
    told: list[tuple[str, str]] = []
    done: set[str] = set()
    names = [str(name) for name in order.get("order", ())]
    explained = [line.partition(": ")[2] for line in order.get("explanation", ())]
    otherwise = explained if len(explained) == len(names) else [""] * len(names)
    for name, else_said in zip(names, otherwise, strict=True):
        ties = before.get(name, ()), holds.get(name, ()), together.get(name, ())
        why = "" if name in done else _sentence(name, *ties, targets, done)  # it made room, and comes back
        why = why or else_said or UNTIED
        told.append((name, f"{why}."))
        done.add(name)
    return told


def places(order: Document) -> dict[str, int]:
    """Name -> when it is moved first, from 1, of an order's document, in that order."""
    names = [str(name) for name in order.get("order", ())]
    return {name: names.index(name) + 1 for name in dict.fromkeys(names)}


def holds_in_words(order: Document) -> list[str]:
    """What to hold while an order is carried out, a sentence each, of a `topple.order` document."""
    holds = [
        Hold(
            str(hold["object"]),
            str(hold["since"]),
            str(hold["until"]),
            str(hold["because"]),
            fixture=bool(hold.get("fixture")),
        )
        for hold in order.get("holds", ())
    ]
    return [hold.sentence(order["order"]) for hold in holds]


def _sentence(
    name: str,
    before: Sequence[Mapping[str, Any]],
    holds: Sequence[Mapping[str, Any]],
    together: Sequence[str],
    targets: set[str],
    done: set[str],
) -> str:
    others = [other for other in together if other != name]
    parts: list[str] = []
    if needed := _by_reason(before, "first", done):
        earlier = list(dict.fromkeys(first for names in needed.values() for first in names))
        why = listed([because(first, reason) for reason, first in needed.items()])
        parts.append(f"after {listed(earlier)}, because {why}")
    if freed := _by_reason(holds, "then", None):
        parts.append(listed([because(["it"], reason, listed(then)) for reason, then in freed.items()]))
    if others:
        parts.append("taken or held together with " + listed(others))
    if name in targets:
        parts.append(TARGET)
    return "; ".join(parts)


def _by_reason(
    dependencies: Sequence[Mapping[str, Any]], end: str, among: set[str] | None
) -> dict[str, list[str]]:
    """Names at one end of dependencies, by reason, each once; only those in `among` where it is given."""
    names: dict[str, list[str]] = {}
    for dependency in dependencies:
        name, same = str(dependency[end]), names.setdefault(said(dependency), [])
        if name not in same and (among is None or name in among):
            same.append(name)
    return {reason: same for reason, same in names.items() if same}


def ordinal(place: int) -> str:
    """A place as English counts it: "1st", "2nd", "11th". Objects may be named by bare numbers."""
    ending = "th" if place % 100 in (11, 12, 13) else {1: "st", 2: "nd", 3: "rd"}.get(place % 10, "th")
    return f"{place}{ending}"


def sentence(text: str) -> str:
    """A text with its full stop, and a capital letter first unless that may belong to a name."""
    text = text.strip()
    begun = text[:1].upper() + text[1:] if text.startswith(_BEGINNINGS) else text
    return begun if begun.endswith((".", "!", "?", ":")) else f"{begun}."


def shortened(name: str) -> str:
    """A name cut to `LIMITS.label` characters, on one line."""
    line = " ".join(name.split()) or name.strip() or "(blank)"
    return line if len(line) <= LIMITS.label else line[: LIMITS.label - 1] + "…"


def listed(words: Sequence[str]) -> str:
    """Words as English lists them: "a", "a and b", "a, b and c"."""
    return words[0] if len(words) == 1 else ", ".join(words[:-1]) + " and " + words[-1] if words else ""


def sentences(text: Any) -> list[str]:
    """An explanation as lines, whether it came as one text or as several."""
    if text is None:
        return []
    lines = text.splitlines() if isinstance(text, str) else [str(line) for line in text]
    return [line.strip() for line in lines if line.strip()]


def millimetres(metres: float) -> str:
    """A length in millimetres, to a tenth below 10 mm."""
    value = metres * 1000
    return f"{rounded(value, 1 if abs(value) < 10 else 0)} mm"
