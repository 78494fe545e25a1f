"""A dependency and an order said in plain words."""

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

from topple.planner.decide.hold import Hold
from topple.planner.decide.tolerances import GUESS, LABEL, SURELY
from topple.topology.base.arrays import FloatArray
from topple.topology.base.values import decimal

Document = Mapping[str, Any]

_BEGINNINGS = tuple(f"{word} " for word in "it the nothing a an no what bodies at after before from".split())
"""Words that sentences begin with; anything else may be the name of an object."""

UNTIED = "nothing depends on it, and it depends on nothing"
"""Said of what has no place of its own in an order."""

TARGET = "this is a target"

CHECK_HEADINGS = ("object", "verdict", "carried by", "centre mm", "tilt °", "push N", "falls with it")
"""Of a table with a row of `check_cells` for each object."""

MARGINS = ("centre_mm", "tilt_degrees", "push_newton")

WORDS = {
    "supported": "rests on",
    "leaning": "leans on",
    "contained": "is inside",
    "blocking": "blocks",
    "counterweight": "is balanced by",
    "measured": "moved with",
    "rests": "rests on",  # and of a support
    "leans": "leans on",
}
"""How an object that goes before lies to the one that goes after, in sentences, pictures and JSON alike."""


def because(first: Sequence[str], reason: str, then: str = "it") -> str:
    """Say why some objects have to go before another, as a clause such as "cup and spoon rest on it".

    Args:
        first: Names of those that go before, at least one.
        reason: Reason of these dependencies; an unknown one is quoted as it is.
        then: What goes after them, in the clause.
    """
    verb, _, rest = WORDS.get(reason, "goes before").partition(" ")
    if len(first) > 1:
        verb = {"is": "are", "goes": "go"}.get(verb, verb.removesuffix("s"))
    quoted = "" if reason in WORDS else f", {reason}"
    return " ".join(filter(None, (phrase(first), verb, rest, then))) + quoted


def how_sure(risk: float) -> str:
    """How sure it is that a step moves nothing else, as a word: risks are not good enough for figures."""
    return "sure" if risk < SURELY else "likely" if risk < GUESS else "guess"


def said(dependency: Mapping[str, Any]) -> str:
    """The reason of a dependency as a person says it: what leans on a plate may be said to rest on it."""
    lies = {"on": "supported", "in": "contained"}
    return lies.get(str(dependency.get("lies")), str(dependency["reason"]))


def order_in_words(order: Document) -> list[tuple[str, str]]:
    """Each object of a `topple.order` document with the reason for its place, in the order of removal."""
    names = [str(name) for name in order.get("order", ())]
    explained = [line.partition(": ")[2] for line in order.get("explanation", ())]
    told: list[tuple[str, str]] = []
    for place, name in enumerate(names):
        why = (
            "" if name in names[:place] else _reason(order, name, names[:place])
        )  # it made room, and is back
        why = why or (explained[place] if len(explained) == len(names) else "") or UNTIED
        told.append((name, f"{why}."))
    return told


def order_heading(order: Document, movable: int | None = None) -> str:
    """Say what a `topple.order` document frees or builds, and how many objects that takes."""
    if order.get("build"):
        return f"to build it, put {len(order['order'])} objects down in this order"
    purpose = f"to free {phrase(order['targets'])}" if order["targets"] else "to clear everything"
    count = len(dict.fromkeys(order["order"]))
    return (
        f"{purpose}, take {count}{'' if movable is None else f' of {movable} movable'} objects in this order"
    )


def order_rows(order: Document) -> list[tuple[str, ...]]:
    """A row for each step of a `topple.order` document: number, object, why, and how sure it is."""
    told, risk, at = order_in_words(order), order.get("risk") or {}, places(order)
    look, hidden = order.get("next_view") or {"shows": ()}, dict[str, list[str]]()
    for pair in look["shows"][:3]:
        first, other = sorted((pair["a"], pair["b"]), key=lambda name: at.get(name, len(at) + 1))
        if first in at and how_sure(risk.get(first) or 0.0) != "sure":
            hidden.setdefault(first, []).append(other)
    for first, others in hidden.items():
        why = f"{told[at[first] - 1][1]} Look {look['from']}: where it meets {phrase(others)} is hidden."
        told[at[first] - 1] = (first, why)
    if order.get("build"):
        told = [*zip(order["order"], (x.partition(": ")[2] for x in order["explanation"]), strict=True)]
    return [(str(i), name, why, how_sure(risk.get(name) or 0.0)) for i, (name, why) in enumerate(told, 1)]


def first_rows(order: Document, most: int = 5) -> tuple[list[tuple[str, ...]], list[str]]:
    """The first rows of an order, and in words how many more there are and which contacts are weakest."""
    rows = order_rows(order)
    left = len(rows) - most
    told = [f"and {left} more"] if left > 0 else []
    if supports := sorted(order.get("supports") or (), key=lambda each: float(each["confidence"])):
        weak = [f"{contact(order, each)} ({float(each['confidence']):.2f})" for each in supports[:2]]
        told.append(f"Weakest contact{'s' * (len(weak) > 1)}: {phrase(weak)}.")
    return rows[:most], told


def contact(order: Document, support: Document, shown: Callable[[str], str] = str) -> str:
    """Say what carries what, as "can rests on plate", with names as they are to be shown."""
    lower, upper, kind = (
        str(support["supporter"]),
        str(support["supported"]),
        str(support.get("kind", "rests")),
    )
    for tie in order.get("dependencies", ()):
        if kind == "leans" and (tie["then"], tie["first"]) == (lower, upper):
            kind = said(tie)
    return f"{shown(upper)} {WORDS.get(kind, kind)} {shown(lower)}"


def order_notes(order: Document) -> list[str]:
    """Say what to hold, or take together, to carry an order out, a sentence each."""
    lines = [
        f"{phrase(x)} hold each other: take them together, or hold the others."
        for x in order.get("groups", ())
    ]
    for hold, words in zip(order.get("holds", ()), holds_in_words(order), strict=True):
        lines.append(f"With {'the fixture' if hold.get('fixture') else 'a second hand'}, {words}.")
    if "next_view" in order:
        lines.append(_look(order["next_view"]))
    return lines


def _look(view: Document | None) -> str:
    """From where to look next, and what that shows."""
    if view is None:
        return "Next view: none would show anything more that the order depends on."
    eye, target = ("(" + ", ".join(f"{value:.2f}" for value in view[key]) + ")" for key in ("eye", "target"))
    told = phrase([f"{one['a']} meets {one['b']}" for one in view["shows"][:3]])
    share = f"{100 * view['worth']:.0f} % of the hidden places that matter"
    return f"Next view: {view['from']}, {eye} towards {target} m, shows {share}: whether {told}."


def side_of(way: FloatArray, right: FloatArray, up: FloatArray) -> str:
    """Say from which side a place looks at what a camera looked at before, as that camera has it.

    Args:
        way: (3,) to the place from what it looks at [m].
        right: (3,) to the right in the camera's picture.
        up: (3,) unit vector.
    """
    across = right - up * float(right @ up)
    across /= np.linalg.norm(across)
    aside, behind, high = float(way @ across), float(way @ np.cross(up, across)), float(way @ up)
    if high > 2.0 * np.hypot(aside, behind):  # by more than 63 degrees
        return "from above"
    if abs(aside) > abs(behind):
        return "from the right" if aside > 0 else "from the left"
    return "from behind" if behind > 0 else "from the front"


def places(order: Document) -> dict[str, int]:
    """Name -> when it is moved first, from 1, of an order's document, in that order."""
    names = [str(name) for name in order.get("order", ())]
    return {name: names.index(name) + 1 for name in dict.fromkeys(names)}


def holds_in_words(order: Document) -> list[str]:
    """Say what to hold while an order is carried out, a sentence each, of a `topple.order` document."""
    told: list[str] = []
    for hold in order.get("holds", ()):
        thing, since, until, why = (str(hold[key]) for key in ("object", "since", "until", "because"))
        told.append(
            Hold(thing, since, until, why, fixture=bool(hold.get("fixture"))).sentence(order["order"])
        )
    return told


def _reason(order: Document, name: str, done: Sequence[str]) -> str:
    """Why an object goes where it does in an order, some of which is done; empty where nothing ties it."""
    parts: list[str] = []
    if needed := _by_reason(order, name, "then", done):
        earlier = list(dict.fromkeys(first for names in needed.values() for first in names))
        why = phrase([because(first, reason) for reason, first in needed.items()])
        parts.append(f"after {phrase(earlier)}, because {why}")
    if freed := _by_reason(order, name, "first", None):
        parts.append(phrase([because(["it"], reason, phrase(then)) for reason, then in freed.items()]))
    for group in order.get("groups", ()):
        if name in (names := [str(other) for other in group]) and len(names) > 1:
            parts.append("taken or held together with " + phrase([other for other in names if other != name]))
    if name in [str(target) for target in order.get("targets", ())]:
        parts.append(TARGET)
    return "; ".join(parts)


def _by_reason(order: Document, name: str, end: str, among: Sequence[str] | None) -> dict[str, list[str]]:
    """Names at the other end of an object's dependencies, by reason, each once; only some where given."""
    names: dict[str, dict[str, None]] = {}
    for dependency in order.get("dependencies", ()):
        other = str(dependency["first" if end == "then" else "then"])
        if str(dependency[end]) == name and (among is None or other in among):
            names.setdefault(said(dependency), {})[other] = None
    return {reason: list(same) for reason, same in names.items()}


def number_of(number: int, thing: str) -> str:
    """A number of things: "1 step", "2 steps"."""
    return f"{number} {thing}{'' if number == 1 else 's'}"


def ordinal(place: int) -> str:
    """A place as English counts it: "1st", "2nd", "11th". Objects may be named by bare numbers."""
    ending = "th" if place % 100 in (11, 12, 13) else {1: "st", 2: "nd", 3: "rd"}.get(place % 10, "th")
    return f"{place}{ending}"


def sentence(text: str) -> str:
    """A text with its full stop, and a capital letter first unless that may belong to a name."""
    text = text.strip()
    begun = text[:1].upper() + text[1:] if text.startswith(_BEGINNINGS) else text
    return begun if begun.endswith((".", "!", "?", ":")) else f"{begun}."


def shorten(name: str) -> str:
    """A name cut to `LABEL` characters, on one line."""
    line = " ".join(name.split()) or name.strip() or "(blank)"
    return line if len(line) <= LABEL else line[: LABEL - 1] + "…"


def phrase(words: Sequence[str]) -> str:
    """Words as English lists them: "a", "a and b", "a, b and c"."""
    return words[0] if len(words) == 1 else ", ".join(words[:-1]) + " and " + words[-1] if words else ""


def sentences(text: Any) -> list[str]:
    """An explanation as lines, whether it came as one text or as several."""
    lines = (text or "").splitlines() if text is None or isinstance(text, str) else map(str, text)
    return [line.strip() for line in lines if line.strip()]


def millimetres(metres: float) -> str:
    """A length in millimetres, to a tenth below 10 mm."""
    value = metres * 1000
    return f"{decimal(value, 1 if abs(value) < 10 else 0)} mm"


def check_cells(found: Document) -> tuple[str, ...]:
    """Say of an object of a `topple.check` document what becomes of it, what carries it and by how much."""
    margins = found.get("margins", {})
    carried = ", ".join(f"{each['object']} {each['newton']:.3g} N" for each in found.get("carried_by", ()))
    far = f" {found['mm']:.2g} mm" if "mm" in found else ""
    others = f" ({', '.join(found['others'])})" if found.get("others") and not found["stands"] else ""
    return (
        found["object"],
        found["verdict"] + far + others,
        carried + (" by friction" if found.get("by_friction") else ""),
        *(f"{margins[key]:.3g}" if key in margins else "" for key in MARGINS),
        ", ".join(found.get("falls_with", ())),
    )
