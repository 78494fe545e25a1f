"""A dependency and an order said in plain words."""

from collections.abc import Mapping, Sequence
from typing import Any

Document = Mapping[str, Any]

_BECAUSE = {
    "supported": ("rests on it", "rest on it"),
    "leaning": ("leans on it", "lean on it"),
    "contained": ("lies in it", "lie in it"),
    "blocking": ("would be lifted or dragged along", "would be lifted or dragged along"),
    "counterweight": ("tips once its weight is gone", "tip once its weight is gone"),
}
"""What an object that goes before does to the one that goes after: said of one, said of several."""


def because(first: Sequence[str], reason: str) -> str:
    """Why some objects have to go before the one spoken of, as a clause.

    Args:
        first: Names of those that go before, at least one.
        reason: Reason of these dependencies.

    Returns:
        A clause such as "cup and spoon rest on it"; an unknown reason is quoted as it is.
    """
    one, several = _BECAUSE.get(reason, (f"goes before it ({reason})", f"go before it ({reason})"))
    return f"{listed(first)} {one if len(first) == 1 else several}"


def order_in_words(order: Document) -> list[tuple[str, str]]:
    """Each object of an order with the reason for its place.

    Args:
        order: A `topple.order` document.

    Returns:
        (name, sentence) in the order of removal.
    """
    before: dict[str, list[Mapping[str, Any]]] = {}
    holds: dict[str, list[str]] = {}
    for dependency in order.get("dependencies", ()):
        before.setdefault(str(dependency["then"]), []).append(dependency)
        holds.setdefault(str(dependency["first"]), []).append(str(dependency["then"]))
    together = {
        str(name): [str(other) for other in group] for group in order.get("groups", ()) for name in group
    }
    targets = {str(name) for name in order.get("targets", ())}
    told: list[tuple[str, str]] = []
    done: set[str] = set()
    for name in map(str, order.get("order", ())):
        told.append(
            (
                name,
                _sentence(
                    name, before.get(name, ()), holds.get(name, ()), together.get(name, ()), targets, done
                ),
            )
        )
        done.add(name)
    return told


def _sentence(
    name: str,
    before: Sequence[Mapping[str, Any]],
    holds: Sequence[str],
    together: Sequence[str],
    targets: set[str],
    done: set[str],
) -> str:
    others = [other for other in together if other != name]
    needed: dict[str, list[str]] = {}
    for dependency in before:
        if (first := str(dependency["first"])) in done:
            needed.setdefault(str(dependency["reason"]), []).append(first)
    if needed:
        parts = [listed([because(list(dict.fromkeys(first)), reason) for reason, first in needed.items()])]
        earlier = list(dict.fromkeys(first for names in needed.values() for first in names))
        parts = [f"after {listed(earlier)}, because {parts[0]}"]
    else:
        parts = ["nothing has to go before it"]
    if others:
        parts.append("taken or held together with " + listed(others))
    elif name in targets:
        parts.append("this is a target")
    elif holds:
        parts.append("frees " + listed(list(dict.fromkeys(holds))))
    return "; ".join(parts) + "."


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
    return f"{value:.1f} mm" if abs(value) < 10 else f"{value:.0f} mm"
