"""What layers above know better how to show: a notebook's cell, names for numbers; found by entry points."""

from collections.abc import Callable
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
    for entry in entry_points(group=GROUP, name=type(thing).__name__):
        draw: Callable[[Any], str] = entry.load()
        try:
            return draw(thing)
        except ToppleError:
            return None
    return None


def in_words(scene: object, value: Value) -> Value:
    """Put what people call the objects of a scene in the place of bare numbers, for print.

    Args:
        scene: The scene.
        value: Texts, or tuples and lists of them.

    Returns:
        The same; as it is where nothing knows names, or none can be told.
    """
    for entry in entry_points(group=GROUP, name="names"):
        try:
            return entry.load()(scene, value)
        except ToppleError:
            return value
    return value
