"""What layers above know better how to show: a notebook's cell, names for numbers; found by entry points."""

from contextlib import suppress
from importlib.metadata import entry_points
from typing import Any, TypeVar

from topple.topology.base.errors import ToppleError

GROUP = "topple.notebook"
"""Entry points, one per type and under its name, that give its HTML; `names` puts names for numbers."""

Value = TypeVar("Value")


def in_cell(thing: object) -> str | None:
    """The HTML of an object for a notebook's cell.

    Args:
        thing: Something of which a layer above can draw a view.

    Returns:
        HTML; None where nothing draws it, or it cannot be drawn: the notebook then shows its text.
    """
    return _ask_entry_point(type(thing).__name__, None, thing)


def in_words(scene: object, value: Value) -> Value:
    """Put what people call the objects of a scene in the place of bare numbers, for print.

    Args:
        scene: The scene; None where it is not there any more.
        value: Texts, or tuples and lists of them.

    Returns:
        The same; as it is where nothing knows names, or none can be told.
    """
    return value if scene is None else _ask_entry_point("names", value, scene, value)


def _ask_entry_point(name: str, otherwise: Any, *asked: object) -> Any:
    """Call the entry point of a name; give `otherwise` where there is none or it cannot answer."""
    for entry in entry_points(group=GROUP, name=name):
        with suppress(ToppleError):
            return entry.load()(*asked)
    return otherwise
