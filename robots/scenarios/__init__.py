"""Built-in scenes: settled worlds with cameras, a robot's place and a task, each made from a seed."""

import sys
from collections.abc import Callable
from functools import partial

from topple.robots.scenarios.dishes import dishes
from topple.robots.scenarios.hold import hold
from topple.robots.scenarios.lemon import lemon_in_bowl
from topple.robots.scenarios.pack import pack
from topple.robots.scenarios.pile import pile
from topple.robots.scenarios.restack import restack
from topple.robots.scenarios.scenario import Scenario
from topple.robots.scenarios.set_table import set_table
from topple.robots.scenarios.shelf import shelf
from topple.robots.scenarios.sort import sort
from topple.robots.scenarios.swap import swap
from topple.robots.scenarios.tower import tower
from topple.topology.base.plugins import Table

SCENARIOS: Table[Callable[[int], Scenario]] = Table(
    "topple.scenarios",
    "scene",
    {
        "dishes": "topple.robots.scenarios.dishes:dishes",
        "lemon": "topple.robots.scenarios.lemon:lemon_in_bowl",
        "tower": "topple.robots.scenarios.tower:tower",
        "pile": "topple.robots.scenarios.pile:pile",
        "sort": "topple.robots.scenarios.sort:sort",
        "set-table": "topple.robots.scenarios.set_table:set_table",
        "restack": "topple.robots.scenarios.restack:restack",
        "pack": "topple.robots.scenarios.pack:pack",
        "swap": "topple.robots.scenarios.swap:swap",
        "hold": "topple.robots.scenarios.hold:hold",
        "shelf": "topple.robots.scenarios.shelf:shelf",
    },
    Scenario,
)
"""Every scenario by its name, to be called with a seed; other packages add theirs."""

__all__ = [
    "SCENARIOS", "Scenario", "describe", "dishes", "hold", "lemon_in_bowl", "pack", "pile", "restack",
    "set_table", "shelf", "sort", "swap", "tower",
]  # fmt: skip


def describe(name: str) -> str:
    """Describe a scene in a line: the first of its module.

    Raises:
        InvalidInput: If there is no such scene.
    """
    made = SCENARIOS[name]
    function = made.args[-1] if isinstance(made, partial) else made  # another package's, and topple's own
    return (sys.modules[function.__module__].__doc__ or "").partition("\n")[0]
