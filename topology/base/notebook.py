"""What a notebook's cell shows of an object: what the layer that draws makes of it, found by entry points."""

from collections.abc import Callable
from importlib.metadata import entry_points
from typing import Any

from topple.topology.base.errors import ToppleError

GROUP = "topple.notebook"
"""Entry points, one per type and under its name, that give its HTML."""


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
