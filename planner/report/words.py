"""A dependency and an order said in plain words."""

from collections.abc import Mapping, Sequence
from typing import Any

Document = Mapping[str, Any]

_BECAUSE = {
    "supported": "{first} rests on it",
    "leaning": "{first} leans on it",
    "contained": "{first} lies in it",
    "blocking": "{first} would be lifted or dragged along",
    "counterweight": "{first} tips once its weight is gone",
}


def because(first: str, reason: str) -> str:
    """Why `first` has to go before the object spoken of, as a clause.

    Args:
        first: Name of the object that goes before.
        reason: Reason of the dependency.

    Returns:
        A clause such as "spoon rests on it"; an unknown reason is quoted as it is.
    """
    return _BECAUSE.get(reason, "{first} goes before it (" + reason + ")").format(first=first)


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
    needed = [dependency for dependency in before if str(dependency["first"]) in done]
    parts: list[str] = []
    if needed:
        clauses = [because(str(dependency["first"]), str(dependency["reason"])) for dependency in needed]
        parts.append(
            "after "
            + listed(list(dict.fromkeys(str(dependency["first"]) for dependency in needed)))
            + ": "
            + listed(clauses)
        )
    else:
        parts.append("nothing has to go before it")
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
