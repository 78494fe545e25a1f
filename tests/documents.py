"""What no document may contradict: its order against its own dependencies, its first against what is done."""

from collections.abc import Mapping, Sequence
from itertools import combinations
from typing import Any


def contradictions(document: Mapping[str, Any], moved: Sequence[str]) -> list[str]:
    """What a document of an order or of a plan says against itself, or against what was moved.

    Args:
        document: With `order` and `dependencies`, and `groups` where things hold each other.
        moved: What the arm moved, first to move first: an order goes on from there, or ends there.
    """
    order: list[str] = document["order"]
    turn = {name: order.index(name) for name in order}
    together = {pair for group in document.get("groups", ()) for pair in combinations(sorted(group), 2)}
    said: list[str] = []
    for edge in document["dependencies"]:
        first, then = edge["first"], edge["then"]
        if then in turn and (first, then) not in together and (then, first) not in together:
            if turn.get(first, len(order)) > turn[then]:
                said.append(f"{then} stands before {first}, or without it: {order}")
    if order[: len(moved)] != list(moved):
        said.append(f"{moved} moved, and the order is {order}")
    return said
